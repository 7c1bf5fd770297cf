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


def numbers(**meanings: str) -> tuple[Observable, ...]:
    """Return quantities of one number each, declared as ``name="[unit] meaning"``; [-] is 1."""
    told = {name: text.removeprefix("[").partition("] ") for name, text in meanings.items()}
    return tuple(
        Observable(name, "1" if unit == "-" else unit, "", meaning)
        for name, (unit, _, meaning) in told.items()
    )
