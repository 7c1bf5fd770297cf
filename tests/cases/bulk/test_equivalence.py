"""Means over seeds: intervals against a closed form, verdicts of equivalence."""

import math

import numpy as np
import pytest
from scipy.stats import norm, ttest_ind
from scipy.stats import t as student

from harness.cases.bulk.equivalence import Sample, equivalence, interval
from harness.comparison.verdicts import Tolerance, Verdict

MARGIN = Tolerance("", 0.0, 0.05, "stated before")


def sample(mean, spread, count=24, seed=0):
    values = np.random.default_rng(seed).normal(mean, spread, count)
    return Sample("code", tuple(values - values.mean() + mean))


@pytest.mark.parametrize(("first", "second"), [(4, 4), (12, 12), (4, 24)])
def test_either_side_of_the_interval_misses_five_percent_however_few_the_seeds(first, second):
    """Of a bootstrap's percentiles it is 10 % for 4 seeds: t of 6 beyond 1.645 sqrt(3/4)."""
    bound = norm.ppf(0.95) * math.sqrt(3 / 4)
    assert student.sf(bound, 6) == pytest.approx(0.102, abs=5e-4)
    random = np.random.default_rng(5)
    draws = 1500
    missed = np.zeros(2)
    for _ in range(draws):
        one, other = random.normal(1.0, 0.02, first), random.normal(1.0, 0.05, second)
        low, high = interval(one, other)
        missed += low > 1.0, high < 1.0
    assert missed / draws == pytest.approx(0.05, abs=0.02)


def test_the_interval_of_a_mean_is_student_s():
    values = (1.0, 2.0, 4.0, 9.0)
    half = student.ppf(0.975, 3) * np.std(values, ddof=1) / 2.0
    assert interval(values, confidence=0.95) == pytest.approx((4.0 - half, 4.0 + half))


def test_the_interval_of_a_ratio_is_that_of_the_difference_by_scipy():
    one, other = (1.0, 2.0, 4.0, 9.0), (5.0, 5.5, 7.0, 8.0, 8.5)
    ratio = np.mean(one) / np.mean(other)
    welch = ttest_ind(one, ratio * np.array(other), equal_var=False).confidence_interval(0.9)
    expected = ratio + np.array(welch) / np.mean(other)
    assert interval(one, other) == pytest.approx(tuple(expected), rel=1e-12)


@pytest.mark.parametrize(
    ("mean", "spread", "verdict"),
    [
        (1.0, 0.02, Verdict.PASS),
        (1.03, 0.02, Verdict.PASS),
        (1.2, 0.02, Verdict.FAIL),
        (0.8, 0.02, Verdict.FAIL),
        (1.0, 0.4, Verdict.NOT_TESTED),  # too few seeds for a verdict is no pass
        (1.05, 0.02, Verdict.NOT_TESTED),
    ],
)
def test_codes_are_equivalent_only_where_the_whole_interval_is_within_the_margin(
    mean, spread, verdict
):
    row = equivalence("depth", sample(mean, spread), sample(1.0, spread, seed=1), MARGIN)
    assert row.verdict is verdict
    assert "90 % interval" in row.note


@pytest.mark.parametrize(
    ("one", "other", "verdict"),
    [
        (0.0, 0.0, Verdict.NOT_TESTED),  # no ratio: neither code is to blame
        (1.0, 0.0, Verdict.FAIL),
        (0.0, 1.0, Verdict.FAIL),
        (math.inf, 1.0, Verdict.FAIL),
        (1.0, math.inf, Verdict.FAIL),
        (math.inf, math.inf, Verdict.FAIL),
        (math.nan, 1.0, Verdict.FAIL),
        (1.0, math.nan, Verdict.FAIL),
        (math.nan, 0.0, Verdict.FAIL),
    ],
)
def test_means_without_a_ratio_never_hold(one, other, verdict):
    ones = Sample("one", (one, *(one or 0.0 for _ in range(3))))
    others = Sample("other", (other,) * 4)
    assert equivalence("rate", ones, others, MARGIN).verdict is verdict


def test_one_seed_that_is_infinite_is_no_wide_interval():
    infinite = Sample("one", (math.inf, 1.0, 1.0, 1.0))
    assert equivalence("rate", infinite, sample(1.0, 0.02), MARGIN).verdict is Verdict.FAIL


def test_a_mean_of_0_about_which_seeds_lie_decides_nothing():
    about = Sample("other", (-1.0, 1.0, -1.0, 1.0))
    row = equivalence("rate", sample(1.0, 0.02), about, MARGIN)
    assert row.verdict is Verdict.NOT_TESTED
    assert "no ratio" in row.note
