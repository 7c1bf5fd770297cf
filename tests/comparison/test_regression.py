import math
from dataclasses import replace

import numpy as np
import pytest

from harness.comparison.regression import (
    UNSTATED,
    Baseline,
    BaselineRecord,
    Expected,
    against_baseline,
    allowed_change,
    changed_parameters,
    explained_by_cells,
    name_in_cell,
)
from harness.comparison.series import Series
from harness.comparison.verdicts import Cell, Kind, Tolerance, Triage, Verdict, judge
from harness.errors import EngineMemoryError
from harness.observables.row import Row

TIME = np.linspace(0.0, 1.0, 101)
PATH = BaselineRecord(
    name="lammps/incline-path-source-10.2-deg",
    parameters={"stiffness": 1e6, "contact": {"tail": "attractive"}},
    quantities={
        "margin_over_mgd": Row("margin_over_mgd", -1e-4, 0.0, ""),
        "step_s": Row("step_s", 1e-5, 0.0, "s"),
    },
    engine="lammps",
    engine_version="1 Jan 2025",
    platform="Linux x86_64",
    script_sha256="aa",
    levels=("quick",),
    case="incline",
    family=("source",),
    series=Series(TIME, {"x_m": TIME**2}),
)
ANGLE = replace(
    PATH,
    name="lammps/incline-passage-source-k1e6-50-steps-8-phases",
    quantities={"critical_angle_deg": Row("critical_angle_deg", 10.2053, 1e-3, "deg")},
    series=None,
)
BASELINE = Baseline({case.name: case for case in (PATH, ANGLE)}, "here")
TOLERANCES = {
    "incline": {
        "critical_angle_deg": Tolerance("deg", 1e-9, 0.0, "round-off"),
        "margin_over_mgd": Tolerance("", 1e-11, 0.0, "round-off"),
        "step_s": Tolerance("s", 0.0, 1e-12, "a quotient of two counts"),
    }
}


def rows(*measured, baseline=BASELINE, level="quick", **more):
    expected = Expected(engines={"lammps", "exact"}, cases={"incline"}, **more)
    return against_baseline(measured, baseline, level, expected, TOLERANCES)


def by_quantity(found):
    return {check.name.rpartition(": ")[2].split(",")[0]: check for check in found.checks}


def moved(case, quantity, by):
    known = case.quantities[quantity]
    return replace(
        case,
        quantities={**case.quantities, quantity: replace(known, value=known.value + by)},
    )


def test_the_same_again_holds_in_every_row():
    found = rows(PATH, ANGLE)
    assert [check.verdict for check in found.checks] == [Verdict.PASS] * 4
    assert all(check.kind is Kind.REGRESSION and not check.note for check in found.checks)
    assert found.divergences == ()


def test_number_that_moved_without_a_series_is_out_of_tolerance():
    check = by_quantity(rows(PATH, moved(ANGLE, "critical_angle_deg", 1e-6)))["critical_angle_deg"]
    assert check.verdict is Verdict.FAIL
    assert check.triage == Triage.OUT_OF_TOLERANCE
    assert check.difference == pytest.approx(1e-6)


def test_it_takes_the_class_of_the_series_that_failed_beside_it():
    late = Series(TIME, {"x_m": TIME**2 + np.where(TIME > 0.5, 1e-3 * (TIME - 0.5), 0.0)})
    path = replace(moved(PATH, "margin_over_mgd", 1e-6), series=late)
    found = rows(path, moved(ANGLE, "critical_angle_deg", 1e-6))
    rows_ = by_quantity(found)
    assert rows_["margin_over_mgd"].triage.startswith("diverged late: x_m, at 0.51 s")
    assert rows_["critical_angle_deg"].triage.startswith("diverged late: x_m, at 0.51 s")
    assert [series.case for series in found.divergences] == [PATH.name]


def test_step_that_moved_is_a_wrong_input():
    check = by_quantity(rows(moved(PATH, "step_s", 1e-5), ANGLE))["step_s"]
    assert check.triage.startswith(Triage.WRONG_INPUT)


