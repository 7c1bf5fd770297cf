"""Read what a generated Yade script left: the lines RESULT, the path, the motion of a tower."""

from __future__ import annotations

import io
import math
import re

import numpy as np
from numpy.typing import NDArray

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Crests, InclineRun, Motion
from harness.cases.tower.motion import tower_run
from harness.cases.tower.timing import Plan
from harness.errors import EngineNaNError, EngineOutputError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.observables.trajectory import Trajectory
from harness.parameters.tower import Tower

Floats = NDArray[np.float64]

_RESULT = re.compile(r"^RESULT (\w+) = (.*)$", re.MULTILINE)

LAST_RESULT = "RESULT verdict = "
"""Results without this line are those of a run that did not finish."""

ROUNDINGS = 4
"""A contact pressed in by fewer roundings of a position cannot be told from an open one."""


def read_incline(
    case: Incline, results: str, who: Provenance, series: str = "", every: int | None = None
) -> InclineRun:
    """Return the run that a script's results tell of, with its path if sampled every so many steps.

    Raise EngineOutputError when something is missing, EngineNaNError when a number is not
    finite.
    """
    pairs = _RESULT.findall(results)
    values = dict(pairs)
    rows = [[float(word) for word in text.split()] for name, text in pairs if name == "crest"]
    try:
        crests = np.array(rows).reshape(-1, 4)
        steps = int(values["steps"])
        return InclineRun(
            case=case,
            margin_J=_number(values, "margin_J"),
            motion=Motion(values["verdict"]),
            touching=values["touching"] == "1",
            crests=Crests(time_s=crests[:, 1], margin_J=crests[:, 2]),
            time_s=_number(values, "time_s"),
            steps=steps,
            seconds=_number(values, "seconds"),
            provenance=who,
            trajectory=None if every is None else _path(series, steps // every + 1),
        )
    except (KeyError, ValueError) as error:
        raise EngineOutputError(f"Yade left an incomplete result ({error})") from None


def read_drop(case: Drop, results: str, series: str, who: Provenance) -> DropRun:
    """Return the drop that a series tells of; errors as for :func:`read_incline`."""
    try:
        seconds = _number(dict(_RESULT.findall(results)), "seconds")
    except (KeyError, ValueError) as error:
        raise EngineOutputError(f"Yade left an incomplete result ({error})") from None
    return DropRun(case, _path(series, case.steps // case.every + 1), seconds, who)


def read_tower(
    case: Tower, timing: Plan, series: str, who: Provenance, profiles: bool = False
) -> TowerRun:
    """Return the run that a series of places, velocities and contact forces tells of.

    The forces are Yade's own. Errors as for :func:`read_incline`.
    """
    count = case.particles
    table = _table(series, 3 * count, timing.steps // timing.every + 1)
    time, x, v, force = np.split(table, [1, 1 + count, 1 + 2 * count], axis=1)
    displacement = x - case.each("diameter")[0] * np.arange(count)
    resolution = ROUNDINGS * np.finfo(float).eps * float(np.abs(x).max())
    force[force <= resolution * case.each("stiffness")[0]] = 0.0
    return tower_run(case, timing.step, time[:, 0], displacement, v, force, who, profiles=profiles)


def _path(series: str, rows: int) -> Trajectory:
    return Trajectory(*_table(series, 5, rows).T)


def _table(series: str, columns: int, count: int) -> Floats:
    """Return a series as numbers (count, columns), times in order."""
    lines = series.count("\n")
    if not series.endswith("\n") or lines != count + 1:
        raise EngineOutputError(f"Yade wrote a series of {lines} lines, not {count + 1}")
    try:
        rows = np.loadtxt(io.StringIO(series), delimiter=",", skiprows=1, ndmin=2)
    except ValueError as error:
        raise EngineOutputError(f"Yade wrote a series that cannot be read ({error})") from None
    if rows.shape != (count, columns):
        raise EngineOutputError(f"Yade wrote {rows.shape[1]} columns, not {columns}")
    if not np.isfinite(rows).all():
        raise EngineNaNError("Yade wrote a series with values that are not numbers")
    if np.any(np.diff(rows[:, 0]) <= 0.0):
        raise EngineOutputError("Yade wrote a series that is out of order")
    return rows


def _number(values: dict[str, str], name: str) -> float:
    value = float(values[name])
    if not math.isfinite(value):
        raise EngineNaNError(f"Yade returned {name} = {values[name]}")
    return value
