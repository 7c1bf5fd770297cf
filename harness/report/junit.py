"""Write the rows of a run as JUnit XML, which CI services read."""

from __future__ import annotations

import re
from collections import Counter
from xml.etree import ElementTree as Xml

from harness.comparison.verdicts import Check, Verdict
from harness.comparison.verification import Verification
from harness.observables.row import numbered
from harness.report.markdown import tail
from harness.report.text import numbers, summaries, triage

NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML 1.0 cannot hold, not even escaped."""


def junit(verification: Verification) -> str:
    """Return a suite for each kind of rows, with a test case for each row.

    A verdict that failed is a ``failure``, an engine that died an ``error``; rows without a verdict
    of their own, known defects and findings are ``skipped`` with the reason.
    """
    root = Xml.Element("testsuites", name="dem-harness", time=f"{verification.seconds:.3f}")
    for kind in summaries(verification.checks):
        suite = Xml.SubElement(root, "testsuite", name=f"dem-harness.{kind.kind}")
        outcomes: Counter[str] = Counter()
        for _, before, check in numbered(kind.checks, lambda check: (check.name,)):
            name = f"{check.name} ({before + 1})" if before else check.name
            case = Xml.SubElement(suite, "testcase", classname=suite.get("name", ""), name=name)
            if check.verdict is not Verdict.PASS:
                outcomes[_outcome(case, check)] += 1
        counts = {"tests": len(kind.checks), "failures": outcomes["failure"]}
        counts |= {"errors": outcomes["error"], "skipped": outcomes["skipped"]}
        suite.attrib.update({name: str(count) for name, count in counts.items()})
    Xml.indent(root)
    text = NOT_XML.sub("?", Xml.tostring(root, "unicode"))
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _outcome(case: Xml.Element, check: Check) -> str:
    """Add the outcome of a row that did not pass and return its tag."""
    failed = "error" if check.engine_died else "failure"
    tag = failed if check.verdict is Verdict.FAIL else "skipped"
    message = f"{check.verdict}: {check.note if check.engine_died else numbers(check)}"
    outcome = Xml.SubElement(case, tag, message=message)
    if tag != "skipped":
        outcome.set("type", triage(check) or "verdict")
        outcome.text = "\n".join(filter(None, (check.why, check.note, tail(check.log))))
    elif check.note:
        outcome.set("message", f"{message}; {check.note}")
    return tag
