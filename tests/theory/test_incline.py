"""The incline without friction: geometry, energy map, critical angle, and their second routes."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from harness.errors import RequestError
from harness.theory.chain import shock_from_impulse_ratio, shock_from_restitution
from harness.theory.incline import (
    STATIC_ANGLE_DEG,
    after_next_shock,
    critical_angle,
    energies,
    gain_per_crest,
    no_flight_bound,
    passage_margin,
    steady_energy,
    well_depth,
)
from tests.theory.closed_forms import slid_over_sphere

ANGLES, SHOCKS = st.floats(0.0, 30.0), st.floats(0.0, 1.0)


# ---- geometry, which the closed forms were derived without


@given(ANGLES)
def test_well_depth_and_gain_are_differences_of_height(angle):
    def height(along, normal):
        tilt = math.radians(angle)
        return normal * math.cos(tilt) - along * math.sin(tilt)

    crests = [1.0 + height(sphere, 0.0) for sphere in (0, 1)]
    assert crests[1] - height(0.5, math.sqrt(0.75)) == pytest.approx(well_depth(angle), abs=1e-14)
    assert crests[0] - crests[1] == pytest.approx(gain_per_crest(angle), abs=1e-14)


# ---- energy map


@pytest.mark.parametrize("angle", [5.0, 10.2, 15.0])
def test_one_cycle_agrees_with_sliding_motion_integrated_over_a_sphere(angle):
    start, theta = well_depth(angle) + 0.05, math.radians(angle)
    arrival = slid_over_sphere(theta, start).y_events[0][0][1]
    survives = (arrival * math.cos(math.radians(60))) ** 2 / 2
    assert after_next_shock(start, angle, 0.25) == pytest.approx(survives, rel=1e-8)


@given(st.floats(0.0, 2.0), st.integers(1, 40), ANGLES, SHOCKS)
def test_closed_form_energies_are_the_recursion_iterated(start, shocks, angle, shock):
    energy, expected = start, []
    for _ in range(shocks):
        energy = shock * (energy + gain_per_crest(angle))
        expected.append(energy)
    # E* cancels in the closed form: its error grows as 1 / (1 - shock)
    tolerance = 1e-12 * (1.0 + (steady_energy(angle, shock) if shock < 1.0 else shocks))
    assert energies(start, shocks, angle, shock) == pytest.approx(expected, abs=tolerance)


@given(ANGLES, st.floats(0.0, 0.99))
def test_the_steady_energy_is_a_fixed_point_and_clears_the_crest_with_a_margin(angle, shock):
    rest = steady_energy(angle, shock)
    assert after_next_shock(rest, angle, shock) == pytest.approx(rest, rel=1e-12, abs=1e-15)
    excess = rest - well_depth(angle)
    assert passage_margin(angle, shock) == pytest.approx((1.0 - shock) * excess, abs=1e-12)


# ---- critical angle


def keeps_moving(angle, shock, energy=5.0, wells=4000):
    theta = math.radians(angle)
    ahead, behind = (1 - math.cos(math.pi / 6 + sign * theta) for sign in (-1, 1))
    for _ in range(wells):
        if energy < ahead:
            return False
        energy = shock * (energy - ahead + behind)
    return True


@pytest.mark.parametrize("shock", [0.01, 0.1, 0.25, 0.5, 0.9])
def test_the_angle_is_the_root_of_the_steady_state_and_where_the_fate_changes(shock):
    root = brentq(lambda a: steady_energy(a, shock) - well_depth(a), 0.0, 30.0, xtol=1e-12)
    assert critical_angle(shock) == pytest.approx(root, abs=1e-9)
    assert keeps_moving(critical_angle(shock) + 1e-6, shock)
    assert not keeps_moving(critical_angle(shock) - 1e-6, shock)


def test_limits_of_the_shock():
    assert critical_angle() == pytest.approx(10.20782, abs=5e-6)  # the source's value
    assert critical_angle(0.0) == pytest.approx(STATIC_ANGLE_DEG, rel=1e-14)
    assert critical_angle(1e-12) == pytest.approx(30.0, abs=1e-4)
    assert critical_angle(1.0 - 1e-12) == pytest.approx(0.0, abs=1e-9)
    assert steady_energy(10.0, 1.0) == math.inf


def test_the_bound_of_flight_is_where_the_integrated_contact_force_vanishes():
    def smallest_force(angle):  # [m g] in steady motion, from well to well
        slid = slid_over_sphere(math.radians(angle), steady_energy(angle, 0.25))
        return float(np.min(np.cos(slid.y[0]) - slid.y[1] ** 2))

    root = brentq(smallest_force, 12.0, 20.0, xtol=1e-8)
    assert no_flight_bound() == pytest.approx(root, abs=1e-6)
    bounds = [no_flight_bound(shock) for shock in np.linspace(0.0, 0.99, 9)]
    assert bounds[-1] > 0.0
    assert bounds == sorted(bounds, reverse=True)


@pytest.mark.parametrize("value", [-0.1, 1.1, math.nan])
@pytest.mark.parametrize("function", [critical_angle, no_flight_bound, shock_from_restitution])
def test_a_value_out_of_range_is_named(function, value):
    with pytest.raises(RequestError, match=r"^\w+ = \S+ is not allowed: must be from 0 to "):
        function(value)


# ---- the shock in the well


@given(SHOCKS)
def test_the_shock_of_a_restitution_is_that_of_a_collision_in_vectors(restitution):
    before, normal = (
        np.array([math.cos(math.radians(angle)), math.sin(math.radians(angle))])
        for angle in (-30.0, 120.0)
    )
    after = before - (1 + restitution) * (before @ normal) * normal
    kept = after @ after
    assert shock_from_restitution(restitution) == pytest.approx(kept, rel=1e-12)
    lost = shock_from_restitution(restitution, "lost")
    assert lost == pytest.approx((1.0 - math.sqrt(kept)) ** 2, abs=1e-12)


@given(st.floats(1e-6, 2.0 - 1e-6))
def test_the_impulse_of_a_rigid_base_leaves_half_of_the_velocity(ratio):
    kept, lost = (shock_from_impulse_ratio(ratio, reading) for reading in ("kept", "lost"))
    assert kept == pytest.approx(0.25 * ratio**2, rel=1e-12)
    assert math.sqrt(kept) + math.sqrt(lost) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("ratio", [0.0, 2.0, math.nan])
def test_ratios_out_of_range_and_other_readings_are_named(ratio):
    with pytest.raises(RequestError, match=r"^impulse-ratio = .* than 2$"):
        shock_from_impulse_ratio(ratio)
    with pytest.raises(RequestError, match="'given' is not allowed: must be 'kept' or 'lost'"):
        shock_from_impulse_ratio(0.5, "given")
