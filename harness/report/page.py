"""Write the report of a run, as one page of HTML and as Markdown."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from harness.comparison.verdicts import Check, Verdict
from harness.comparison.verification import Verification
from harness.report import text
from harness.report.gallery import Drawn
from harness.report.matrix import (
    Cause,
    address,
    causes,
    matrices,
    stands_in_cell,
    values,
)
from harness.report.render import html_page, markdown_page
from harness.report.sections import Label, Table
from harness.report.text import SEVERITY, by_severity, headline, summaries
from harness.shown import number

NUMERIC = ("value", "expected", "difference", "uncertainty", "tolerance", "used")
COLUMNS = ("verdict", "check", "kind", "value", "expected", "unit", *NUMERIC[2:])


@dataclass(frozen=True)
class Row:
    """A check as the page shows it."""

    check: Check
    id: str

    @property
    def severity(self) -> int:
        """Return the place of the verdict in the order of reading."""
        return SEVERITY.index(self.check.verdict)

    @property
    def used(self) -> float:
        """Return how much of the tolerance the difference takes; 1 is the limit."""
        difference, tolerance = abs(self.check.difference), self.check.tolerance
        if tolerance > 0.0:
            return difference / tolerance
        return 0.0 if difference == 0.0 == tolerance else math.nan

    @property
    def percent(self) -> str:
        """Return that share in per cent; empty where there is none."""
        share = 100.0 * self.used
        return "" if math.isnan(share) else f"{share:.3g} %" if share < 1e4 else "> 1e4 %"

    @property
    def width(self) -> str:
        """Return the length of the bar [%]."""
        return f"{min(100.0, 100.0 * self.used):.0f}"


def rows_of(verification: Verification) -> list[Row]:
    """Return the checks as rows, the most severe first."""
    ordered = by_severity(verification.checks)
    return [Row(check, f"check-{n}") for n, check in enumerate(ordered, 1)]


def report_page(verification: Verification, drawn: Sequence[Drawn]) -> str:
    """Return the page; figures, scripts and style are inside it, so that it can be sent alone."""
    outcome = headline(verification.checks, verification.untested_cases)
    frame = {"name": TITLE, "who": _run_label(verification), "columns": COLUMNS}
    return html_page(
        "report.md.j2",
        f"{TITLE}: {outcome}",
        frame=frame,
        **_values(verification, drawn),
    )


TITLE = "DEM verification"

LIMIT = 60_000
"""Characters of the Markdown report: a comment on GitHub holds 65,536."""

KEPT = 2
"""Lines of a table's head, and as many rows are kept at least."""


def report_markdown(verification: Verification, drawn: Sequence[Drawn]) -> str:
    """Return the report as Markdown, below :data:`LIMIT` characters; all text in it is escaped."""
    values = _values(verification, drawn)
    return shortened(markdown_page("report.md.j2", TITLE, **values), LIMIT)


