"""Read what a generated script left: RESULT lines of the log, the series, error messages."""

from __future__ import annotations

import io
import math
import re

import numpy as np

from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import Crests, InclineRun, Motion
from harness.engines.process import last_words, way_of_death
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
)
from harness.observables.provenance import Provenance
from harness.observables.trajectory import Trajectory

_RESULT = re.compile(r"^RESULT (\w+) = (.*)$", re.MULTILINE)

_ERROR = re.compile(r"\bERROR(?: on proc \d+)?:")
"""LAMMPS's own, not that of a library below it."""

_OUT_OF_MEMORY = (
    r"failed to (re)?allocate|bad_alloc|MemoryError|out of memory"
    r"|cannot allocate memory|failed to map segment|can't start new thread"
)

LAST_RESULT = "\nRESULT verdict = "
"""A log without this line is that of a run that did not finish. A log echoes comments and commands
that name it, but not from the first column on."""


def read_incline(
    case: Incline, log: str, series: str | None, seconds: float, provenance: Provenance
) -> InclineRun:
    """Return the run that a log tells of.

    Raise EngineOutputError when a line is missing, EngineNaNError when a
    number is not finite.
    """
    who = provenance.engine.upper()
    results = _RESULT.findall(log)
    values = dict(results)
    rows = [text.split() for name, text in results if name == "crest"]
    try:
        crests = np.array([[_number(who, "crest", word) for word in row] for row in rows])
        crests = crests.reshape(-1, 4)
        return InclineRun(
            case=case,
            motion=Motion(values["verdict"]),
            margin_J=_number(who, "margin_J", values["margin_J"]),
            touching=values["touching"] == "1",
            crests=Crests(time_s=crests[:, 1], margin_J=crests[:, 2]),
            time_s=_number(who, "time_s", values["time_s"]),
            steps=int(values["steps"]),
            seconds=seconds,
            provenance=provenance,
            trajectory=None if series is None else read_trajectory(series, who),
        )
    except (KeyError, ValueError) as error:
        raise EngineOutputError(f"{who} left an incomplete result ({error})") from None


def read_drop(case: Drop, series: str, who: str = "LAMMPS") -> Trajectory:
    """Return the path that a drop's series tells of.

    Raise EngineOutputError when rows are cut or missing, EngineNaNError when a
    number is not finite.
    """
    try:
        path = read_trajectory(series, who)
    except ValueError as error:
        raise EngineOutputError(f"{who} left an incomplete series ({error})") from None
    rows = case.steps // case.every + 1
    if path.time_s.size != rows:
        raise EngineOutputError(f"{who} left {path.time_s.size} rows of a series of {rows}")
    return path


def version_in(text: str) -> str:
    """Return the release that a log or a help text names, as in ``22 Jul 2025 - Update 4``.

    Raise EngineMissingError when the text is not LAMMPS's.
    """
    found = re.search(
        r"^(?:LAMMPS \(|Large-scale Atomic/Molecular Massively Parallel Simulator - )([^)\n]+)",
        text,
        re.MULTILINE,
    )
    if found is None:
        raise EngineMissingError("this is not LAMMPS: its greeting names no release")
    return found.group(1).strip()


def read_trajectory(series: str, who: str = "LAMMPS") -> Trajectory:
    """Return the grain's path from the text of a series; raise EngineNaNError if not finite.

    Raise ValueError when a row is cut, or there is none.
    """
    if len(series.splitlines()) < 2:
        raise ValueError("a series without rows")
    rows = np.loadtxt(io.StringIO(series), delimiter=",", skiprows=1, ndmin=2)
    if not np.isfinite(rows).all():
        raise EngineNaNError(f"{who} wrote a series with values that are not numbers")
    # the script runs in stretches, and LAMMPS prints where one ends and the next begins
    fresh = np.diff(rows[:, 0], prepend=-np.inf) > 0.0
    return Trajectory(*rows[fresh].T)


def error_from_text(text: str, returncode: int | None = None, who: str = "LAMMPS") -> EngineError:
    """Return the error that the last words of ``who``, or the way it died, speak of."""
    errors = [line.strip() for line in text.splitlines() if _ERROR.search(line)]
    message = errors[-1] if errors else ""
    if re.search(_OUT_OF_MEMORY, text, re.IGNORECASE):
        said = f": {message}" if message else last_words(text)
        return EngineMemoryError(f"{who} ran out of memory{said}")
    if re.search(r"non-numeric|\bnan\b", message, re.IGNORECASE):
        return EngineNaNError(f"{who} met a value that is not a number: {message}")
    if re.search(r"lost atoms", message, re.IGNORECASE):
        return EngineLostAtomsError(f"{who} lost an atom: {message}")
    if message:
        return EngineInputError(f"{who} refused its input: {message}")
    if returncode is not None and returncode != 0:
        return EngineCrashError(f"{who} died: {way_of_death(returncode)}{last_words(text)}")
    return EngineOutputError(f"{who} ended without a result{last_words(text)}")


def _number(who: str, name: str, text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise EngineNaNError(f"{who} returned {name} = {text}")
    return value
