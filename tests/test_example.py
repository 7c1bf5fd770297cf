"""The committed example is what this version would write: no stale row, no stale script."""

import hashlib
import json
import re
from pathlib import Path
from xml.etree import ElementTree

from harness.comparison.verification import SCHEMA
from harness.store.baseline import committed, read_baseline

ROOT = Path(__file__).parents[1]
REPORTS = ROOT / "reports"
EXAMPLE = REPORTS / "example"
FOUND = json.loads((EXAMPLE / "results.json").read_text(encoding="utf-8"))


def test_the_scripts_that_ran_are_those_in_inputs():
    here = {name: (ROOT / "inputs" / name).read_bytes() for name in FOUND["scripts"]}
    assert len(here) > 20
    assert {n: hashlib.sha256(text).hexdigest() for n, text in here.items()} == FOUND["scripts"]


def test_it_holds_no_copies_of_the_inputs():
    assert not (EXAMPLE / "scripts").exists()


def test_its_form_is_the_present_one():
    assert FOUND["schema"] == SCHEMA


def test_its_regression_rows_are_those_of_the_baseline():
    folder = committed()
    assert folder is not None
    records = {record.name for record in read_baseline(folder).of_level(FOUND["level"])}
    rows = {
        check["name"].removeprefix("baseline: ").split(":")[0]
        for check in FOUND["checks"]
        if check["kind"] == "regression"
    }
    assert rows <= records
    assert FOUND["status"] == 0


def test_the_page_is_light_and_stands_alone():
    page = (EXAMPLE / "report.html").read_text(encoding="utf-8")
    assert len(page) < 1_500_000
    assert '<link rel="stylesheet"' not in page
    assert not re.search(r'<(?:img|script)[^>]* src="(?!data:)', page)


def test_committed_figures_say_text_as_text_and_units_in_round_brackets():
    paths = sorted(REPORTS.rglob("*.svg"))
    assert len(paths) > 40
    for path in paths:
        words = [
            "".join(node.itertext()).strip()
            for node in ElementTree.fromstring(path.read_text(encoding="utf-8")).iter()
            if node.tag.endswith("}text")
        ]
        assert len(words) > 5, path
        assert not [text for text in words if re.search(r"\[[^\]]+\]$|\(-\)$", text)], path
