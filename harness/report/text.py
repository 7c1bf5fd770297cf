"""Say in sentences what a run found: the words that HTML page, Markdown and terminal share.

Verdicts are counted kind by kind, as different kinds are never added up; each class of failure has
an explanation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from harness.comparison.verdicts import Check, Kind, Verdict
from harness.comparison.verification import Verification
from harness.observables.row import Row
from harness.shown import ROUND_OFF, decimals, number, value_text

EXPLAINED = {
    "diverged from the first step": "The two differ from the start: another law, parameter or "
    "initial state, not an accumulated error.",
    "diverged late": "The two agree at first and part later: an event (a contact that opens or "
    "closes) fell differently, or an error grew.",
    "out of tolerance": "The value moved by more than its tolerance; no series tells when.",
    "wrong input": "The engine was given something else than was asked for.",
    "refused": "The engine refused its input and said why.",
    "engine error": "The engine ended with an error of its own.",
    "crashed": "The engine's process died: a signal, an abort, or an exit status.",
    "bad output": "The engine ended without a complete result.",
    "lost atoms": "A particle left its box: most often a step that is too long.",
    "not found": "The engine, or a library it needs, is not here.",
    "nan": "A value that is not a number was met or returned.",
    "out of time": "The run did not finish in the time it was given.",
    "out of memory": "The run asked for more memory than it was given.",
    "not tested": "The check could not be made; its note says why. This is never a pass.",
}
"""By class in lower case; a class that is not here stands without an explanation."""


def triage(check: Check) -> str:
    """Return the class of a failure; empty for what the verdict says already."""
    return "" if check.triage == check.verdict else check.triage.partition(":")[0]


def details(check: Check) -> str:
    """Return what the triage says beyond the class: of what kind, where and when."""
    return check.triage.partition(":")[2].strip()


def explained(check: Check) -> str:
    """Return what the class of a failure means, by its kind where that is known."""
    by_class = EXPLAINED.get(check.triage.partition(":")[0].lower(), "")
    return EXPLAINED.get(details(check).lower(), by_class)


def happened(check: Check) -> str:
    """Return in a line why a check stands as it does: value against expected, or the note."""
    if math.isnan(check.value):
        return check.note
    return (
        f"{number(check.value)} against {number(check.expected)} {check.unit}".rstrip()
        + f", {number(check.difference, 2)} apart, {number(check.tolerance, 2)} allowed"
    )


def numbers(check: Check) -> str:
    """Return value, expected, difference, uncertainty and tolerance in a line."""
    unit = f" {check.unit}" if check.unit else ""
    return (
        f"value {number(check.value)}{unit}, expected {number(check.expected)}{unit}, "
        f"difference {number(check.difference, 3)}, uncertainty {number(check.uncertainty, 3)}, "
        f"tolerance {number(check.tolerance, 3)}"
    )


KINDS = {
    Kind.ANALYTIC: "Analytic: against a closed form",
    Kind.CROSS_CODE: "Cross-code: against another code or route, same law",
    Kind.INVARIANCE: "Invariance: the same scene by other options of the engine",
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


def summary(verification: Verification) -> list[str]:
    """Return the sentences that open the report: the outcome kind by kind, and the headlines."""
    counts = "; ".join(f"{s.kind} {s.text}" for s in summaries(verification.checks))
    return [
        f"{headline(verification.checks, verification.untested_cases)}.",
        f"{counts}.",
        *headline_lines(verification.headlines),
    ]


def headline_lines(headlines: Sequence[Row]) -> list[str]:
    """Return a sentence for each headline: expected and measured, with its uncertainty."""
    return [f"{row.name}: expected {expected(row)}; {measured(row)}" for row in headlines]


def expected(row: Row) -> str:
    """Return the expected value with its unit, to the digits of the measured one."""
    places = min(ROUND_OFF, decimals(row.uncertainty))
    return f"{row.expected:.{places}f} {row.unit}".rstrip()


def measured(row: Row) -> str:
    """Return who measured what: ``code 10.2070 ± 0.0004 deg (how)``."""
    note = f" ({row.note})" if row.note else ""
    return f"{row.who} {value_text(row.value, row.uncertainty, row.unit)}{note}"


def provenance(verification: Verification) -> list[tuple[str, str]]:
    """Return what made this report, as pairs of name and text."""
    engine = verification.provenance
    pairs = [
        ("started", verification.started),
        ("took", f"{verification.seconds:.1f} s"),
        ("level", verification.level),
        ("cases", ", ".join(verification.cases)),
        ("dem-harness", verification.harness_version),
        ("platform", verification.platform),
    ]
    if engine is not None:
        pairs += [
            ("engine", engine.label),
            ("executable", engine.executable),
            ("packages", " ".join(engine.packages)),
        ]
    return pairs
