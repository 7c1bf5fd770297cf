import math

import pytest

from harness.comparison.run_diff import RowChange, diff_runs
from harness.comparison.verification import read_published
from tests.published_run import RUN


def row(name="angle", verdict="pass", kind="analytic", **changes):
    return {
        "name": name,
        "kind": kind,
        "unit": "deg",
        "value": 10.0,
        "expected": 10.0,
        "difference": 0.0,
        "uncertainty": 0.3,
        "tolerance": 0.5,
        "verdict": verdict,
        **changes,
    }


def run(*rows, **changes):
    engine = {"engine": "lammps", "engine_version": "1 Jan 2030"}
    return read_published({**RUN, "engine": engine, "checks": rows, **changes})


def only(found):
    (one,) = found.rows
    return one


@pytest.mark.parametrize(
    ("before", "after", "change", "status"),
    [
        ("pass", "pass", RowChange.SAME, 0),
        ("pass", "fail", RowChange.WORSE, 1),
        ("pass", "not tested", RowChange.WORSE, 1),
        ("not tested", "fail", RowChange.WORSE, 1),
        ("fail", "pass", RowChange.BETTER, 0),
        ("fail", "not tested", RowChange.BETTER, 0),
        ("not tested", "pass", RowChange.BETTER, 0),
        ("fail", "fail", RowChange.SAME, 0),
    ],
)
def test_change_of_a_verdict(before, after, change, status):
    found = diff_runs(run(row(verdict=before)), run(row(verdict=after)))
    assert only(found).change is change
    assert found.status == status


def test_a_move_is_told_in_its_unit_in_tolerances_and_in_both_uncertainties():
    one = only(diff_runs(run(row()), run(row(value=11.0, uncertainty=0.4))))
    assert one.change is RowChange.MOVED
    assert one.moved_by == pytest.approx(1.0)
    assert one.in_tolerances == pytest.approx(2.0)
    assert one.in_uncertainties == pytest.approx(2.0)  # 3, 4, 5
    exact = {"tolerance": 0.0, "uncertainty": 0.0}
    moved = only(diff_runs(run(row(**exact)), run(row(value=9.0, **exact))))
    assert (moved.in_tolerances, math.isnan(moved.in_uncertainties)) == (-math.inf, True)


def test_a_missing_number_that_stays_missing_has_not_moved():
    assert only(diff_runs(run(row(value=None)), run(row(value=None)))).change is RowChange.SAME
    assert only(diff_runs(run(row(value=None)), run(row()))).change is RowChange.MOVED


def test_a_check_that_is_gone_is_worse_at_the_same_level_only():
    assert diff_runs(run(row()), run()).status == 1
    assert diff_runs(run(row()), run(level="full")).status == 0
    assert diff_runs(run(row(verdict="finding", kind="finding")), run()).status == 0


@pytest.mark.parametrize(
    ("verdict", "status"),
    [("pass", 1), ("fail", 1), ("known defect", 1), ("fixed", 1), ("not tested", 0)],
)
def test_a_row_that_was_decided_is_not_lost_unseen(verdict, status):
    assert diff_runs(run(row(verdict=verdict)), run()).status == status


OTHERWISE = {"engine": {"engine": "lammps", "engine_version": "1 Jan 2030", "how": "executable"}}


@pytest.mark.parametrize(
    ("rows", "changes"),
    [
        (([row()], []), {"level": "full"}),
        (([], [row()]), {"level": "full"}),
        (([], [row(verdict="fail")]), {"level": "full"}),
        (([row()], [row(verdict="not tested")]), OTHERWISE),
        (([row(verdict="not tested")], [row()]), OTHERWISE),
        (([row()], []), OTHERWISE),
    ],
)
def test_what_only_one_level_or_way_of_running_has_is_not_comparable(rows, changes):
    before, after = rows
    found = diff_runs(run(*before), run(*after, **changes))
    assert only(found).change is RowChange.NOT_COMPARABLE
    assert found.status == 0


@pytest.mark.parametrize(
    ("before", "after"), [("pass", "fail"), ("pass", "known defect"), ("known defect", "fail")]
)
def test_what_both_ways_of_running_judged_is_compared(before, after):
    found = diff_runs(run(row(verdict=before)), run(row(verdict=after), **OTHERWISE))
    assert only(found).change is RowChange.WORSE
    assert found.status == 1


@pytest.mark.parametrize(("verdict", "status"), [("pass", 0), ("fail", 1)])
def test_a_check_that_is_new(verdict, status):
    found = diff_runs(run(), run(row(verdict=verdict)))
    assert only(found).change is RowChange.ADDED
    assert found.status == status


def test_names_meet_within_their_kind_and_in_order():
    first = run(row(value=1.0), row(value=2.0), row(kind="regression", value=3.0))
    second = run(row(kind="regression", value=3.0), row(value=1.0), row(value=5.0))
    moved = [r for r in diff_runs(first, second).rows if r.change is RowChange.MOVED]
    assert [(r.before.value, r.after.value) for r in moved] == [(2.0, 5.0)]


def test_everything_else_that_differs_is_named():
    engine = {"engine": "lammps", "engine_version": "2 Feb 2031"}
    before = run(scripts={"tower.in": "a" * 64, "same.in": "b" * 64})
    after = run(platform="elsewhere", engine=engine, scripts={"same.in": "b" * 64, "new.in": "c"})
    found = diff_runs(before, after)
    assert {c.name: (c.before, c.after) for c in found.metadata} == {
        "platform": ("a test", "elsewhere"),
        "engine version": ("1 Jan 2030", "2 Feb 2031"),
        "script tower.in": ("a" * 12, "not there"),
        "script new.in": ("not there", "c"),
    }


@pytest.mark.parametrize("missing", ["before", "after"])
def test_a_row_that_one_side_lacks_has_no_move_also_with_a_tolerance_of_0(missing):
    one = run(row(tolerance=0.0, uncertainty=0.0))
    runs = (run(), one) if missing == "before" else (one, run())
    found = only(diff_runs(*runs))
    assert math.isnan(found.in_tolerances)
    assert math.isnan(found.in_uncertainties)


def test_another_expectation_of_a_headline_is_named():
    told = {"name": "angle", "unit": "deg", "value": 10.0, "uncertainty": 0.1, "who": "x"}
    before = run(headlines=[told | {"expected": 10.2}])
    after = run(headlines=[told | {"expected": 10.3}])
    (change,) = diff_runs(before, after).metadata
    assert (change.name, change.before, change.after) == ("expected angle", "10.2", "10.3")
