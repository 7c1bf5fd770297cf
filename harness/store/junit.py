"""Rows as JUnit XML, which CI services read."""

from __future__ import annotations

import re
from xml.etree import ElementTree as Xml

import pandas as pd

from harness.results.rows import ENGINE_FAILURES, Kind, Row, Verdict, rows_of

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(rows: pd.DataFrame, seconds: float = 0.0) -> str:
    """Return a suite for each kind of rows, with a test case for each row.

    A failed verdict is a ``failure``, a failed run of an engine an ``error``; what was not judged
    and known defects are ``skipped`` with the reason.
    """
    root = Xml.Element("testsuites", name="dem-harness", time=f"{seconds:.3f}")
    every = rows_of(rows)
    for kind in Kind:
        chosen = [row for row in every if row.kind is kind]
        if not chosen:
            continue
        suite = Xml.SubElement(root, "testsuite", name=f"dem-harness.{kind}")
        outcomes = [_add_case(suite, row) for row in chosen]
        numbers = {"failures": "failure", "errors": "error", "skipped": "skipped"}
        found = {name: str(outcomes.count(tag)) for name, tag in numbers.items()}
        suite.attrib.update({"tests": str(len(chosen)), **found})
    Xml.indent(root)
    text = _NOT_XML.sub("?", Xml.tostring(root, "unicode"))
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _add_case(suite: Xml.Element, row: Row) -> str:
    """Add the test case of a row and return the tag of its outcome, empty for a pass."""
    case = Xml.SubElement(suite, "testcase", classname=suite.get("name", ""), name=row.name)
    if row.verdict in (Verdict.PASS, Verdict.RECORDED, Verdict.FIXED):
        return ""
    failed = "error" if row.failure in ENGINE_FAILURES else "failure"
    tag = failed if row.verdict is Verdict.FAIL else "skipped"
    numbers = f"{row.value:.10g}, expected {row.expected:.10g} ± {row.tolerance:.2g} {row.unit}"
    outcome = Xml.SubElement(case, tag, message=f"{row.verdict}: {row.note or numbers}")
    if tag != "skipped":
        outcome.set("type", str(row.failure))
        outcome.text = "\n".join(filter(None, (numbers, row.reason, row.log[-2000:])))
    return tag
