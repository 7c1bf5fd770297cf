"""Read the dump of a tower: positions, velocities and forces of all particles, as a TowerRun."""

from __future__ import annotations

import io

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.errors import EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance
from harness.observables.tower import Profiles, TowerRun
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
    steps, table = _table(dump, case.particles)
    mass, gravity = case.each("mass")[0], case.gravity
    x, v, f = table[:, :, 1], table[:, :, 2], table[:, :, 3]
    displacement = x - case.each("diameter")[0] * np.arange(case.particles)
    resolution = ROUNDINGS * np.finfo(float).eps * float(np.abs(x).max())
    force = _contact_forces(f, mass * gravity, resolution * case.each("stiffness")[0])
    overlap = displacement[:, :-1] - displacement[:, 1:]
    weight = np.full(case.particles, gravity)
    if case.base == "fixed":
        weight[-1] = 0.0
    return TowerRun(
        tower=case,
        solver="lammps",
        step=step,
        time=steps * step,
        grain_displacement=displacement[:, 0],
        grain_velocity=v[:, 0],
        grain_force=force[:, 0],
        contacts=_chain_of_grain(force),
        compression=displacement[:, 0] - displacement[:, -1],
        compression_rate=v[:, 0] - v[:, -1],
        kinetic_energy=0.5 * mass * np.sum(v**2, axis=1),
        elastic_energy=0.5 * np.sum(force * overlap, axis=1),
        gravitational_energy=-mass * displacement @ weight,
        momentum=mass * np.sum(v, axis=1),
        base_force=force[:, -1],
        final_displacement=displacement[-1],
        final_velocity=v[-1],
        profiles=Profiles(displacement, v, force) if profiles else None,
        provenance=who,
    )


def _table(dump: str, particles: int) -> tuple[Floats, Floats]:
    """Return the steps (M,) and the rows (M, particles, 4) of a dump."""
    lines = dump.splitlines()
    block = HEADER_LINES + particles
    if not lines or len(lines) % block:
        raise EngineOutputError(f"LAMMPS wrote {len(lines)} lines of dump, not blocks of {block}")
    try:
        steps = np.array([float(line) for line in lines[1::block]])
        starts = range(HEADER_LINES, len(lines), block)
        rows = "\n".join(line for i in starts for line in lines[i : i + particles])
        columns = pd.read_csv(io.StringIO(rows), sep=r"\s+", header=None, dtype=np.float64)
        table = columns.to_numpy().reshape(len(steps), particles, -1)
        if table.shape[2] != COLUMNS:
            raise ValueError(f"{table.shape[2]} columns instead of {COLUMNS}")
    except ValueError as error:
        raise EngineOutputError(f"LAMMPS wrote a dump that cannot be read ({error})") from None
    if not np.isfinite(table).all():
        raise EngineNaNError("LAMMPS wrote positions, velocities or forces that are not numbers")
    return steps, table


def _contact_forces(force: Floats, weight: float, smallest: float) -> Floats:
    """Return the contact forces (M, n) from the forces on the particles (M, N), grain first.

    LAMMPS's own forces, whatever law made them: particle i feels its weight,
    is pushed on by contact i - 1 and held by contact i. What is below
    ``smallest`` [N] is rounding.
    """
    contact = np.cumsum(weight - force[:, :-1], axis=1)
    contact[np.abs(contact) <= smallest] = 0.0
    return np.asarray(contact)


def _chain_of_grain(force: Floats) -> Floats:
    """Return how many contacts from the grain on press (M,)."""
    pressing = np.cumprod(force > 0.0, axis=1).sum(axis=1)
    return np.asarray(pressing, dtype=np.float64)
