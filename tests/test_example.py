"""The committed example is what this version would write: no stale row, no stale script."""

import hashlib
import json
from pathlib import Path

import pytest

from harness.comparison.verification import SCHEMA
from harness.report.schema import NAME, published
from harness.store.baseline import committed, read_baseline

ROOT = Path(__file__).parents[1]
EXAMPLE = ROOT / "reports" / "example"
FOUND = json.loads((EXAMPLE / "results.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", sorted(FOUND["scripts"]))
def test_the_scripts_that_ran_are_those_in_inputs(name):
    text = (ROOT / "inputs" / name).read_bytes()
    assert hashlib.sha256(text).hexdigest() == FOUND["scripts"][name]


def test_it_holds_no_copies_of_the_inputs():
    assert not (EXAMPLE / "scripts").exists()


def test_its_form_is_the_present_one():
    assert FOUND["schema"] == SCHEMA
    assert (EXAMPLE / NAME).read_text(encoding="utf-8") == published()


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
