"""Write a run for CI: Markdown that fits a comment or the summary of a job, and JUnit XML."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from xml.etree import ElementTree as Xml

from harness.comparison.verdicts import Check, Kind, Verdict
from harness.comparison.verification import Verification
from harness.report.markdown import table_lines, tail
from harness.report.plain import markdown_text
from harness.report.text import (
    KINDS,
    KindSummary,
    by_severity,
    details,
    explained,
    happened,
    numbers,
    provenance,
    summaries,
    summary,
    triage,
)
from harness.shown import number


def opening_markdown(verification: Verification) -> list[str]:
    """Return the outcome kind by kind, and the headlines as a list."""
    outcome, counts, *headlines = map(markdown_text, summary(verification))
    return [f"**{outcome}**", counts, "", *(f"- {line}" for line in headlines)]


LIMIT = 60_000
"""Characters. A comment on GitHub holds 65,536, of which others may want some."""

SEVERE = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)
HEAD = ("check", "value", "expected", "difference", "tolerance", "")


def short_markdown(verification: Verification) -> str:
    """Return outcome, failed rows, and all others folded away by kind; under 60,000 characters."""
    lines = ["## DEM verification", "", *opening_markdown(verification), ""]
    severe = [check for check in by_severity(verification.checks) if check.verdict in SEVERE]
    if severe:
        lines += ["| check | kind | what happened |", "|---|---|---|"]
        lines += [*_within(LIMIT // 3, [_severe(check) for check in severe]), ""]
    for kind in summaries(verification.checks):
        rows = [check for check in kind.checks if check.verdict not in SEVERE]
        if rows:
            lines += _folded(kind.kind, rows, (LIMIT // 2) // len(KINDS))
    lines += ["<details><summary>Provenance</summary>", ""]
    lines += [f"- {name}: {markdown_text(text)[:1500]}" for name, text in provenance(verification)]
    return "\n".join([*lines, "", "</details>", ""])


def _severe(check: Check) -> str:
    about = "" if check.engine_died else triage(check)
    note = "" if math.isnan(check.value) else check.note
    texts = (happened(check), about, details(check), note)
    mark = "**failed**" if check.verdict is Verdict.FAIL else str(check.verdict)
    happening = markdown_text("; ".join(filter(None, texts)))[:600]
    return f"| {mark} {markdown_text(check.name)} | {check.kind} | {happening} |"


def _folded(kind: Kind, rows: Sequence[Check], room: int) -> list[str]:
    cells = [
        (c.name, *map(number, (c.value, c.expected)), number(c.difference, 2),
         number(c.tolerance, 2), c.unit)
        for c in rows
    ]  # fmt: skip
    head, rule, *table = table_lines(HEAD, cells, range(1, 5))
    title = f"<details><summary>{KINDS[kind]} ({len(rows)})</summary>"
    return [title, "", head, rule, *_within(room, table), "", "</details>", ""]


def _within(room: int, rows: Sequence[str]) -> list[str]:
    """Return the rows that there is room for, and a last one that counts the others."""
    kept: list[str] = []
    for row in rows:
        room -= len(row) + 1
        if room < 0:
            return [*kept, f"| and {len(rows) - len(kept)} more, in report.html | | |"]
        kept.append(row)
    return kept


_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, not even escaped."""


def junit(verification: Verification) -> str:
    """Return the checks as JUnit XML: a suite for each kind, a test case for each check.

    A verdict that failed is a ``failure``, an engine that died an ``error``. What was
    not tested, known defects, those that are fixed, and a finding, which nobody judges, are
    ``skipped`` with the reason.
    """
    rows = summaries(verification.checks)
    suites = [
        _suite(verification, row, verification.seconds if row is rows[0] else 0.0) for row in rows
    ]
    root = Xml.Element("testsuites", name="dem-harness", time=f"{verification.seconds:.3f}")
    for key in ("tests", "failures", "errors"):  # Jenkins's schema knows no more here
        root.set(key, str(sum(int(suite.get(key, "0")) for suite in suites)))
    root.extend(suites)
    Xml.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, "unicode") + "\n"


def _suite(verification: Verification, row: KindSummary, seconds: float) -> Xml.Element:
    """Return the suite of a kind; the first carries the time, which no check has of its own."""
    cases = _cases(row)
    suite = Xml.Element(
        "testsuite",
        name=f"dem-harness {row.kind}",
        tests=str(len(cases)),
        failures=str(sum(case.find("failure") is not None for case in cases)),
        errors=str(sum(case.find("error") is not None for case in cases)),
        skipped=str(sum(case.find("skipped") is not None for case in cases)),
        time=f"{seconds:.3f}",
        timestamp=verification.started[:19],
    )
    engine = verification.provenance
    label = engine.label if engine else "none"
    properties = Xml.SubElement(suite, "properties")
    for name, value in (
        ("level", verification.level),
        ("engine", label),
        ("platform", verification.platform),
    ):
        Xml.SubElement(properties, "property", name=name, value=_clean(value))
    suite.extend(cases)
    return suite


def _cases(row: KindSummary) -> list[Xml.Element]:
    """Return the test cases of a kind; a name that comes again is numbered, as readers need."""
    seen: Counter[str] = Counter()
    cases = []
    for check in row.checks:
        seen[check.name] += 1
        again = f" ({seen[check.name]})" if seen[check.name] > 1 else ""
        case = Xml.Element(
            "testcase",
            classname=f"dem-harness.{check.kind}",
            name=_clean(check.name + again),
            time="0.000",
        )
        _outcome(case, check)
        cases.append(case)
    return cases


def _outcome(case: Xml.Element, check: Check) -> None:
    if check.verdict is Verdict.FAIL:
        kind = "error" if check.engine_died else "failure"
        message = check.note if check.engine_died else numbers(check)
        trouble = Xml.SubElement(
            case, kind, type=_clean(triage(check) or "verdict"), message=_clean(message)
        )
        trouble.text = _clean(_story(check))
    elif check.verdict is Verdict.NOT_TESTED:
        Xml.SubElement(case, "skipped", message=_clean(f"not tested: {check.note}"))
    elif check.verdict in (Verdict.KNOWN_DEFECT, Verdict.FIXED):
        message = f"{check.verdict}: {numbers(check)}. {check.note}"
        Xml.SubElement(case, "skipped", message=_clean(message))
    elif check.verdict is Verdict.FINDING:
        message = f"finding, not judged: {numbers(check)}. {check.note}"
        Xml.SubElement(case, "skipped", message=_clean(message))
    else:
        Xml.SubElement(case, "system-out").text = _clean(numbers(check))


def _story(check: Check) -> str:
    about = triage(check)
    lines = [
        f"{check.kind}: {check.name}",
        numbers(check),
        check.why and f"tolerance: {check.why}",
        about and f"class: {about}. {details(check)} {explained(check)}",
        check.note,
        check.log and f"log: logs/{check.log_name}\n{tail(check.log)}",
    ]
    return "\n".join(line for line in lines if line)


def _clean(text: str) -> str:
    return _NOT_XML.sub("?", text)
