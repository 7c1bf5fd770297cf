"""Means over seeds: intervals against a closed form, verdicts of equivalence."""

import math

import numpy as np
import pytest
from scipy.stats import norm
from scipy.stats import t as student

from harness.cases.bulk.equivalence import Sample, equivalence, interval
from harness.comparison.verdicts import Tolerance, Verdict

MARGIN = Tolerance("", 0.0, 0.05, "stated before")


def sample(mean, spread, count=24, seed=0):
    values = np.random.default_rng(seed).normal(mean, spread, count)
    return Sample("code", tuple(values - values.mean() + mean))


def test_the_interval_of_a_mean_is_that_of_the_normal_distribution_for_many_seeds():
    one = sample(3.0, 0.4, 400)
    half = norm.ppf(0.95) * np.std(one.values) / math.sqrt(400)
    low, high = interval(one.values)
    assert (high - low) / 2 == pytest.approx(half, rel=0.05)


def test_the_interval_of_a_ratio_adds_both_variances():
    one, other = sample(1.0, 0.02, 400), sample(2.0, 0.06, 400, seed=1)
    half = norm.ppf(0.95) * 0.5 * math.hypot(0.02, 0.03) / math.sqrt(400)
    low, high = interval(one.values, other.values)
    assert (high - low) / 2 == pytest.approx(half, rel=0.1)


@pytest.mark.parametrize(("count", "level"), [(4, 0.102), (12, 0.065), (24, 0.057)])
def test_few_seeds_make_a_test_of_more_than_five_percent(count, level):
    """Resampled means scatter by s sqrt((n - 1)/n)/sqrt(n), about as a normal distribution does.

    Of two samples of a normal distribution, the ratio then is beyond its true value by more than
    the interval as often as Student's t of 2 n - 2 is beyond z sqrt((n - 1)/n).
    """
    bound = norm.ppf(0.95) * math.sqrt((count - 1) / count)
    assert student.sf(bound, 2 * count - 2) == pytest.approx(level, abs=5e-4)
    draws = np.random.default_rng(5).normal(1.0, 0.02, (2, 3, count))
    for one, other in zip(*draws, strict=True):
        low, high = interval(one, other)
        ratio = one.mean() / other.mean()
        error = math.hypot(np.std(one) / one.mean(), np.std(other) / other.mean())
        width = 2 * norm.ppf(0.95) * ratio * error / math.sqrt(count)
        assert high - low == pytest.approx(width, rel=0.05)


def test_equal_numbers_have_no_width():
    assert interval((2.0,) * 5) == (2.0, 2.0)


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
