import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from harness.errors import RequestError
from harness.theory.chain import shock_from_impulse_ratio
from harness.theory.incline import (
    STATIC_ANGLE_DEG,
    critical_angle,
    no_flight_bound,
    steady_energy,
    well_depth,
)
from tests.theory.closed_forms import slid_over_sphere

SHOCKS = st.floats(0.0, 1.0)


def keeps_moving(angle, shock, start=5.0, wells=4000):
    """Follow the grain from well to well; tell whether it is still moving after all of them."""
    theta = math.radians(angle)
    crest_ahead = 1 - math.cos(math.pi / 6 - theta)
    crest_behind = 1 - math.cos(math.pi / 6 + theta)
    energy = start
    for _ in range(wells):
        if energy < crest_ahead:
            return False
        energy = shock * (energy - crest_ahead + crest_behind)
    return True


def smallest_normal_force(angle, shock=0.25):
    """Integrate one steady cycle from well to well; return the least contact force in m g."""
    theta = math.radians(angle)
    energy = math.sin(theta) * shock / (1 - shock)

    slid = slid_over_sphere(theta, energy)
    return float(np.min(np.cos(slid.y[0]) - slid.y[1] ** 2))


def test_value_of_the_source():
    assert critical_angle() == pytest.approx(10.20782, abs=5e-6)


@pytest.mark.parametrize("shock", [0.01, 0.1, 0.25, 0.5, 0.9])
def test_closed_form_is_the_root_of_the_steady_state_condition(shock):
    root = brentq(lambda a: steady_energy(a, shock) - well_depth(a), 0.0, 30.0, xtol=1e-12)
    assert critical_angle(shock) == pytest.approx(root, abs=1e-9)


@pytest.mark.parametrize("shock", [0.1, 0.25, 0.5])
def test_closed_form_by_bisection_of_the_fate(shock):
    low, high = 0.0, 30.0
    while high - low > 1e-7:
        middle = (low + high) / 2
        low, high = (low, middle) if keeps_moving(middle, shock) else (middle, high)
    assert critical_angle(shock) == pytest.approx((low + high) / 2, abs=1e-6)


def test_limits_of_the_shock():
    assert critical_angle(0.0) == pytest.approx(STATIC_ANGLE_DEG, rel=1e-14)
    assert critical_angle(1.0) == 0.0
    assert critical_angle(1e-12) == pytest.approx(30.0, abs=1e-4)
    assert critical_angle(1.0 - 1e-12) == pytest.approx(0.0, abs=1e-9)


@given(SHOCKS, SHOCKS)
def test_critical_angle_falls_with_the_shock_and_stays_in_range(one, other):
    low, high = sorted((one, other))
    assert 0.0 <= critical_angle(high) <= critical_angle(low) <= STATIC_ANGLE_DEG * (1 + 1e-14)


@pytest.mark.parametrize(("ratio", "angle"), [(0.53, 4.7), (0.54, 4.8), (0.947, 9.5)])
def test_reduced_impulse_of_tall_towers_lowers_the_angle(ratio, angle):
    assert critical_angle(shock_from_impulse_ratio(ratio)) == pytest.approx(angle, abs=0.1)


def steady_state_condition(angle, divisor):
    """Return the two sides' difference as the source prints them, with theta / divisor."""
    theta = math.radians(angle)
    return 0.25 / 0.75 - 2 * math.sin(math.pi / 12 - theta / divisor) ** 2 / math.sin(theta)


@pytest.mark.parametrize(("divisor", "angle"), [(4, 13.87), (2, 10.21)])
def test_erratum_only_half_of_the_angle_gives_the_angle_of_the_source(divisor, angle):
    root = brentq(steady_state_condition, 0.1, 30.0, args=(divisor,))
    assert root == pytest.approx(angle, abs=0.005)
    assert (abs(root - critical_angle()) < 1e-9) is (divisor == 2)


def test_no_flight_bound_is_where_the_integrated_contact_force_vanishes():
    assert no_flight_bound() == pytest.approx(15.30, abs=0.005)
    root = brentq(smallest_normal_force, 12.0, 20.0, xtol=1e-8)
    assert no_flight_bound() == pytest.approx(root, abs=1e-6)


@given(st.floats(0.0, 0.999))
def test_no_flight_bound_falls_with_the_shock(shock):
    assert 0.0 < no_flight_bound(shock) <= no_flight_bound(0.0) < STATIC_ANGLE_DEG


@pytest.mark.parametrize("value", [-0.1, 1.1, math.nan, math.inf])
@pytest.mark.parametrize("function", [critical_angle, no_flight_bound])
def test_shock_out_of_range_is_named(function, value):
    with pytest.raises(RequestError, match=r"^shock = \S+ is not allowed: must be from 0 to "):
        function(value)


def test_no_steady_motion_to_bound_without_loss():
    with pytest.raises(RequestError, match="below 1"):
        no_flight_bound(1.0)
