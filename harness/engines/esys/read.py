"""Read what a script left: its last words, and the table of the motion."""

from __future__ import annotations

import io
import re

import numpy as np
from numpy.typing import NDArray

from harness.cases.drop.parameters import Drop
from harness.cases.tower.motion import forces_of_contacts, tower_run
from harness.engines.process import Ended, last_words
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineNaNError,
    EngineOutputError,
)
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.observables.trajectory import Trajectory
from harness.parameters.tower import Tower

Floats = NDArray[np.float64]

WHO = "ESyS-Particle"
LAST_RESULT = "RESULT verdict = "
"""Words without this line are those of a run that did not finish."""

ROUNDINGS = 4
"""A force below so many roundings of its particles' velocities is none."""


def error_of(ended: Ended, limit: float) -> EngineError | None:
    """Return the error that the end of a run speaks of, or None; ``limit`` [s] is its time."""
    raised = re.findall(r"^(\w*(?:Error|Exception)\b.*)$", ended.said, re.MULTILINE)
    if raised and not ended.timed_out and "MemoryError" not in ended.said:
        return EngineInputError(f"{WHO} refused its input: {raised[-1][:160]}")
    died = ended.error(WHO, limit)
    if died is None and LAST_RESULT not in ended.said:
        return EngineOutputError(f"{WHO} ended without a result{last_words(ended.said)}")
    return died


def read_drop(case: Drop, series: str) -> Trajectory:
    """Return the path of a drop; raise EngineOutputError for one that is cut short."""
    table = _table(series, 5)
    rows = case.steps // case.every + 1
    if len(table) != rows:
        raise EngineOutputError(f"{WHO} left {len(table)} rows of a series of {rows}")
    return Trajectory(*table.T)


def read_paths(series: str, grains: int) -> list[Trajectory]:
    """Return the paths of the grains that ran side by side."""
    table = _table(series, 1 + 4 * grains)
    time = table[:, 0]
    return [Trajectory(time, *table[:, 1 + 4 * i : 5 + 4 * i].T) for i in range(grains)]


def read_tower(
    case: Tower, step: float, samples: int, series: str, who: Provenance, profiles: bool = False
) -> TowerRun:
    """Return the run that the table of a tower tells of (``step,id,x,vx,fx``).

    Raise EngineOutputError for a table that is cut, EngineNaNError for values
    that are not finite.
    """
    flat = _table(series, 5)
    if len(flat) != (samples + 1) * case.particles:
        raise EngineOutputError(
            f"{WHO} left {len(flat)} rows of a series of {(samples + 1) * case.particles}"
        )
    table = flat.reshape(samples + 1, case.particles, 5)
    steps, x, v, f = table[:, 0, 0], table[:, :, 2], table[:, :, 3], table[:, :, 4]
    mass, diameter = case.each("mass")[0], case.each("diameter")[0]
    displacement = x - diameter * np.arange(case.particles)
    # a force is the change of a velocity in a step, and a contact's the sum of those before it
    rounding = ROUNDINGS * case.particles * np.finfo(float).eps
    smallest = rounding * (
        mass / step * float(np.abs(v).max()) + case.each("stiffness")[0] * float(np.abs(x).max())
    )
    force = forces_of_contacts(f, mass * case.gravity, smallest)
    return tower_run(case, step, steps * step, displacement, v, force, who, profiles=profiles)


def _table(series: str, columns: int) -> Floats:
    """Return the rows of a series; raise EngineOutputError for a damaged one."""
    lines = series.splitlines()
    if len(lines) < 2 or not series.endswith("\n"):
        raise EngineOutputError(f"{WHO} left a series of {len(lines)} lines, the last one cut")
    try:
        table = np.loadtxt(io.StringIO(series), delimiter=",", skiprows=1, ndmin=2)
    except ValueError as error:
        raise EngineOutputError(f"{WHO} left an incomplete series ({error})") from None
    if table.shape[1] != columns:
        raise EngineOutputError(f"{WHO} left {table.shape[1]} columns of {columns}")
    if not np.isfinite(table).all():
        raise EngineNaNError(f"{WHO} wrote a series with values that are not numbers")
    return table
