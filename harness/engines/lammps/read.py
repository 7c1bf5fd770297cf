"""Read what LAMMPS says: its release, its errors."""

from __future__ import annotations

import re

from harness.engines.process import death, last_words
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineMissingError,
    EngineNaNError,
    EngineOutputError,
)

_ERROR = re.compile(r"\bERROR(?: on proc \d+)?:")
"""LAMMPS's own, not that of a library below it."""

_OUT_OF_MEMORY = (
    r"failed to (re)?allocate|bad_alloc|MemoryError|out of memory"
    r"|cannot allocate memory|failed to map segment|can't start new thread"
)


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
        return death(who, returncode, text)
    return EngineOutputError(f"{who} ended without a result{last_words(text)}")
