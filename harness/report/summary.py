"""Render the report in short, as Markdown for a pull request or a job's summary."""

from __future__ import annotations

import math
from collections.abc import Sequence

from harness.comparison.verdicts import Check, Kind, Verdict
from harness.comparison.verification import Verification
from harness.report.markdown import opening_markdown
from harness.report.plain import markdown_text
from harness.report.text import provenance
from harness.report.triage import details, happened, triage
from harness.report.verdict_summary import KINDS, by_severity, summaries
from harness.shown import number

LIMIT = 60_000
"""Characters. A comment on GitHub holds 65,536, of which others may want some."""

SEVERE = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)
HEAD = ("| check | value | expected | difference | tolerance | |", "|---|--:|--:|--:|--:|---|")


def short_markdown(found: Verification) -> str:
    """Return outcome, failed rows, and all others folded away by kind; under 60,000 characters."""
    lines = ["## DEM verification", "", *opening_markdown(found), ""]
    severe = [check for check in by_severity(found.checks) if check.verdict in SEVERE]
    if severe:
        lines += ["| check | kind | what happened |", "|---|---|---|"]
        lines += [*_within(LIMIT // 3, [_severe(check) for check in severe]), ""]
    for one in summaries(found.checks):
        rows = [check for check in one.checks if check.verdict not in SEVERE]
        if rows:
            lines += _folded(one.kind, rows, (LIMIT // 2) // len(KINDS))
    lines += ["<details><summary>Provenance</summary>", ""]
    lines += [f"- {name}: {markdown_text(text)[:1500]}" for name, text in provenance(found)]
    return "\n".join([*lines, "", "</details>", ""])


def _severe(check: Check) -> str:
    about = "" if check.engine_died else triage(check)
    note = "" if math.isnan(check.value) else check.note
    texts = (happened(check), about, details(check), note)
    mark = "**failed**" if check.verdict is Verdict.FAIL else str(check.verdict)
    happening = markdown_text("; ".join(filter(None, texts)))[:600]
    return f"| {mark} {markdown_text(check.name)} | {check.kind} | {happening} |"


def _folded(kind: Kind, rows: Sequence[Check], room: int) -> list[str]:
    table = [
        f"| {markdown_text(c.name)} | {number(c.value)} | {number(c.expected)} "
        f"| {number(c.difference, 2)} | {number(c.tolerance, 2)} | {markdown_text(c.unit)} |"
        for c in rows
    ]
    title = f"<details><summary>{KINDS[kind]} ({len(rows)})</summary>"
    return [title, "", *HEAD, *_within(room, table), "", "</details>", ""]


def _within(room: int, rows: Sequence[str]) -> list[str]:
    """Return the rows that there is room for, and a last one that counts the others."""
    kept: list[str] = []
    for row in rows:
        room -= len(row) + 1
        if room < 0:
            return [*kept, f"| and {len(rows) - len(kept)} more, in report.html | | |"]
        kept.append(row)
    return kept
