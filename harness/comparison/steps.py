"""Find the steps at which quantities moved, from run to run or from release to release."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable
from dataclasses import dataclass

from harness.comparison.compare import Change, change_of
from harness.observables.row import Row


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