def test_other_parameters_fail_even_with_the_same_numbers():
    other = replace(PATH, parameters={"stiffness": 2e6, "contact": {"tail": "attractive"}})
    found = rows(other, ANGLE)
    failed = [check for check in found.checks if check.verdict is Verdict.FAIL]
    assert len(failed) == 2
    assert all("wrong input: stiffness = 2000000.0" in check.triage for check in failed)


@pytest.mark.parametrize(("part", "said"), [(5e-14, 0), (1e-9, 1)])
def test_a_derived_parameter_may_differ_in_the_processors_last_bits(part, said):
    known = {"duration": 2.7517674731056374}
    now = {"duration": known["duration"] * (1.0 + part)}
    assert now != known
    assert len(changed_parameters(now, known)) == said


def test_parameters_of_one_side_only_are_no_difference_and_nested_ones_are_seen():
    assert changed_parameters({"a": 1, "new": 2}, {"a": 1, "old": 3}) == []
    (said,) = changed_parameters({"contact": {"tail": "clipped"}}, PATH.parameters)
    assert said == "contact tail = 'clipped', the baseline's is 'attractive'"


def test_other_version_platform_and_script_are_compared_and_said():
    other = replace(PATH, engine_version="2 Feb 2026", platform="Linux arm", script_sha256="bb")
    for check in rows(other, ANGLE).checks[-3:]:
        assert check.verdict is Verdict.PASS
        for said in ("baseline of lammps 1 Jan 2025", "baseline of Linux x86_64", "script"):
            assert said in check.note


@pytest.mark.parametrize(
    ("more", "verdict", "triage", "note"),
    [
        ({}, Verdict.FAIL, Triage.MISSING, "nothing says why"),
        ({"reason": lambda _: "left out"}, Verdict.NOT_TESTED, "not tested", "left out"),
        (
            {"errors": {PATH.name: EngineMemoryError("4 GB")}},
            Verdict.FAIL,
            "out of memory",
            "out of memory: 4 GB",
        ),
    ],
)
def test_a_record_that_was_not_measured_fails_unless_there_is_a_reason(more, verdict, triage, note):
    (check,) = [c for c in rows(ANGLE, **more).checks if PATH.name in c.name]
    assert (check.verdict, check.triage) == (verdict, triage)
    assert note in check.note


@pytest.mark.parametrize(
    "lost",
    [
        {"quantities": {"margin_over_mgd": PATH.quantities["margin_over_mgd"]}},
        {"series": None},
        {"series": Series(TIME, {"y_m": TIME})},
    ],
    ids=["a quantity", "the series", "a column"],
)
def test_what_a_record_does_not_hold_any_more_fails(lost):
    failed = [c for c in rows(replace(PATH, **lost), ANGLE).checks if c.verdict is Verdict.FAIL]
    assert failed
    assert all(check.triage.startswith(Triage.MISSING) for check in failed)


def test_only_relatives_take_the_class_of_a_series():
    late = Series(TIME, {"x_m": TIME**2 + np.where(TIME > 0.5, 1e-3 * (TIME - 0.5), 0.0)})
    path = replace(moved(PATH, "margin_over_mgd", 1e-6), series=late)
    for change in ({"family": ("plastic",)}, {"family": ()}, {"case": "tower"}):
        angle = replace(moved(ANGLE, "critical_angle_deg", 1e-6), **change)
        check = by_quantity(rows(path, angle))["critical_angle_deg"]
        assert check.triage == Triage.OUT_OF_TOLERANCE


def test_case_without_a_baseline_is_not_tested():
    found = rows(PATH, ANGLE, replace(ANGLE, name="lammps/new"))
    (check,) = [c for c in found.checks if "lammps/new" in c.name]
    assert check.verdict is Verdict.NOT_TESTED
    assert "baseline accept" in check.note


@pytest.mark.parametrize("change", [{"engine": "mfix"}, {"case": "tower"}])
def test_records_of_another_engine_or_case_are_left_out(change):
    other = replace(PATH, name="mfix/path", **change)
    baseline = Baseline({**BASELINE.records, other.name: other})
    assert not [c for c in rows(PATH, ANGLE, baseline=baseline).checks if "mfix" in c.name]


