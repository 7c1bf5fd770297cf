"""The verdict of a row: within, beyond, undecided, and never a pass without a number."""

import math

import pytest

from harness.cases.base import Check
from harness.cases.bench import Bench
from harness.cases.checks import run_checks
from harness.results.rows import Failure, Kind, Row, Tolerance, Verdict, judge

FAIL, PASS, UNDECIDED = Verdict.FAIL, Verdict.PASS, Verdict.NOT_TESTED
VALUES = {  # value, uncertainty, expected, tolerance: verdict
    "at the edge": (1.5, 0.0, 1.0, 0.5, PASS),
    "beyond": (math.nextafter(1.5, 2.0), 0.0, 1.0, 0.5, FAIL),
    "undecided": (1.2, 0.6, 1.0, 0.5, UNDECIDED),
    "beyond by more than it is uncertain by": (2.0, 0.4, 1.0, 0.5, FAIL),
    "NaN": (math.nan, 0.0, 1.0, 0.5, FAIL),
    "NaN expected": (1.0, 0.0, math.nan, 0.5, FAIL),
    "NaN uncertain": (1.0, math.nan, 1.0, 0.5, FAIL),
    "NaN allowed": (1.0, 0.0, 1.0, math.nan, FAIL),
    "infinite": (math.inf, 0.0, 1.0, 0.5, FAIL),
    "infinite and uncertain": (math.inf, math.inf, 1.0, 0.5, FAIL),
    "infinite as expected": (math.inf, 0.0, math.inf, 0.5, FAIL),
    "all allowed": (1.0, 0.0, 1.0, math.inf, FAIL),
}


@pytest.mark.parametrize("name", VALUES)
def test_verdict(name):
    value, uncertainty, expected, width, verdict = VALUES[name]
    row = Row(case="a", setup="b", quantity="c", engine="d", value=value, expected=expected,
              uncertainty=uncertainty)  # fmt: skip
    assert judge(row, Tolerance(width)).verdict is verdict


@pytest.mark.parametrize("kind", Kind)
def test_a_measurement_that_is_not_a_number_fails_whatever_its_kind(kind):
    check = Check(
        setup="b", quantity="c", unit="1", measure=lambda _: math.nan, expected=1.0,
        tolerance=Tolerance(1.0), kind=kind,
    )  # fmt: skip
    (row,) = run_checks("a", [check], Bench(None))
    assert (row.verdict, row.failure, row.kind) == (FAIL, Failure.NOT_A_NUMBER, kind)
