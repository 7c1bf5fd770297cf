"""Rows against the baseline that defects of one release have moved: by their size, and no other."""

import math
from dataclasses import replace

import pytest

from harness.comparison.known_defects import KnownDefect, moved_by_defects
from harness.comparison.regression import BaselineRecord, name_in_cell, row_name
from harness.comparison.verdicts import Cell, Kind, PredictedSize, Tolerance, Triage, Verdict, judge
from harness.observables.row import Row

CELL = Cell("oblique", "mindlin", "wall", "lammps")
RECORD = BaselineRecord(
    name=name_in_cell(CELL),
    parameters={},
    quantities={"spin_ratio": Row("spin_ratio", 0.5, 0.0, "")},
    engine="lammps",
    engine_version="22 Jul 2025",
)
DEFECT = {
    "name": "slippery",
    "engine": "lammps",
    "cases": ["oblique"],
    "submodels": ["mindlin"],
    "until": "2 Aug 2023",
    "cause": "friction is a tenth of what it should be",
    "predicts": {"law": {"friction": 0.1}},
    "upstream": "not reported",
}


class Predicted:
    """Moves a value by 0.1 with the defect."""

    def moved(self, here, there, width):
        apart = 0.1 * ((here is not None) - (there is not None))
        return PredictedSize(((apart - width, apart + width),))


def told(value, version="23 Jun 2022", cell=CELL, predict=None, triage="", **changes):
    width = Tolerance("", 1e-9, 0.0, "a test")
    name = row_name(RECORD.name, "spin_ratio")
    row = judge(name, Kind.REGRESSION, value, 0.5, width, triage=triage)
    limit = judge("oblique, wall: mindlin, lammps: spin_ratio", Kind.ANALYTIC, 0.5, 0.5, width)
    limit = replace(limit, cell=cell, predict=predict or Predicted())
    defects = [KnownDefect(**{**DEFECT, **changes})]
    records = {RECORD.name: RECORD}
    (found,) = moved_by_defects([row], [limit], records, defects, {"lammps": version})
    return found


def test_a_run_that_a_defect_moved_as_predicted_is_told_with_it():
    row = told(0.6)
    assert row.verdict is Verdict.KNOWN_DEFECT
    assert "slippery (here) predict a difference of 0.1 +- 2e-09, it is 0.1" in row.note


def test_a_defect_of_the_release_of_the_baseline_moves_it_the_other_way():
    dates = {"until": "", "since": "22 Jul 2025"}
    assert told(0.4, **dates).verdict is Verdict.KNOWN_DEFECT
    assert "slippery (there)" in told(0.4, **dates).note
    assert told(0.6, **dates).verdict is Verdict.FAIL


def test_what_is_too_small_for_a_record_is_a_value_of_none():
    changes = {"predict": type("Away", (), {"moved": lambda *_: PredictedSize(((-0.6, -0.4),))})()}
    assert told(math.nan, **changes).verdict is Verdict.KNOWN_DEFECT
    assert told(math.nan).verdict is Verdict.FAIL


@pytest.mark.parametrize(
    "changes",
    [
        {"value": 0.6 + 1e-8},
        {"version": "22 Jul 2025"},
        {"until": ""},
        {"cell": replace(CELL, invariance="turned")},
        {"cases": ["spin"]},
        {"invariances": ["turned"]},
        {"predicts": {"error": "Lost atoms"}},
        {"predict": lambda *_: PredictedSize(((0.0, 1.0),))},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_another_size_and_a_defect_of_both_or_of_neither_fail(changes):
    assert told(**{"value": 0.6, **changes}).verdict is Verdict.FAIL


def test_a_run_with_other_parameters_is_moved_by_these():
    wrong = f"{Triage.WRONG_INPUT}: speed = 2.0, the baseline's is 1.0"
    row = told(0.6, triage=wrong)
    assert (row.verdict, row.triage) == (Verdict.FAIL, wrong)


def test_a_size_that_cannot_be_computed_excuses_nothing():
    def moved(*_):
        raise ValueError("no steps")

    row = told(0.6, predict=type("Not", (), {"moved": moved})())
    assert row.verdict is Verdict.FAIL
    assert "no steps" in row.note
