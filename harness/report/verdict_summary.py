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


def headline(checks: Sequence[Check]) -> str:
    """Return the outcome in a few words; what fails is counted kind by kind."""
    rows = summaries(checks)
    failed = [(s.kind, s.count(Verdict.FAIL)) for s in rows if s.count(Verdict.FAIL)]
    if failed:
        return "Failed: " + ", ".join(f"{number} {kind}" for kind, number in failed)
    if not any(s.judged for s in rows):
        return "Nothing was judged"
    return all_hold(sum(s.count(Verdict.KNOWN_DEFECT) for s in rows))


def all_hold(defects: int) -> str:
    """Return the outcome in words of a run in which none failed, beside known defects."""
    return "All verdicts hold" + (f" but {defects} known defects" if defects else "")


def by_severity(checks: Sequence[Check]) -> list[Check]:
    """Return the checks as they are read: failures first, then by kind."""
    order = list(KINDS)
    return sorted(checks, key=lambda c: (SEVERITY.index(c.verdict), order.index(c.kind)))
