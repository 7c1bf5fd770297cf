"""Means over seeds: intervals against closed forms, errors of the first kind, limits."""

import math

import numpy as np
import pytest
from scipy.stats import norm
from scipy.stats import t as student

from harness.cases.bulk.statistics import (
    EQUIVALENT,
    mean_interval,
    ratio_of_means,
    same_shares,
)
from harness.errors import Unsupported
from harness.results.rows import Row, Verdict, judge


def verdict(first, second):
    value = ratio_of_means(np.array(first, dtype=float), np.array(second, dtype=float))
    row = Row(case="c", setup="s", quantity="q", engine="e", value=value.value,
              uncertainty=value.uncertainty, expected=1.0)  # fmt: skip
    return judge(row, EQUIVALENT, failure=value.failure).verdict


@pytest.mark.parametrize(("first", "second"), [(4, 4), (12, 12), (4, 24)])
def test_either_side_of_the_interval_misses_five_percent_however_few_the_seeds(first, second):
    """Of a bootstrap's percentiles it is 10 % for 4 seeds: t of 6 beyond 1.645 sqrt(3/4)."""
    bound = norm.ppf(0.95) * math.sqrt(3 / 4)
    assert student.sf(bound, 6) == pytest.approx(0.102, abs=5e-4)
    random = np.random.default_rng(5)
    draws, missed = 1500, np.zeros(2)
    for _ in range(draws):
        found = ratio_of_means(random.normal(1.0, 0.02, first), random.normal(1.0, 0.05, second))
        missed += found.value - 1.0 > found.uncertainty, 1.0 - found.value > found.uncertainty
    assert missed / draws == pytest.approx(0.05, abs=0.02)


def test_the_interval_of_a_mean_is_student_s():
    values = np.array([1.0, 2.0, 4.0, 9.0])
    half = student.ppf(0.975, 3) * np.std(values, ddof=1) / 2.0
    assert mean_interval(values) == pytest.approx((4.0 - half, 4.0 + half))
    assert mean_interval(np.full(4, 2.0)) == (2.0, 2.0)
    assert math.isnan(mean_interval(values[:3])[0])


def test_the_interval_of_a_ratio_is_welch_s():
    """By the formula: variances of both means, Welch and Satterthwaite's degrees of freedom."""
    one, other = np.array([1.0, 2.0, 4.0, 9.0]), np.array([5.0, 5.5, 7.0, 8.0, 8.5])
    ratio = one.mean() / other.mean()
    parts = [one.var(ddof=1) / 4, ratio**2 * other.var(ddof=1) / 5]
    freedom = sum(parts) ** 2 / (parts[0] ** 2 / 3 + parts[1] ** 2 / 4)
    half = student.ppf(0.95, freedom) * math.sqrt(sum(parts)) / other.mean()
    found = ratio_of_means(one, other)
    assert (found.value, found.uncertainty) == pytest.approx((ratio, half), rel=1e-12)


NO_RATIO = [
    ([1.0] * 4, [0.0] * 4),
    ([math.inf, 1.0, 1.0, 1.0], [1.0] * 4),
    ([1.0] * 4, [math.inf] * 4),
    ([math.inf] * 4, [math.inf] * 4),
    ([math.nan, 1.0, 1.0, 1.0], [1.0, 1.1, 1.0, 1.1]),
    ([1.0] * 4, [math.nan] * 4),
    ([0.0] * 4, [1.0] * 4),
]


@pytest.mark.parametrize(("first", "second"), NO_RATIO)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_means_without_a_ratio_fail(first, second):
    assert verdict(first, second) is Verdict.FAIL


@pytest.mark.parametrize("first", [[0.0] * 4, [-1.0, 1.0, -1.0, 1.0]])
def test_a_mean_of_0_in_the_second_code_decides_nothing(first):
    with pytest.raises(Unsupported, match="no ratio"):
        ratio_of_means(np.array(first), np.array(first))


def test_shares_that_chance_gives_in_one_case_of_a_hundred_are_not_the_same():
    assert same_shares((16, 0), (16, 0)).value == 1.0
    assert same_shares((12, 0), (4, 8)).value < 0.01 < same_shares((12, 0), (8, 4)).value
