"""The report's section on engines beside one another."""

import json
from dataclasses import replace

from harness.comparison.verification import read_published
from harness.report.plain import finite
from harness.report.sections import TITLE, engines_section


def test_each_engine_has_a_row_with_what_became_of_it(declared):
    section = engines_section(declared)
    (table,) = section.tables
    assert section.title == TITLE
    assert [row[0] for row in table.rows] == ["one", "two", "three", "four"]
    row = dict(zip(table.head, table.rows[0], strict=True))
    assert row["version"] == "1.2, executable"
    assert row["m_eff"] == "m, m/2"
    assert [row[-2] for row in table.rows] == ["independent", "one", "independent", "independent"]
    assert [row[-1] for row in table.rows] == [
        "qualified", "qualified", "missing: no three here", "did not qualify: free fall",
    ]  # fmt: skip
    assert section.items == ("one: It <always> clips. It counts m/2.",)


def test_results_read_back(verification, declared):
    found = replace(verification, engines=declared)
    record = json.loads(json.dumps(finite(found.to_json())))
    read = read_published(record)
    assert read.engines.declared == declared
    assert [row.name for row in read.checks] == [check.name for check in found.checks]
    assert read.headlines == found.headlines
    assert verification.to_json()["engines"] is None
