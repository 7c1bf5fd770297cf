"""Compare two tables of rows: which rows both have, how far they lie apart, of what class.

The rows against the baseline, what accepting them would change, releases against one another, the
differences of two runs and those of two ledgers are views of it: they say which rows are compared,
how wide a tolerance is, and what a class means to them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

from harness.observables.row import Row

ROUND_OFF = 1e-12
"""Relative change that is taken for rounding: some thousand units in the last place."""


class Change(StrEnum):
    """The class of a row of one table against that of the same key in another."""

    SAME = "same to the last bit"
    ROUNDING = "within round-off"
    TOLERATED = "within tolerance"
    MOVED = "moved"
    ADDED = "added"
    REMOVED = "removed"


K = TypeVar("K", bound=Hashable)
R = TypeVar("R", bound=Row)


@dataclass(frozen=True)
class Pair(Generic[R]):
    """A row in two tables; ``before`` or ``after`` is None where a table does not have it.

    ``change`` is its class, that of :func:`compare` or of a view; ``width`` is how far the two may
    lie apart, in the unit of the row, NaN where nothing is said of it.
    """

    before: R | None
    after: R | None
    change: StrEnum
    width: float = math.nan

    @property
    def row(self) -> R:
        """Return the row of the later table that has it."""
        row = self.after or self.before
        assert row is not None
        return row

    @property
    def moved_by(self) -> float:
        """Return value after - value before, in the row's unit; NaN where one is missing."""
        if self.before is None or self.after is None:
            return math.nan
        return self.after.value - self.before.value

    @property
    def in_tolerances(self) -> float:
        """Return the move over the width; infinite for a move where that is 0."""
        move, width = self.moved_by, self.width
        if math.isnan(move) or math.isnan(width):
            return math.nan
        if width > 0.0:
            return move / width
        return math.copysign(math.inf, move) if move else 0.0

    @property
    def in_uncertainties(self) -> float:
        """Return the move over both uncertainties, added in quadrature as for independent runs.

        NaN where neither row states one that the move can be counted in.
        """
        if self.before is None or self.after is None:
            return math.nan
        width = math.hypot(self.before.uncertainty, self.after.uncertainty)
        many = self.moved_by / width if width else math.nan
        return many if math.isfinite(many) else math.nan


def compare(
    before: Mapping[K, R], after: Mapping[K, R], width: Callable[[R, R], float]
) -> dict[K, Pair[R]]:
    """Return the rows of two tables in pairs, by their keys, those of ``before`` first.

    ``width`` returns how far the values of two rows may lie apart. Two values that are both NaN
    are the same; of which one is NaN have moved.
    """
    return {key: _pair(before.get(key), after.get(key), width) for key in {**before, **after}}


def _pair(before: R | None, after: R | None, width: Callable[[R, R], float]) -> Pair[R]:
    if before is None or after is None:
        return Pair(before, after, Change.ADDED if before is None else Change.REMOVED)
    wide = width(before, after)
    return Pair(before, after, change_of(before.value, after.value, wide), wide)


def change_of(before: float, after: float, width: float) -> Change:
    """Return the class of the change from one number to another."""
    if before == after or (math.isnan(before) and math.isnan(after)):
        return Change.SAME
    difference = abs(after - before)
    if not math.isfinite(difference):
        return Change.MOVED
    if difference <= ROUND_OFF * abs(before):
        return Change.ROUNDING
    return Change.TOLERATED if difference <= width else Change.MOVED


@dataclass(frozen=True)
class RunPoint:
    """A quantity as one run left it.

    ``series`` is what points of one quantity have in common. ``run`` names the run, or the release;
    ``facts`` are what else may differ from run to run, by name. The verdict is empty where a value
    was held against nothing, the tolerance NaN where none is known.
    """

    series: Hashable
    run: str
    row: Row
    tolerance: float = math.nan
    verdict: str = ""
    facts: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Step:
    """A quantity that moved between two runs that follow one another."""

    before: RunPoint
    after: RunPoint

    @property
    def in_tolerances(self) -> float:
        """Return the move over the tolerance of the later run; NaN where there is none."""
        move, width = self.after.row.value - self.before.row.value, self.after.tolerance
        return move / width if width > 0.0 else math.nan

    @property
    def reasons(self) -> tuple[str, ...]:
        """Return what else is not the same in both runs, as ``release: 1 -> 2``."""
        before, after = dict(self.before.facts), dict(self.after.facts)
        return tuple(
            f"{name}: {before.get(name, 'none')} → {text}"
            for name, text in after.items()
            if before.get(name) != text
        )


def steps(points: Iterable[RunPoint]) -> list[Step]:
    """Return where each series moved, in the order of the later points.

    ``points`` are in the order of their runs. A value moves where it changes by more than the
    tolerance of the later run, by more than round-off where none is known, or where its verdict
    changes.
    """
    last: dict[Hashable, RunPoint] = {}
    moves = []
    for point in points:
        before = last.get(point.series)
        if before is not None and _moved(before, point):
            moves.append(Step(before, point))
        last[point.series] = point
    return moves


def _moved(before: RunPoint, after: RunPoint) -> bool:
    width = 0.0 if math.isnan(after.tolerance) else after.tolerance
    change = change_of(before.row.value, after.row.value, width)
    return change is Change.MOVED or before.verdict != after.verdict
