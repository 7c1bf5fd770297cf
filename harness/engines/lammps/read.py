"""Read what LAMMPS says: its release, its errors."""

from __future__ import annotations

import re

from harness.engines.process import FAULTS, OUT_OF_MEMORY, death, last_words, signal_of
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
)

_ERROR = re.compile(r"^ERROR(?: on proc \d+)?:.*", re.MULTILINE)
"""LAMMPS's own: an echo of a script's ``print 'ERROR: ...'`` does not begin with it."""

_AFTER_ERROR = re.compile(
    r"\s*(?:\n(?:For more information see |Last (?:command|input line): |-->|\s*\^|quit\b|ERROR\b"
    r"|.*\(\S+\.(?:cpp|h):\d+\)|Abort\(|application called MPI_Abort|\s*$).*)*\s*"
)
"""What LAMMPS writes after its error: where in the manual, the command, the end of the script."""


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


def packages_in(text: str) -> tuple[str, ...]:
    """Return the packages that a help text names."""
    found = re.search(r"^Installed packages:\s*\n\s*\n((?:[A-Z0-9][A-Z0-9 \-]*\n)+)", text, re.M)
    return tuple(found.group(1).split()) if found else ()


def error_from_text(text: str, returncode: int | None = None, who: str = "LAMMPS") -> EngineError:
    """Return the error that the way ``who`` died, or the last line of its log, speaks of.

    ``returncode`` is the exit status, None where the process lives on.
    """
    if returncode is not None and signal_of(returncode) in FAULTS:
        return death(who, returncode, text)
    # with a status of its own, or still alive: the last line is the reason
    message = closing_error(text)
    if message and re.search(OUT_OF_MEMORY, message, re.IGNORECASE):
        return EngineMemoryError(f"{who} ran out of memory: {message}")
    if re.search(r"non-numeric|\bnan\b", message, re.IGNORECASE):
        return EngineNaNError(f"{who} met a value that is not a number: {message}")
    if re.search(r"lost atoms", message, re.IGNORECASE):
        return EngineLostAtomsError(f"{who} lost an atom: {message}")
    if message:
        return EngineInputError(f"{who} refused its input: {message}")
    if returncode is None and re.search(OUT_OF_MEMORY, last_words(text), re.IGNORECASE):
        return EngineMemoryError(f"{who} ran out of memory{last_words(text)}")
    if returncode is not None and returncode != 0:
        return death(who, returncode, text)
    return EngineOutputError(f"{who} ended without a result{last_words(text)}")


def closing_error(text: str) -> str:
    """Return the error with which LAMMPS ended a text; empty where it went on, or there is none."""
    found = list(_ERROR.finditer(text))
    ended = found and _AFTER_ERROR.fullmatch(text, found[-1].end())
    return found[-1][0].strip() if ended else ""


def has_error(log: str) -> bool:
    """Return whether LAMMPS wrote an error anywhere in a log, the echo of its script apart."""
    return _ERROR.search(log) is not None


def check_log(log: str, who: str = "LAMMPS") -> None:
    """Raise EngineError for a log that holds an error beside the results of a finished run."""
    found = _ERROR.search(log)
    if found is not None:
        lost = re.search(r"lost atoms", found[0], re.IGNORECASE)
        kind = EngineLostAtomsError if lost else EngineOutputError
        raise kind(f"{who} gave a result in spite of an error: {found[0].strip()[:160]}")
