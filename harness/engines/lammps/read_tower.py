"""Read the dump of a tower: positions, velocities and forces of all particles, as a TowerRun."""

from __future__ import annotations

import io

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.cases.tower.motion import forces_of_contacts, tower_run
from harness.errors import EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

Floats = NDArray[np.float64]

HEADER_LINES = 9
COLUMNS = 4
ROUNDINGS = 4
"""A contact pressed in by fewer roundings of a position cannot be told from an open one."""


def read_tower(
    case: Tower, step: float, dump: str, who: Provenance, profiles: bool = False
) -> TowerRun:
    """Return the run that a LAMMPS dump (``id x vx fx``, sorted) tells of.

    Raise EngineOutputError for a dump that is cut, EngineNaNError for values
    that are not finite.
    """
    steps, table = _table(dump, case.particles, who.engine.upper())
    weight = case.each("mass")[0] * case.gravity
    x, v, f = table[:, :, 1], table[:, :, 2], table[:, :, 3]
    displacement = x - case.each("diameter")[0] * np.arange(case.particles)
    resolution = ROUNDINGS * np.finfo(float).eps * float(np.abs(x).max())
    force = forces_of_contacts(f, weight, resolution * case.each("stiffness")[0])
    return tower_run(case, step, steps * step, displacement, v, force, who, profiles=profiles)


def _table(dump: str, particles: int, who: str) -> tuple[Floats, Floats]:
    """Return the steps (M,) and the rows (M, particles, 4) of a dump."""
    lines = dump.splitlines()
    block = HEADER_LINES + particles
    if not lines or len(lines) % block:
        raise EngineOutputError(f"{who} wrote {len(lines)} lines of dump, not blocks of {block}")
    try:
        steps = np.array([float(line) for line in lines[1::block]])
        starts = range(HEADER_LINES, len(lines), block)
        rows = "\n".join(line for i in starts for line in lines[i : i + particles])
        columns = pd.read_csv(io.StringIO(rows), sep=r"\s+", header=None, dtype=np.float64)
        table = columns.to_numpy().reshape(len(steps), particles, -1)
        if table.shape[2] != COLUMNS:
            raise ValueError(f"{table.shape[2]} columns instead of {COLUMNS}")
    except ValueError as error:
        raise EngineOutputError(f"{who} wrote a dump that cannot be read ({error})") from None
    if not np.isfinite(table).all():
        raise EngineNaNError(f"{who} wrote positions, velocities or forces that are not numbers")
    return steps, table
