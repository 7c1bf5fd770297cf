import math

import pytest

from harness.comparison.verdicts import (
    Kind,
    Tolerance,
    Triage,
    Verdict,
    failed_run,
    finding,
    judge,
    not_tested,
)
from harness.errors import EngineCrashError, EngineTimeoutError

ABSOLUTE = Tolerance("deg", 1e-3, 0.0, "a test")


@pytest.mark.parametrize(
    ("value", "verdict"),
    [
        (10.0005, Verdict.PASS),
        (9.9995, Verdict.PASS),
        (10.0011, Verdict.FAIL),
        (math.nan, Verdict.FAIL),
        (math.inf, Verdict.FAIL),
    ],
)
def test_judge(value, verdict):
    assert judge("x", Kind.ANALYTIC, value, 10.0, ABSOLUTE).verdict is verdict


@pytest.mark.parametrize(
    ("expected", "absolute", "relative"),
    [
        (math.inf, 0.0, 0.1),
        (-math.inf, 1.0, 0.1),
        (math.nan, 1.0, 0.1),
        (10.0, math.inf, 0.0),
        (10.0, 0.0, math.inf),
        (10.0, math.nan, 0.0),
    ],
)
def test_what_is_not_finite_beside_a_value_passes_nothing_and_accuses_no_engine(
    expected, absolute, relative
):
    row = judge("x", Kind.ANALYTIC, 3.0, expected, Tolerance("m", absolute, relative, "a test"))
    assert row.verdict is Verdict.FAIL
    assert row.triage.startswith(Triage.HARNESS)
    row = judge("x", Kind.ANALYTIC, math.nan, expected, Tolerance("m", absolute, relative, ""))
    assert (row.verdict, row.triage) == (Verdict.FAIL, Triage.NAN)


def test_relative_tolerance_grows_with_what_is_expected():
    relative = Tolerance("N", 0.0, 1e-3, "a test")
    assert judge("x", Kind.CROSS_CODE, 1000.9, 1000.0, relative).verdict is Verdict.PASS
    assert judge("x", Kind.CROSS_CODE, 1.9, 1.0, relative).verdict is Verdict.FAIL


def test_rows_that_are_no_judgement_are_never_a_pass():
    died = failed_run("x", Kind.CROSS_CODE, EngineTimeoutError("5 s"))
    assert died.verdict is Verdict.FAIL
    assert died.engine_died
    assert died.note == "out of time: 5 s"
    assert not_tested("x", Kind.CROSS_CODE, "no mpirun").verdict is Verdict.NOT_TESTED
    assert finding("x", 1.0, 2.0, "deg", "differs").verdict is Verdict.FINDING


def test_a_check_is_published_with_its_difference_and_the_name_of_its_log():
    error = EngineCrashError("signal")
    error.log = "last words"
    row = failed_run("a run", Kind.ANALYTIC, error, "deg")
    record = row.to_json()
    assert record["log"] == row.log_name
    assert record["log"].startswith("a-run-")
    assert math.isnan(record["difference"])
    told = judge("x", Kind.ANALYTIC, 3.0, 1.0, Tolerance("", 0.0, 0.0, "")).to_json()
    assert (told["difference"], told["verdict"], told["kind"]) == (2.0, "fail", "analytic")
