"""Estimate what a verification takes before it runs."""

from __future__ import annotations

from collections.abc import Iterable

from harness.cases.contract import LEVELS, LevelName

SECONDS_BY_LEVEL = {
    "columns": (7, 43, 43),
    "drum": (33, 107, 380_000),
    "head-on": (4, 31, 31),
    "heap": (50, 240, 1100),
    "incline": (9, 23, 90),
    "oblique": (2, 15, 15),
    "penetration": (70, 3500, 17_000),
    "prescribed-motion": (2, 20, 20),
    "silo": (32, 100, 640_000),
    "tower": (6, 9, 30),
}
"""CPU time [s] of a case in LAMMPS, at levels quick, default and full, good to a factor of two.

Measured, but for level full of the bulk cases.
"""

OTHER_SECONDS = 4.0
"""CPU time [s] of any other case, at any level."""


def verification_seconds(cases: Iterable[str], level: LevelName, engines: int = 1) -> float:
    """Return the expected CPU time [s] of a verification of cases by name in so many engines."""
    place = LEVELS.index(level)
    return engines * sum(
        SECONDS_BY_LEVEL[name][place] if name in SECONDS_BY_LEVEL else OTHER_SECONDS
        for name in cases
    )
