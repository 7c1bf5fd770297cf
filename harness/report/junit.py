"""Render the checks as JUnit XML, for continuous integration."""

from __future__ import annotations

import re
from collections import Counter
from xml.etree import ElementTree as Xml

from harness.comparison.verdicts import Check, Verdict
from harness.comparison.verification import Verification
from harness.report.templating import tail
from harness.report.triage import details, explained, numbers, triage
from harness.report.verdict_summary import KindSummary, summaries

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, not even escaped."""


def junit(found: Verification) -> str:
    """Return the checks as JUnit XML: a suite for each kind, a test case for each check.

    A verdict that failed is a ``failure``, an engine that died an ``error``. What was
    not tested, known defects, those that are fixed, and a finding, which nobody judges, are
    ``skipped`` with the reason.
    """
    rows = summaries(found.checks)
    suites = [_suite(found, row, found.seconds if row is rows[0] else 0.0) for row in rows]
    whole = Xml.Element("testsuites", name="dem-harness", time=f"{found.seconds:.3f}")
    for key in ("tests", "failures", "errors"):  # Jenkins's schema knows no more here
        whole.set(key, str(sum(int(suite.get(key, "0")) for suite in suites)))
    whole.extend(suites)
    Xml.indent(whole)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(whole, "unicode") + "\n"


def _suite(found: Verification, row: KindSummary, seconds: float) -> Xml.Element:
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
        timestamp=found.started[:19],
    )
    engine = found.provenance
    who = engine.told if engine else "none"
    properties = Xml.SubElement(suite, "properties")
    for name, value in (("level", found.level), ("engine", who), ("platform", found.platform)):
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
