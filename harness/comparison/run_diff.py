"""Two verification runs held side by side: which rows moved, and what else is not the same."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, ClassVar

from harness.comparison.compare import Change, Pair, change_of, compare
from harness.comparison.verdicts import RANK, Check, Verdict
from harness.comparison.verification import Results
from harness.observables.row import numbered
from harness.shown import Record, Result

if TYPE_CHECKING:
    from harness.shown.figure import Figure


class RowChange(StrEnum):
    """What became of a row from the first run to the second, in the order of reading."""

    WORSE = "worse"
    BETTER = "better"
    MOVED = "moved"
    REMOVED = "removed"
    ADDED = "added"
    NOT_COMPARABLE = "not comparable"
    SAME = "same"


@dataclass(frozen=True)
class RowDiff(Pair[Check], Record):
    """One check in two runs; ``worsens`` is true when it asks for exit status 1."""

    change: RowChange
    worsens: bool = False

    JSON: ClassVar = {
        "change": "change",
        "kind": "row.kind",
        "name": "row.name",
        "unit": "row.unit",
        "verdict_before": "before.verdict",
        "verdict_after": "after.verdict",
        "value_before": "before.value",
        "value_after": "after.value",
        "moved_by": "moved_by",
        "moved_in_tolerances": "in_tolerances",
        "moved_in_uncertainties": "in_uncertainties",
        "tolerance_before": "before.tolerance",
        "tolerance_after": "after.tolerance",
        "triage": "row.triage",
        "worsens": "worsens",
    }


@dataclass(frozen=True)
class MetadataChange:
    """What differs besides the checks: release, baseline, level, a script."""

    name: str
    before: str
    after: str


@dataclass(frozen=True, repr=False)
class RunDiff(Result):
    """All that is not the same in two runs; ``rows`` are the gravest first, then the largest."""

    before: Results
    after: Results
    rows: tuple[RowDiff, ...]
    metadata: tuple[MetadataChange, ...]

    JSON: ClassVar = {
        "status": "status",
        "counts": "counts",
        "metadata": "metadata",
        "rows": "changed_rows",
    }
    ROWS: ClassVar = "rows"

    @property
    def status(self) -> int:
        """Return 1 when a verdict changed for the worse, else 0."""
        return int(any(row.worsens for row in self.rows))

    def count(self, change: RowChange) -> int:
        """Return how many rows changed in a way."""
        return sum(row.change is change for row in self.rows)

    @property
    def counts(self) -> dict[str, int]:
        """Return how many rows there are of each class."""
        return {str(change): self.count(change) for change in RowChange}

    @property
    def changed_rows(self) -> list[RowDiff]:
        """Return the rows that did not stay the same."""
        return [row for row in self.rows if row.change is not RowChange.SAME]

    def summary(self) -> dict[str, str]:
        """Return what became of the rows, and which runs they are of."""
        counts = [f"{self.count(change)} {change}" for change in RowChange if self.count(change)]
        return {
            "rows": ", ".join(counts),
            "before": f"{self.before.started}, {self.before.level}",
            "after": f"{self.after.started}, {self.after.level}",
            "engine": self.after.engine.label if self.after.engine else "none",
        }

    def draw(self) -> Figure:
        """Draw by how many tolerances each row moved."""
        from harness.shown.figure import beside_tolerance

        groups = {
            str(change): [row.in_tolerances for row in self.rows if row.change is change]
            for change in dict.fromkeys(row.change for row in self.rows)
        }
        return beside_tolerance(groups, "moved by, over the tolerance")


def diff_runs(before: Results, after: Results) -> RunDiff:
    """Return what is not the same in two runs.

    Rows meet by kind and name; where a name stands more than once, in order. What only one of two
    plans has, or one of two ways to run an engine can test, is not comparable.
    """
    first, second = _by_kind_and_name(before.checks), _by_kind_and_name(after.checks)
    plans = [
        (run.cases, {engine.engine for engine in run.engines.declared} if run.engines else set())
        for run in (before, after)
    ]
    same_plan = plans[0] == plans[1]
    hows = [run.engine.how if run.engine else "" for run in (before, after)]
    same_plan = same_plan and before.level == after.level
    pairs = compare(first, second, lambda _, check: check.tolerance)
    rows = [_row(pair, same_plan, hows[0] == hows[1]) for pair in pairs.values()]
    rows.sort(key=_severity)
    return RunDiff(before, after, tuple(rows), _metadata(before, after))


def _row(pair: Pair[Check], same_plan: bool, same_how: bool) -> RowDiff:
    """Return what became of a row; a plan is the level, the cases and the engines."""
    before, after = pair.before, pair.after
    change, worsens = RowChange.SAME, False
    if before is None or after is None:
        if not (same_plan and same_how):
            change = RowChange.NOT_COMPARABLE
        else:
            change = RowChange.REMOVED if after is None else RowChange.ADDED
            # with the same plan a row that is gone was lost
            lost = pair.row.verdict not in (Verdict.NOT_TESTED, Verdict.FINDING)
            worsens = lost if after is None else pair.row.verdict is Verdict.FAIL
        return RowDiff(before, after, change, pair.width, worsens)
    untested = {before.verdict, after.verdict} - {Verdict.NOT_TESTED}
    ranks = RANK[before.verdict], RANK[after.verdict]
    if not same_how and len(untested) == 1 and before.verdict is not after.verdict:
        change = RowChange.NOT_COMPARABLE
    elif ranks[1] != ranks[0]:
        worsens = ranks[1] < ranks[0]
        change = RowChange.WORSE if worsens else RowChange.BETTER
    elif {pair.change, change_of(before.tolerance, after.tolerance, 0.0)} != {Change.SAME}:
        change = RowChange.MOVED
    return RowDiff(before, after, change, pair.width, worsens)


def _metadata(before: Results, after: Results) -> tuple[MetadataChange, ...]:
    runs = (before, after)
    keys = ("level", "platform", "harness_version", "cases", "baseline", "baseline_sha256")
    pairs = [
        (name.replace("_", " "), *(_text(getattr(run, name)) for run in runs)) for name in keys
    ]
    for name in ("engine", "engine_version", "how", "executable", "packages"):
        ours, theirs = (_text(getattr(run.engine, name, "none")) for run in runs)
        pairs.append((name.replace("_", " "), ours, theirs))
    expected = [{(h.name, h.who): _text(h.expected) for h in run.headlines} for run in runs]
    for key in expected[0].keys() & expected[1].keys():
        pairs.append((f"expected {key[0]}", expected[0][key], expected[1][key]))
    for name in sorted({*before.scripts, *after.scripts}):
        ours, theirs = (run.scripts.get(name, "not there")[:12] for run in runs)
        pairs.append((f"script {name}", ours, theirs))
    return tuple(MetadataChange(*pair) for pair in pairs if pair[1] != pair[2])


def _by_kind_and_name(checks: Iterable[Check]) -> dict[Hashable, Check]:
    """Return checks by kind and name; where a name stands more than once, in order."""
    keyed = numbered(checks, lambda check: (check.kind, check.name))
    return {(*key, before): check for key, before, check in keyed}


def _severity(row: RowDiff) -> tuple[bool, int, float]:
    size = abs(row.in_tolerances)
    if math.isnan(size):
        size = abs(row.in_uncertainties)
    return not row.worsens, list(RowChange).index(row.change), -(0.0 if math.isnan(size) else size)


def _text(value: object) -> str:
    if isinstance(value, (list, tuple)):
        return " ".join(map(str, value))
    return f"{value:.10g}" if isinstance(value, float) else str(value)
