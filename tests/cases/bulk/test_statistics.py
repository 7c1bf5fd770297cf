"""Means over seeds, mixing index, angle of a surface: closed forms, second routes, limits."""

import math

import numpy as np
import pytest
from scipy.special import ndtri, stdtr, stdtrit  # scipy.stats takes a second to load

from harness.cases.bulk.comparison import (
    EQUIVALENT,
    Sample,
    mean_interval,
    ratio_of_means,
    same_shares,
)
from harness.cases.bulk.drum import lacey_index, surface_angle
from harness.errors import Unsupported
from harness.results.rows import Row, Verdict, judge

RNG = np.random.default_rng(7)


def test_either_side_of_the_interval_misses_five_percent_of_four_seeds():
    """Of a bootstrap's percentiles it is 10 % for 4 seeds: t of 6 beyond 1.645 sqrt(3/4)."""
    bound = ndtri(0.95) * math.sqrt(3 / 4)
    assert stdtr(6, -bound) == pytest.approx(0.102, abs=5e-4)
    random = np.random.default_rng(5)
    draws, missed = 400, np.zeros(2)
    for _ in range(draws):
        found = ratio_of_means(random.normal(1.0, 0.02, 4), random.normal(1.0, 0.05, 4))
        missed += found.value - 1.0 > found.uncertainty, 1.0 - found.value > found.uncertainty
    assert missed / draws == pytest.approx(0.05, abs=0.02)


def test_the_intervals_are_student_s_of_a_mean_and_welch_s_of_a_ratio():
    """By the formula: variances of both means, Welch and Satterthwaite's degrees of freedom."""
    one, other = np.array([1.0, 2.0, 4.0, 9.0]), np.array([5.0, 5.5, 7.0, 8.0, 8.5])
    half = stdtrit(3, 0.975) * np.std(one, ddof=1) / 2.0
    assert mean_interval(one) == pytest.approx((4.0 - half, 4.0 + half))
    assert mean_interval(np.full(4, 2.0)) == (2.0, 2.0)
    assert math.isnan(mean_interval(one[:3])[0])
    ratio = one.mean() / other.mean()
    parts = [one.var(ddof=1) / 4, ratio**2 * other.var(ddof=1) / 5]
    freedom = sum(parts) ** 2 / (parts[0] ** 2 / 3 + parts[1] ** 2 / 4)
    half = stdtrit(freedom, 0.95) * math.sqrt(sum(parts)) / other.mean()
    found = ratio_of_means(one, other)
    assert (found.value, found.uncertainty) == pytest.approx((ratio, half), rel=1e-12)


ONES = [1.0] * 4
NAN, INFINITE = [math.nan, 1.0, 1.0, 1.0], [math.inf] * 4
NO_RATIO = [(ONES, [0.0] * 4), (INFINITE, INFINITE), (NAN, ONES), (ONES, NAN), ([0.0] * 4, ONES)]


@pytest.mark.parametrize(("first", "second"), NO_RATIO)
@pytest.mark.filterwarnings("ignore:invalid value")
def test_means_without_a_ratio_fail(first, second):
    found = ratio_of_means(np.array(first), np.array(second))
    row = Row(case="c", setup="s", quantity="q", engine="e", value=found.value,
              uncertainty=found.uncertainty, expected=1.0)  # fmt: skip
    assert judge(row, EQUIVALENT, failure=found.failure).verdict is Verdict.FAIL


@pytest.mark.parametrize("values", [[0.0] * 4, [-1.0, 1.0, -1.0, 1.0]])
def test_a_mean_of_0_in_the_second_code_decides_nothing(values):
    with pytest.raises(Unsupported, match="no ratio"):
        ratio_of_means(np.array(values), np.array(values))


def test_shares_that_chance_gives_in_one_case_of_a_hundred_are_not_the_same():
    def share(first, second):
        return same_shares(*(Sample(({},) * n, (), ("",) * lost) for n, lost in (first, second)))

    assert share((16, 0), (16, 0)).value == 1.0
    assert share((12, 0), (4, 8)).value < 0.01 < share((12, 0), (8, 4)).value
    assert share((4, 0), (4, 0)).value == 1.0
    for lost in ((0, 4), (1, 3)):  # of four runs chance alone may lose all of one code
        with pytest.raises(Unsupported, match=r"0 of 4 and . of 4 runs, which"):
            share((4, 0), lost)
    with pytest.raises(Unsupported, match="16 of 16 and 16 of 16"):
        share((0, 16), (0, 16))


# ---- mixing index: cells are column and row


def in_row(cells):
    return np.column_stack([cells, np.zeros(len(cells))])


def test_unmixed_kinds_have_the_index_0_and_a_random_mixture_1_in_the_mean():
    """Whatever the cells hold: 300 deals of 400 grains over cells of 1 to 60."""
    cells = np.repeat(np.arange(10), 30)
    assert lacey_index(in_row(cells), cells < 4) == pytest.approx(0.0, abs=1e-12)
    cells = np.repeat(np.arange(20), RNG.integers(1, 61, 20))
    chosen = np.arange(len(cells)) < 0.7 * len(cells)
    found = [lacey_index(in_row(cells), RNG.permutation(chosen)) for _ in range(300)]
    assert np.mean(found) == pytest.approx(1.0, abs=4 * np.std(found) / math.sqrt(300))
    assert math.isnan(lacey_index(in_row(np.arange(5) // 2), np.ones(5, dtype=bool)))


def test_between_them_it_is_that_of_lacey_for_cells_of_one_content():
    """(s0^2 - s^2)/(s0^2 - sr^2) with s0^2 = p(1-p), sr^2 = p(1-p)/n, up to 1/N."""
    n, shares = 500, np.array([0.2, 0.4, 0.6, 0.8])
    chosen = np.concatenate([np.arange(n) < share * n for share in shares])
    apart, variance = 0.25, np.mean((shares - 0.5) ** 2)
    lacey = (apart - variance) / (apart - apart / n)
    cells = np.column_stack([np.repeat([0, 0, 1, 1], n), np.repeat([0, 1, 0, 1], n)])
    assert lacey_index(cells, chosen) == pytest.approx(lacey, rel=1e-3)


@pytest.mark.parametrize("angle", [-20.0, 0.0, 35.0])
def test_the_angle_is_that_of_the_plane_under_which_grains_lie(angle):
    x, depth = RNG.uniform(-1, 1, 20000), RNG.uniform(0, 0.5, 20000)
    z = -x * math.tan(math.radians(angle)) - depth - 0.01
    assert surface_angle(x, z, np.full(20000, 0.01), 0.5, 0.05) == pytest.approx(angle, abs=0.5)
