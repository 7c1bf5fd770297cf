"""The committed example is what this version would write: no stale row, no stale script."""

import hashlib
import json
import re
from pathlib import Path

from harness.comparison.verification import SCHEMA
from harness.store.baseline import committed, read_baseline

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "reports" / "example"
FOUND = json.loads((EXAMPLE / "results.json").read_text(encoding="utf-8"))


def test_the_scripts_that_ran_are_those_in_inputs():
    here = {name: (ROOT / "inputs" / name).read_bytes() for name in FOUND["scripts"]}
    assert len(here) > 20
    assert {n: hashlib.sha256(text).hexdigest() for n, text in here.items()} == FOUND["scripts"]


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