def test_number_that_is_not_one_fails_as_nan():
    nan = moved(ANGLE, "critical_angle_deg", math.nan)
    check = by_quantity(rows(PATH, nan))["critical_angle_deg"]
    assert check.verdict is Verdict.FAIL
    assert check.triage == Triage.NAN


def test_a_case_that_states_no_tolerance_has_that_of_round_off():
    assert allowed_change(TOLERANCES, "other", "z") == UNSTATED
    assert allowed_change(TOLERANCES, "incline", "series") == UNSTATED


CELL = Cell("oblique", "mindlin", "wall", "lammps")
CONTACT = BaselineRecord(
    name=name_in_cell(CELL),
    parameters={},
    quantities={
        "tangential_ratio": Row("tangential_ratio", 0.5, 0.0, ""),
        "spin_ratio": Row("spin_ratio", 0.2, 0.0, ""),
    },
    engine="lammps",
    engine_version="1 Jan 2025",
    levels=("quick",),
    case="incline",
)


def in_cell(quantity, verdict, note="", cell=CELL):
    name = f"oblique, wall: mindlin, lammps{quantity and f': {quantity}'}"
    row = judge(name, Kind.ANALYTIC, 1.0, 1.0, Tolerance("", 1.0, 0.0, "a test"), note=note)
    return replace(row, verdict=verdict, cell=cell)


def against_cells(measured, *judged):
    found = rows(*measured, baseline=Baseline({CONTACT.name: CONTACT}, "here"))
    return explained_by_cells(found.checks, judged)


@pytest.mark.parametrize("verdict", [Verdict.KNOWN_DEFECT, Verdict.FIXED])
def test_a_value_that_a_known_defect_moved_is_told_with_it(verdict):
    left, moved_too = against_cells(
        [moved(CONTACT, "tangential_ratio", 0.1)],
        in_cell("tangential_ratio", verdict, "known defect no-friction: its cause"),
        in_cell("spin_ratio", Verdict.PASS),
    )
    assert (left.verdict, moved_too.verdict) == (verdict, Verdict.PASS)
    assert "no-friction" in left.note


@pytest.mark.parametrize("verdict", [Verdict.KNOWN_DEFECT, Verdict.NOT_TESTED])
def test_a_known_defect_explains_no_other_parameters(verdict):
    accepted = replace(CONTACT, parameters={"speed": 1.0})
    baseline = Baseline({accepted.name: accepted}, "here")
    found = rows(replace(accepted, parameters={"speed": 2.0}), baseline=baseline)
    judged = [in_cell(name, verdict, "its cause") for name in CONTACT.quantities]
    for row in explained_by_cells(found.checks, judged):
        assert (row.verdict, row.triage) == (
            Verdict.FAIL,
            f"{Triage.WRONG_INPUT}: speed = 2.0, the baseline's is 1.0",
        )


def test_a_value_that_moved_beside_a_known_defect_of_another_quantity_fails():
    _, spin = against_cells(
        [moved(CONTACT, "spin_ratio", 0.1)],
        in_cell("tangential_ratio", Verdict.KNOWN_DEFECT, "its cause"),
        in_cell("spin_ratio", Verdict.PASS),
    )
    assert spin.verdict is Verdict.FAIL


@pytest.mark.parametrize(
    "other",
    [
        in_cell("tangential_ratio", Verdict.FAIL),
        in_cell("tangential_ratio", Verdict.KNOWN_DEFECT, cell=replace(CELL, system="pair")),
        in_cell("tangential_ratio", Verdict.KNOWN_DEFECT, cell=replace(CELL, invariance="turned")),
    ],
)
def test_a_value_that_no_row_of_its_cell_explains_fails(other):
    row, _ = against_cells([moved(CONTACT, "tangential_ratio", 0.1)], other)
    assert row.verdict is Verdict.FAIL


@pytest.mark.parametrize("verdict", [Verdict.KNOWN_DEFECT, Verdict.NOT_TESTED])
def test_a_record_that_is_missing_is_told_with_what_became_of_its_cell(verdict):
    (row,) = against_cells([], in_cell("", verdict, "the release has no such submodel"))
    assert row.verdict is verdict
    assert row.note == "the release has no such submodel"
    (row,) = against_cells([])
    assert "nothing says why" in row.note
