"""Limits and observed orders of series that are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.errors import RequestError
from harness.results.limits import limit, slope_order

STEPS = np.array([50.0, 100.0, 200.0, 400.0])


@given(
    value=st.floats(-10, 10),
    first=st.floats(-5, 5),
    second=st.floats(-5, 5),
)
def test_a_series_of_the_expected_form_is_taken_to_its_limit(value, first, second):
    h = 1 / np.array([10.0, 20.0, 40.0, 80.0, 160.0])
    y = value + first * h + second * h**1.5
    found = limit(h, y, np.full(5, 1e-9), (1.0, 1.5))
    assert found.value == pytest.approx(value, abs=1e-7)
    assert found.curve(h) == pytest.approx(y, abs=1e-7)


@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 4.0])
def test_the_order_of_a_pure_power_is_observed(order):
    h = 1 / STEPS
    found = limit(h, 3.0 + 0.7 * h**order, np.full(4, 1e-12), (order,))
    assert found.order == pytest.approx(order, abs=1e-3)
    low, high = found.order_interval
    assert low - 1e-6 <= order <= high + 1e-6


def test_points_with_bounded_errors_stay_within_the_uncertainty():
    rng = np.random.default_rng(1)
    h = 1 / STEPS
    for _ in range(200):
        error = 1e-4
        y = 10.0 + 0.3 * h + rng.uniform(-error, error, 4)
        found = limit(h, y, np.full(4, error))
        assert abs(found.value - 10.0) <= found.uncertainty


def test_a_wrong_model_widens_the_uncertainty():
    h = 1 / STEPS
    y = 1.0 + h**0.5
    found = limit(h, y, np.full(4, 1e-9), (1.0,))
    assert abs(found.value - 1.0) <= found.uncertainty
    assert found.order == pytest.approx(0.5, abs=1e-3)


def test_too_few_points_are_refused():
    with pytest.raises(RequestError, match=r"at least 4 points, not 3"):
        limit([1, 2, 3], [1, 2, 3], [1, 1, 1], (1.0, 1.5))


@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
def test_slope_order_of_an_exact_power(order):
    h = np.array([0.1, 0.05, 0.025, 0.0125])
    slope, (low, high) = slope_order(h, 7 * h**order)
    assert slope == pytest.approx(order, rel=1e-10)
    assert low <= order + 1e-10
    assert order - 1e-10 <= high


def test_slope_order_interval_holds_a_noisy_order():
    rng = np.random.default_rng(2)
    h = 0.5 ** np.arange(8)
    inside = 0
    for _ in range(200):
        noisy = h**2 * np.exp(rng.normal(0, 0.1, 8))
        low, high = slope_order(h, noisy)[1]
        inside += low <= 2.0 <= high
    assert 180 <= inside <= 200
