"""Figures of chains: the order that a figure states is that of its data."""

import numpy as np
import pytest

from harness.cases.tower import figures


def test_the_order_of_an_error_is_that_of_its_power():
    steps = np.geomspace(0.01, 0.3, 8)
    figure = figures.peak_error({"RK4": (steps, steps**5)}, {"RK4": (1 / steps, steps)})
    assert "order 5.00" in figure.legends[0].get_texts()[0].get_text()
    slope, half = figures.measured_order(steps, 3 * steps**2)
    assert slope == pytest.approx(2)
    assert half < 1e-6
