"""Rigid spheres by events, against closed forms and limits of other solvers."""
# ruff: noqa: I001

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.errors import RequestError
from harness.solvers.hard_sphere import (
    LEAVES, MOVES_ON, SHOCK, TRAPPED, TURNS, WELL, critical_angle, first_moving, flight, follow,
    passage, slide,
)  # fmt: skip
from harness.theory import incline as theory
from harness.theory.chain import SHOCK_WITHOUT_REBOUND


@given(st.floats(-0.4, 0.4), st.floats(0.01, 1.5), st.floats(0.0, 0.4))
def test_a_flight_ends_on_a_sphere_and_passes_through_none(sideways, up, theta):
    x, y = math.sin(0.1), math.cos(0.1)
    vx, vy = sideways + up * x, up * y
    if x * vx + y * vy <= 1e-3:
        return
    t, sphere = flight(x, y, vx, vy, theta, 0)

    def gap(s, of):
        px = x + vx * s + 0.5 * math.sin(theta) * s * s
        return np.hypot(px - of, y + vy * s - 0.5 * math.cos(theta) * s * s) - 1.0

    assert 0.0 < t < 10.0
    assert abs(gap(t, sphere)) < 1e-12
    assert gap(np.linspace(0.0, t, 500)[1:-1, None], np.arange(-8, 10)).min() > -1e-12


def test_sliding_ends_where_force_or_speed_vanish_or_the_next_sphere_is_met():
    theta = 0.2
    assert slide(1.0, 0.1, True, theta) == (pytest.approx(WELL + theta), SHOCK)
    beta, how = slide(1.3, -0.1, True, theta)
    assert (math.cos(beta), how) == (pytest.approx(2.0 * 1.3 / 3.0), LEAVES)
    beta, how = slide(0.9, -0.6, True, theta)
    assert (beta, how) == (pytest.approx(-math.acos(0.9)), TURNS)
    assert slide(0.9, -0.3, False, theta) == (pytest.approx(-(WELL - theta)), SHOCK)


def test_without_restitution_it_is_the_closed_form():
    assert critical_angle(0.0) == pytest.approx(theory.critical_angle(), abs=1e-9)
    for angle in (9.0, 10.2, 11.0, 14.0):
        fate, margin, hits, slid, _ = passage(angle, 0.0)
        expected = theory.passage_margin(angle, SHOCK_WITHOUT_REBOUND)
        assert margin == pytest.approx(expected, abs=1e-14)
        assert fate == (MOVES_ON if margin > 0.0 else TRAPPED)
        assert slid
        assert hits >= 1
    # the limit is smooth: a little restitution costs a little
    assert critical_angle(1e-3) == pytest.approx(theory.critical_angle(), abs=1e-5)
    # exp(-2) is what clipping leaves of critical damping; LAMMPS and the reference tend to 10.224
    assert critical_angle(math.exp(-2.0)) == pytest.approx(10.224, abs=5e-4)


@pytest.mark.parametrize("restitution", [0.0, 0.1, 0.5])
def test_passage_and_steady_motion_give_the_same_angle(restitution):
    speed = 0.48  # [sqrt(g d)] in the well, along the sphere ahead: it takes the grain over a crest
    x, y = math.sin(WELL), math.cos(WELL)

    def steady(angle):
        start = x, y, speed * y, speed * x
        return follow(*start, math.radians(angle), restitution, 100, False)[0]

    moving = first_moving(steady)
    assert moving == pytest.approx(critical_angle(restitution), abs=1e-8)


def test_no_collision_gains_energy_and_none_loses_any_at_restitution_one():
    theta = math.radians(5.0)
    x, y, vx, vy = 0.3, 1.4, 0.2, 0.0
    before = 0.5 * (vx * vx + vy * vy) + y * math.cos(theta) - x * math.sin(theta)
    for wells in (1, 3, 6):
        fate, over, hits, *_ = follow(x, y, vx, vy, theta, 1.0, wells, False)
        assert fate == MOVES_ON
        assert over == pytest.approx(before - 1.0 + wells * math.sin(theta), abs=1e-11)
    assert hits > 0


@pytest.mark.parametrize("restitution", [-0.1, 0.71, math.nan])
def test_a_restitution_that_makes_no_sense_is_refused(restitution):
    with pytest.raises(RequestError, match=r"must be from 0 to 0.7"):
        critical_angle(restitution)
