"""Where two ledgers differ: statuses exactly, numbers up to round-off."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pandas as pd

NUMBERS = ("printed", "found", "corrected", "tolerance")

RELATIVE = 1e-6
"""Round-off of another processor or library, carried through a run of 1e5 steps."""

OF_TOLERANCE = 0.01
"""A residual is round-off itself: what counts is its size against the row's tolerance."""


def ledger_differences(first: pd.DataFrame, second: pd.DataFrame) -> list[str]:
    """Return one line for each way in which ``second`` departs from ``first``.

    Both as of :meth:`harness.reproduction.claims.Ledger.frame`; words are not
    compared, since they repeat the numbers.
    """
    a, b = (_by_key(frame) for frame in (first, second))
    lines = [f"{key}: is not there any more" for key in a if key not in b]
    lines += [f"{key}: is new" for key in b if key not in a]
    for key in a:
        if key in b:
            lines += _row(key, a[key], b[key])
    return lines


def _by_key(frame: pd.DataFrame) -> dict[str, Mapping[str, object]]:
    return {str(row["key"]): row for row in frame.to_dict(orient="records")}  # type: ignore[misc]


def _row(key: str, first: Mapping[str, object], second: Mapping[str, object]) -> list[str]:
    lines = []
    if first["status"] != second["status"]:
        lines.append(f"{key}: was {first['status']}, is {second['status']}")
    room = _number(first["tolerance"])
    for name in NUMBERS:
        one, other = _number(first[name]), _number(second[name])
        if not _same(one, other, 0.0 if math.isnan(room) else OF_TOLERANCE * room):
            lines.append(f"{key}: {name} was {one:.10g}, is {other:.10g}")
    return lines


def _number(value: object) -> float:
    return float(value) if isinstance(value, (int, float)) else math.nan


def _same(one: float, other: float, room: float) -> bool:
    if math.isnan(one) or math.isnan(other):
        return math.isnan(one) and math.isnan(other)
    return one == other or abs(one - other) <= RELATIVE * max(abs(one), abs(other)) + room