def shortened(text: str, limit: int) -> str:
    """Return Markdown of less than ``limit`` characters: the longest tables lose their last rows.

    A sentence below such a table counts them. What is too long without tables ends early.
    """
    blocks = text.rstrip("\n").split("\n\n")
    left_out: Counter[int] = Counter()
    tables = {n: block.split("\n") for n, block in enumerate(blocks) if block.startswith("|")}
    while sum(len(block) + 2 for block in blocks) >= limit:
        long = {n: lines for n, lines in tables.items() if len(lines) > 2 * KEPT}
        if not long:
            end = "\n\nThe rest is in report.html.\n"
            return text[: limit - len(end) - 1].rpartition("\n\n")[0] + end
        longest = max(long, key=lambda n: len(blocks[n]))
        lines = tables[longest]
        kept = max(2 * KEPT, len(lines) // 2)
        left_out[longest] += len(lines) - kept
        tables[longest] = lines[:kept]
        rest = f"{left_out[longest]} more rows are left out; results.csv has every check."
        blocks[longest] = "\n".join(lines[:kept]) + f"\n\n{rest}"
    return "\n\n".join(blocks) + "\n"


def _values(verification: Verification, drawn: Sequence[Drawn]) -> dict[str, Any]:
    """Return what the template is filled with."""
    rows = rows_of(verification)
    present = [v for v in SEVERITY if any(c.verdict is v for c in verification.checks)]
    gallery = [part for part in drawn if not part.section.title and part.section.opening is None]
    return {
        "headline": headline(verification.checks, verification.untested_cases),
        "outcome": _outcome(verification),
        "counts": _counts(rows, present),
        "kind_counts": text.summary(verification)[1],
        "severe": _severe(verification),
        "headlines": [(h.name, text.expected(h), text.measured(h)) for h in verification.headlines],
        "verdicts": _verdicts(verification, present),
        "rows": rows,
        "openings": [part for part in drawn if part.section.opening],
        "causes": [(cause, rows_in(cause, rows)) for cause in causes(verification)],
        "findings": [row for row in rows if row.check.verdict is Verdict.FINDING],
        "engines": len({check.cell.engine for check in verification.checks if check.cell}),
        "names": COLUMNS,
        "numeric": NUMERIC,
        "kinds": [s.kind for s in summaries(verification.checks)],
        "present": present,
        "kind_tables": list(_kind_tables(verification)),
        "matrices": [matrix.table() for matrix in matrices([(row.check, row.id) for row in rows])],
        "values": values(verification.checks),
        "defects": [
            (defect, address(defect) if script else "") for defect, script in verification.defects
        ],
        "parts_of_report": [part for part in drawn if part.section.title],
        "pictures": [picture for part in gallery for picture in part.pictures],
        "failures": [failure for part in gallery for failure in part.failures],
        "scripts": verification.scripts,
        "logs": verification.logs,
        "provenance": text.provenance(verification),
    }


def rows_in(cause: Cause, rows: Sequence[Row]) -> list[Row]:
    """Return the rows of a cause as the page shows them."""
    checks = {id(check) for check in cause.rows}
    return [row for row in rows if id(row.check) in checks]


NAMES = {Verdict.PASS: "holds", Verdict.FAIL: "fails", Verdict.FINDING: "reported"}
"""Of verdicts as heads of a column; the others as they are."""


def _counts(rows: Sequence[Row], present: Sequence[Verdict]) -> list[str]:
    """Return how many rows have each verdict, and of how many."""
    plural = {Verdict.PASS: "hold", Verdict.FAIL: "fail"}
    counts = [
        f"{sum(row.check.verdict is v for row in rows)} {plural.get(v, NAMES.get(v, v))}"
        for v in present
    ]
    return [*counts[:-1], f"{counts[-1]} of {len(rows)} rows"] if counts else []


SEVERE = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)


def _severe(verification: Verification) -> Table:
    """Return the rows that do not hold, failures first, with what happened."""
    rows = []
    for check in by_severity(verification.checks):
        if check.verdict in SEVERE:
            about = "" if check.engine_died else text.triage(check)
            note = "" if math.isnan(check.value) else check.note
            happened = (text.happened(check), about, text.details(check), note)
            most = 600 if check.verdict is Verdict.FAIL else 200  # causes have a section
            words = "; ".join(filter(None, happened))[:most]
            rows.append((f"{check.verdict}: {check.name}", str(check.kind), words))
    return Table("", "", ("check", "kind", "what happened"), tuple(rows))


def _verdicts(verification: Verification, present: Sequence[Verdict]) -> Table:
    """Return the verdicts counted kind by kind, as different kinds are never added up."""
    rows = []
    for summary in summaries(verification.checks):
        counts = [(verdict, summary.count(verdict)) for verdict in present]
        cells = [(Label(str(count), verdict),) if count else "" for verdict, count in counts]
        rows.append((text.KINDS[summary.kind], *cells))
    head = ("kind", *(NAMES.get(verdict, str(verdict)) for verdict in present))
    return Table("Verdicts by kind", "", head, tuple(rows))


CHECKS = ("check", "value", "expected", "difference", "uncertainty", "tolerance", "unit", "verdict")


def _kind_tables(verification: Verification) -> Iterator[Table]:
    """Yield the rows of each kind but those that stand with the cells of the matrix."""
    for summary in summaries(verification.checks):
        rows = [_check(check) for check in summary.checks if not stands_in_cell(check)]
        others = len(summary.checks) - len(rows)
        note = f"{others} rows stand with the cells of the matrix, below." if others else ""
        yield Table(text.KINDS[summary.kind], note, CHECKS, tuple(rows))


def _check(check: Check) -> tuple[str, ...]:
    remarks = ": ".join(text for text in (check.triage, check.note) if text)
    numbers = (check.difference, check.uncertainty, check.tolerance)
    return (
        f"{check.name} ({remarks})" if remarks else check.name,
        *map(number, (check.value, check.expected)),
        *(number(value, 2) for value in numbers),
        check.unit,
        str(check.verdict),
    )


def _outcome(verification: Verification) -> str:
    """Return the class of the headline: green only where each row was judged and holds."""
    verdicts = {check.verdict for check in verification.checks}
    if Verdict.FAIL in verdicts or verification.status:
        return "fail"
    return "apart" if verdicts & {Verdict.KNOWN_DEFECT, Verdict.NOT_TESTED} else ""


def _run_label(verification: Verification) -> str:
    provenance = verification.provenance.label if verification.provenance else "no engine"
    started = verification.started[:16].replace("T", " ")
    return f"{provenance} · {started} UTC · {verification.level} · {verification.seconds:.0f} s"
