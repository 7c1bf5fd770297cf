"""Which engine would answer to a name, told without opening it: what a kept result is keyed by."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from harness.engines.lammps.fingerprint import fingerprint as lammps

FINGERPRINTS: dict[str, Callable[[str | None, str | None], dict[str, Any] | None]] = {
    "lammps": lammps
}


def fingerprint(
    name: str = "lammps", *, lmp: str | None = None, launcher: str | None = None
) -> dict[str, Any] | None:
    """Return all of an engine that decides a result, JSON-ready; None where that cannot be told.

    Takes what ``open_engine`` takes. Raise RequestError for a program that is
    not there.
    """
    if name not in FINGERPRINTS:
        return None
    return FINGERPRINTS[name](lmp, launcher)
