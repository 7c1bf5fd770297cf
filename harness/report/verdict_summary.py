"""Count the verdicts of a run kind by kind: different kinds are never added up."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from harness.comparison.verdicts import Check, Kind, Verdict

KINDS = {
    Kind.ANALYTIC: "Analytic: against a closed form",
    Kind.CROSS_CODE: "Cross-code: against another code or route, same law",
    Kind.INVARIANCE: "Invariance: the same run turned, moved, restarted, over ranks, and so on",
    Kind.REGRESSION: "Regression: against the baseline",
    Kind.FINDING: "Findings: differences between models, reported and not judged",
}

SEVERITY = (
    Verdict.FAIL,
    Verdict.KNOWN_DEFECT,
    Verdict.FIXED,
    Verdict.NOT_TESTED,
    Verdict.PASS,
    Verdict.FINDING,
)
"""The order in which rows are read."""

APART = (Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)
"""Verdicts that are counted beside those that hold or fail."""


@dataclass(frozen=True)
class KindSummary:
    """The checks of one kind, counted."""

    kind: Kind
    checks: tuple[Check, ...]

    def count(self, verdict: Verdict) -> int:
        """Return how many checks have a verdict."""
        return sum(check.verdict is verdict for check in self.checks)

    @property
    def judged(self) -> int:
        """Return how many checks hold or fail."""
        return self.count(Verdict.PASS) + self.count(Verdict.FAIL)

    @property
    def text(self) -> str:
        """Return the count in words: ``18 of 18 hold``, ``9 reported``."""
        if self.kind is Kind.FINDING:
            return f"{len(self.checks)} reported"
        rest = "".join(
            f", {self.count(verdict)} {verdict}" for verdict in APART if self.count(verdict)
        )
        return f"{self.count(Verdict.PASS)} of {self.judged} hold{rest}"


def summaries(checks: Sequence[Check]) -> list[KindSummary]:
    """Return one summary for each kind that has checks, in the order of the kinds."""
    rows = [KindSummary(kind, tuple(c for c in checks if c.kind is kind)) for kind in KINDS]
    return [row for row in rows if row.checks]


def headline(checks: Sequence[Check], untested_cases: Sequence[str] = ()) -> str:
    """Return the outcome in a few words; what fails is counted kind by kind.

    ``untested_cases`` are those that were asked for by name and tested nothing.
    """
    rows = summaries(checks)
    failed = [(s.kind, s.count(Verdict.FAIL)) for s in rows if s.count(Verdict.FAIL)]
    apart = [nothing_tested(untested_cases)] if untested_cases else []
    if failed:
        counts = ", ".join(f"{number} {kind}" for kind, number in failed)
        return "; ".join([f"Failed: {counts}", *apart])
    if not any(s.judged for s in rows):
        return apart[0] if apart else "Nothing was judged"
    defects, untested = (
        sum(s.count(verdict) for s in rows)
        for verdict in (Verdict.KNOWN_DEFECT, Verdict.NOT_TESTED)
    )
    return "; ".join([*apart, all_hold(defects, untested, rest=bool(apart))])


def nothing_tested(cases: Sequence[str]) -> str:
    """Return which cases tested nothing, in words."""
    return f"Nothing was tested in {', '.join(cases)}"


def all_hold(defects: int, untested: int, *, rest: bool = False) -> str:
    """Return the outcome in words of a run in which none failed.

    Known defects and rows that were not tested stand in it; ``rest``: of the other cases.
    """
    counts = {"known defects": defects, "not tested": untested}
    apart = ", ".join(f"{number} {name}" for name, number in counts.items() if number)
    holds = "all other verdicts hold" if rest else "All verdicts hold"
    return "; ".join(filter(None, (holds, apart)))


def by_severity(checks: Sequence[Check]) -> list[Check]:
    """Return the checks as they are read: failures first, then by kind."""
    order = list(KINDS)
    return sorted(checks, key=lambda c: (SEVERITY.index(c.verdict), order.index(c.kind)))
