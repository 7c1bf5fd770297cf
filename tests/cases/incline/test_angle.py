"""Limits and orders of series that are known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.cases.incline.angle import limit
from harness.errors import RequestError

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
    low, high = fit.order_interval
    assert fit.order == pytest.approx(order, abs=1e-3)
    assert low - 1e-6 <= order <= high + 1e-6


def test_errors_of_the_points_and_a_wrong_model_are_within_the_uncertainty():
    rng = np.random.default_rng(1)
    for _ in range(50):
        y = 10.0 + 0.3 * STEPS + rng.uniform(-1e-4, 1e-4, 4)
        fit = limit(STEPS, y, np.full(4, 1e-4))
        assert abs(fit.value - 10.0) <= fit.uncertainty
    fit = limit(STEPS, 1.0 + STEPS**0.5, np.full(4, 1e-9), (1.0,))
    assert abs(fit.value - 1.0) <= fit.uncertainty


def test_too_few_points_are_refused():
    with pytest.raises(RequestError, match=r"at least 4 points, not 3"):
        limit([1, 2, 3], [1, 2, 3], [1, 1, 1], (1.0, 1.5))
