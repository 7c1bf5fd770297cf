"""The checks that the plan of a verification names, and which of them no run left.

A plan is data: names of checks. What is missing is known by name, so that nobody counts rows.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from harness.comparison.verdicts import Check, Kind, Triage, Verdict, failed


class Planned(NamedTuple):
    """A check that the plan of a level names: how the name of its row begins.

    Rows of what must not change a run (``invariance``) and of its values are told apart.
    """

    name: str
    invariance: bool = False

    def includes(self, row: Check) -> bool:
        """Return whether a row is of the check."""
        return row.name.startswith(self.name) and self.invariance is (row.kind is Kind.INVARIANCE)


def missing_from(rows: Sequence[Check], planned: Iterable[Planned]) -> list[Planned]:
    """Return the planned checks that no row is of; a row is of one check, the longest name."""
    unassigned, missing = dict(enumerate(rows)), []
    for check in sorted(planned, key=lambda check: len(check.name), reverse=True):
        at = next((i for i, row in unassigned.items() if check.includes(row)), None)
        if at is None:
            missing.append(check)
        else:
            del unassigned[at]
    return missing


def judge_plan(name: str, rows: Sequence[Check], planned: Sequence[Planned]) -> list[Check]:
    """Return the check that a verification left all that its plan names, and what is missing.

    ``name`` is that of the count; a check that is missing is a failed row of its own name.
    """
    missing = missing_from(rows, planned)
    count = Check(
        name,
        float(len(rows)),
        0.0,
        "",
        expected=float(len(planned)),
        note=f"missing: {'; '.join(check.name for check in missing)}" if missing else "",
        kind=Kind.ANALYTIC,
        tolerance=0.0,
        verdict=Verdict.FAIL if missing else Verdict.PASS,
        why="a count: each row that the plan of the level has is there",
        triage=Triage.MISSING if missing else "",
    )
    lost = "the plan of the level names it, and no run left it"
    kinds = [Kind.INVARIANCE if check.invariance else Kind.ANALYTIC for check in missing]
    names = [check.name for check in missing]
    return [
        count,
        *(failed(*named, lost, Triage.MISSING) for named in zip(names, kinds, strict=True)),
    ]
