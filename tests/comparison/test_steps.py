"""The steps at which quantities moved."""

import math

import pytest

from harness.comparison.compare import RunPoint, steps
from harness.observables.row import Row


def point(run, value, *, tolerance=1e-3, verdict="pass", series="angle", release="1"):
    row = Row(series, value, 0.0, "deg")
    return RunPoint(series, run, row, tolerance, verdict, (("release", release), ("commit", "a")))


def test_a_value_that_stays_within_its_tolerance_makes_no_step():
    assert steps([point("one", 10.0), point("two", 10.0005), point("three", 10.0)]) == []


def test_a_step_names_the_runs_about_it_how_far_and_what_else_changed():
    runs = [point("one", 10.0), point("two", 10.0), point("three", 10.004, release="2")]
    (step,) = steps([*runs, point("four", 10.004, release="2")])
    assert (step.before.run, step.after.run) == ("two", "three")
    assert step.in_tolerances == pytest.approx(4.0)
    assert step.reasons == ("release: 1 → 2",)


def test_each_series_is_held_against_its_own_last_run():
    other = [point("two", 99.0, series="force"), point("three", 99.0, series="force")]
    assert steps([point("one", 10.0), *other, point("four", 10.0)]) == []


def test_a_verdict_that_changes_is_a_step_and_a_value_that_is_gone():
    assert len(steps([point("one", 10.0), point("two", 10.0, verdict="fail")])) == 1
    (step,) = steps([point("one", 10.0), point("two", math.nan)])
    assert math.isnan(step.in_tolerances)


def test_without_a_tolerance_round_off_is_no_step():
    (step,) = steps(
        point(run, value, tolerance=math.nan)
        for run, value in [("one", 1.0), ("two", 1.0 + 1e-14), ("three", 1.0 + 1e-9)]
    )
    assert step.after.run == "three"
