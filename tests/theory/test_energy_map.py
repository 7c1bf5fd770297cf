import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.theory.incline import (
    after_next_shock,
    energies,
    gain_per_crest,
    passage_margin,
    passage_margin_slope,
    steady_energy,
    well_depth,
)
from tests.theory.closed_forms import slid_over_sphere

ANGLES = st.floats(0.0, 30.0)
SHOCKS = st.floats(0.0, 0.99)


@pytest.mark.parametrize("angle", [5.0, 10.2, 15.0])
def test_one_cycle_agrees_with_sliding_motion_integrated_over_a_sphere(angle):
    start, theta = well_depth(angle) + 0.05, math.radians(angle)

    slid = slid_over_sphere(theta, start)
    arrival = slid.y_events[0][0][1]
    survives = (arrival * math.cos(math.radians(60))) ** 2 / 2
    assert after_next_shock(start, angle, 0.25) == pytest.approx(survives, rel=1e-8)


@given(st.floats(0.0, 2.0), st.integers(1, 40), ANGLES, st.floats(0.0, 1.0))
def test_closed_form_energies_are_the_recursion_iterated(start, shocks, angle, shock):
    energy, expected = start, []
    for _ in range(shocks):
        energy = shock * (energy + gain_per_crest(angle))
        expected.append(energy)
    # E* cancels in the closed form: its error grows as 1 / (1 - shock)
    tolerance = 1e-12 * (1.0 + (steady_energy(angle, shock) if shock < 1.0 else shocks))
    assert energies(start, shocks, angle, shock) == pytest.approx(expected, abs=tolerance)


@given(ANGLES, SHOCKS)
def test_steady_energy_is_where_the_recursion_stays(angle, shock):
    rest = steady_energy(angle, shock)
    assert after_next_shock(rest, angle, shock) == pytest.approx(rest, rel=1e-12, abs=1e-15)


def test_without_loss_the_energy_grows_by_the_gain_for_ever():
    assert steady_energy(10.0, 1.0) == math.inf
    assert steady_energy(10.0, 1.5) == math.inf
    grown = energies(0.3, 5, 10.0, 1.0)
    assert np.diff(grown) == pytest.approx([gain_per_crest(10.0)] * 4, rel=1e-12)


@given(ANGLES, SHOCKS)
def test_sign_of_the_passage_margin_tells_whether_the_steady_energy_clears_the_crest(angle, shock):
    excess = steady_energy(angle, shock) - well_depth(angle)
    margin = passage_margin(angle, shock)
    assert margin == pytest.approx((1.0 - shock) * excess, abs=1e-12)


@given(st.floats(0.01, 29.99), st.floats(0.0, 1.0))
def test_slope_of_the_passage_margin_by_differences(angle, shock):
    step = 1e-3
    ahead, behind = passage_margin(angle + step, shock), passage_margin(angle - step, shock)
    assert passage_margin_slope(angle, shock) == pytest.approx(
        (ahead - behind) / (2 * step), rel=1e-6, abs=1e-10
    )
