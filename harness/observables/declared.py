"""Declaration of an observable: name, unit and shape."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Observable:
    """A quantity that theory, solvers and engines can all be asked for.

    ``shape`` is in words: "time", "time, particle", "particle" or "" for one number.
    """

    name: str
    unit: str
    shape: str
    meaning: str
