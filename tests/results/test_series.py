"""Limits and orders of series that are known; their first divergence, if there is one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.errors import RequestError
from harness.results.rows import Failure
from harness.results.series import RETURN, excursion_start, first_divergence, limit, slope_order

# ---- limits

STEPS = 1.0 / np.array([50.0, 100.0, 200.0, 400.0])


@given(value=st.floats(-10, 10), first=st.floats(-5, 5), second=st.floats(-5, 5))
def test_a_series_of_the_expected_form_is_taken_to_its_limit(value, first, second):
    h = 1 / np.array([10.0, 20.0, 40.0, 80.0, 160.0])
    y = value + first * h + second * h**1.5
    fit = limit(h, y, np.full(5, 1e-9), (1.0, 1.5))
    assert fit.value == pytest.approx(value, abs=1e-7)
    assert fit.curve(h) == pytest.approx(y, abs=1e-7)


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 4.0])
def test_the_order_of_a_pure_power_is_observed(order):
    fit = limit(STEPS, 3.0 + 0.7 * STEPS**order, np.full(4, 1e-12), (order,))
    slope, interval = slope_order(STEPS, 7 * STEPS**order)
    assert fit.order == pytest.approx(order, abs=1e-3)
    assert slope == pytest.approx(order, rel=1e-10)
    for low, high in (fit.order_interval, interval):
        assert low - 1e-6 <= order <= high + 1e-6


def test_errors_of_the_points_and_a_wrong_model_are_within_the_uncertainty():
    rng = np.random.default_rng(1)
    for _ in range(200):
        y = 10.0 + 0.3 * STEPS + rng.uniform(-1e-4, 1e-4, 4)
        fit = limit(STEPS, y, np.full(4, 1e-4))
        assert abs(fit.value - 10.0) <= fit.uncertainty
    fit = limit(STEPS, 1.0 + STEPS**0.5, np.full(4, 1e-9), (1.0,))
    assert abs(fit.value - 1.0) <= fit.uncertainty


def test_too_few_points_are_refused():
    with pytest.raises(RequestError, match=r"at least 4 points, not 3"):
        limit([1, 2, 3], [1, 2, 3], [1, 1, 1], (1.0, 1.5))


def test_the_interval_of_a_noisy_order_is_one_of_95_percent():
    rng = np.random.default_rng(2)
    h = 0.5 ** np.arange(8)
    intervals = [slope_order(h, h**2 * np.exp(rng.normal(0, 0.1, 8)))[1] for _ in range(200)]
    assert 180 <= sum(low <= 2.0 <= high for low, high in intervals) <= 200


# ---- divergence

TIME = np.linspace(0.0, 10.0, 1001)


def divergence(difference, band):
    zero = {"x": np.zeros_like(TIME)}
    return first_divergence(TIME, {"x": difference}, zero, absolute=band)


@given(start=st.floats(0.1, 9.0), rate=st.floats(0.2, 2.0), band=st.floats(1e-9, 1e-2))
def test_a_growing_swing_diverges_where_it_leaves_the_band_to_stay(start, rate, band):
    swing = np.where(start < TIME, np.expm1(rate * (TIME - start)) * np.cos(20 * TIME), 0.0)
    place = divergence(swing, band)
    first = int(np.searchsorted(TIME, place.time))
    assert place.time > start
    assert abs(swing[first]) > band
    assert place.largest == np.abs(swing).max()
    outside = TIME[:first][np.abs(swing[:first]) > band]
    assert outside.size == 0 or place.time - outside[-1] > RETURN * TIME[-1]


def test_crossing_zero_is_no_return_and_a_spike_before_does_not_count():
    spike = np.where(np.abs(TIME - 2.0) < 0.03, 1.0, 0.0)
    swing = np.where(TIME > 6.0, np.sin(7 * TIME), 0.0)
    assert divergence(spike + swing, 1e-3).time == pytest.approx(6.01)
    assert divergence(spike, 1e-3).time == pytest.approx(1.98)
    assert divergence(np.where(TIME > 4.0, np.nan, 0.0), 1.0).time == pytest.approx(4.01)
    assert excursion_start(TIME, np.zeros(TIME.size, bool)) is None


@pytest.mark.parametrize("first", [0, 1, 2, 500])
def test_the_class_of_a_divergence(first):
    place = divergence(np.where(np.arange(TIME.size) >= first, 1.0, 0.0), 0.5)
    assert place.failure is (Failure.FROM_FIRST_STEP if first <= 1 else Failure.LATE)
    assert str(place.failure) in place.note


def test_the_earliest_of_several_columns_counts_and_the_band_is_of_each():
    reference = {"x": 1000.0 * np.sin(TIME), "v": np.cos(TIME)}
    run = {"x": reference["x"] + 0.5, "v": reference["v"] + 1e-2 * (TIME > 3.0)}
    assert first_divergence(TIME, run, reference, relative=1e-3, absolute=0.1) is None
    place = first_divergence(TIME, run, reference, relative=1e-3)
    assert (place.column, place.time) == ("v", pytest.approx(3.01))


@pytest.mark.parametrize(
    ("time", "columns", "words"),
    [(TIME, {"y": TIME}, "no column 'x'"), (TIME[:-1], {"x": TIME}, "1000 samples, and 1001"),
     (TIME + 1e-3, {"x": TIME}, "other times")],
)  # fmt: skip
def test_series_that_cannot_be_compared_are_refused(time, columns, words):
    with pytest.raises(ValueError, match=words):
        first_divergence(time, columns, {"x": TIME}, reference_time=TIME)
