"""Read what a generated script left: RESULT lines, series, last words."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harness.cases.tower.motion import forces_of_contacts, tower_run
from harness.cases.tower.timing import Plan
from harness.engines.process import Ended, last_words
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
)
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.observables.trajectory import Trajectory
from harness.parameters.tower import Tower

Floats = NDArray[np.float64]

LAST_RESULT = "verdict"
"""A run without this result did not finish."""

FAREWELL = "Deregistering "
"""How the lines begin that Kratos prints at its end, whatever it was."""

PATH_COLUMNS = 5
ROUNDINGS = 8.0
"""[eps] of the positions, below which a contact force is rounding."""

_RESULT = re.compile(r"^RESULT (\w+) = (.*)$", re.MULTILINE)


def finished(log: str) -> bool:
    """Return whether the last of the RESULT lines is there."""
    return LAST_RESULT in dict(_RESULT.findall(log))


def seconds_in(log: str) -> float:
    """Return the wall time [s] that a finished run names, the start of Python left out."""
    return float(dict(_RESULT.findall(log))["seconds"])


def without_farewell(said: str) -> str:
    """Return what a process said without the lines that Kratos ends with."""
    lines = said.splitlines()
    return "\n".join(line for line in lines if not line.startswith(FAREWELL))


def error_of(ended: Ended, limit: float, install_hint: str) -> EngineError:
    """Return what the end of a process speaks of, which left a run unfinished.

    ``limit`` [s] is the time that a run was given, ``install_hint`` how to get Kratos.
    """
    said = without_farewell(ended.said)
    error: EngineError | None
    if not ended.timed_out and re.search(r"^(?:ModuleNotFound|Import)Error: ", said, re.MULTILINE):
        error = EngineMissingError(f"no Kratos{last_words(said)}; get it with: {install_hint}")
    elif not ended.timed_out and "is not a number" in said:
        error = EngineNaNError(f"Kratos met a value that is not a number{last_words(said)}")
    elif not ended.timed_out and (refused := _refusal(said)):
        error = EngineInputError(f"Kratos refused its input: {refused}")
    else:
        error = replace(ended, said=said).error("Kratos", limit)
    if error is None:
        error = EngineOutputError(f"Kratos ended without a result{last_words(said)}")
    error.log = said
    return error


def read_path(series: str, rows: int | None = None) -> Trajectory:
    """Return the grain's path, of so many rows if that is known.

    Raise EngineOutputError for rows that are cut or missing, EngineNaNError for values
    that are not finite.
    """
    return Trajectory(*_table(series, PATH_COLUMNS, rows).T)


def read_tower(
    case: Tower,
    timing: Plan,
    series: str,
    who: Provenance,
    profiles: bool = False,
) -> TowerRun:
    """Return the run of a tower, positions along the motion and contact forces in its series.

    Errors as for :func:`read_path`.
    """
    n = case.particles
    table = _table(series, 1 + 3 * n, timing.steps // timing.every + 1)
    x, v, f = np.split(table[:, 1:], 3, axis=1)
    displacement = x - case.each("diameter")[0] * np.arange(n)
    resolution = ROUNDINGS * np.finfo(float).eps * float(np.abs(x).max())
    # the series has the forces of the contacts alone: no weight to take off
    force = forces_of_contacts(f, 0.0, resolution * case.each("stiffness")[0])
    return tower_run(case, timing.step, table[:, 0], displacement, v, force, who, profiles=profiles)


def _table(series: str, columns: int, rows: int | None) -> Floats:
    """Return the rows of a series, shape (rows, columns)."""
    lines = series.splitlines()
    wanted = max(len(lines) - 1, 1) if rows is None else rows
    if not series.endswith("\n") or len(lines) != wanted + 1:
        raise EngineOutputError(f"Kratos wrote {len(lines)} lines of a series, not {wanted + 1}")
    try:
        table = np.loadtxt(lines, delimiter=",", skiprows=1, ndmin=2)
        if table.shape[1] != columns:
            raise ValueError(f"{table.shape[1]} columns instead of {columns}")
    except ValueError as error:
        raise EngineOutputError(f"Kratos wrote a series that cannot be read ({error})") from None
    if not np.isfinite(table).all():
        raise EngineNaNError("Kratos wrote a series with values that are not numbers")
    return table


def _refusal(said: str) -> str:
    """Return Kratos's own message of an error, or nothing: it is long, and starts the same."""
    found = re.search(r"^RuntimeError: (?:Error: )?(.*)$", said, re.MULTILINE)
    return found.group(1).strip()[:160] if found else ""
