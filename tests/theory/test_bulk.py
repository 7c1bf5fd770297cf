"""Discharge, wall friction, depth of an impact: second routes, and limits."""

import math

import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from harness.theory.bulk import (
    BEVERLOO_MARGIN,
    DEPTH_FACTOR,
    beverloo_scale,
    friction_by_depth,
    janssen_share,
)


@pytest.mark.parametrize("height", [0.01, 0.1, 1.0])
def test_janssens_share_is_the_balance_of_slices_integrated(height):
    """d(stress)/dz = rho g - 2 mu K stress / R from the surface down; the floor bears the rest."""
    radius, friction, ratio, weight = 0.05, 0.3, 0.5, 1.5e4
    found = solve_ivp(
        lambda _, stress: weight - 2 * friction * ratio * stress / radius,
        (0, height), [0.0], rtol=1e-10, atol=1e-9,
    )  # fmt: skip
    on_floor = found.y[0, -1] / (weight * height)
    assert janssen_share(height, radius, friction, ratio) == pytest.approx(1 - on_floor, rel=1e-7)


def test_janssens_share_is_half_of_x_in_a_shallow_bed_and_all_in_a_deep_one():
    x = 2 * 0.2 * 0.5 * 1e-4
    assert janssen_share(1e-4, 1.0, 0.2, 0.5) == pytest.approx(x / 2, rel=1e-4)
    assert janssen_share(1e6, 1.0, 0.2, 0.5) == pytest.approx(1.0, abs=1e-4)
    assert janssen_share(1.0, 1.0, 0.0, 0.5) == 0.0


def test_beverloos_scale_is_that_of_a_free_fall_from_the_orifice():
    """By dimensions: density, sqrt(g) and the free width to 5/2; nothing below k diameters."""
    grain, width = 2e-3, 0.03
    wide = BEVERLOO_MARGIN * grain + width
    one = beverloo_scale(wide, grain, 1500.0, 9.81)
    assert one == pytest.approx(1500 * width**2 * math.sqrt(9.81 * width))
    assert beverloo_scale(wide, grain, 3000.0, 4 * 9.81) == pytest.approx(4 * one)
    assert beverloo_scale(BEVERLOO_MARGIN * grain, grain, 1500.0, 9.81) == 0.0


@pytest.mark.parametrize("fall", [0.0, 0.01, 10.0])
def test_the_friction_by_depth_is_that_of_the_depth_that_solves_the_law(fall):
    friction, diameter, ratio = 0.45, 0.0254, 5.1
    factor = DEPTH_FACTOR / friction * math.sqrt(ratio) * diameter ** (2 / 3)
    depth = brentq(lambda d: d - factor * (fall + d) ** (1 / 3), 1e-6, 10.0, xtol=1e-14)
    assert friction_by_depth(depth, fall, diameter, ratio) == pytest.approx(friction, rel=1e-9)
    if fall == 0.0:  # a sphere that is let go on the surface
        alone = (DEPTH_FACTOR / friction) ** 1.5 * ratio**0.75 * diameter
        assert depth == pytest.approx(alone, rel=1e-9)
    if fall == 10.0:  # far above, the depth does not count
        assert depth == pytest.approx(factor * fall ** (1 / 3), rel=0.01)
