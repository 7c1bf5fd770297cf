"""The linear dashpot: restitution, duration and overlap, also of a falling sphere, integrated."""

import cmath
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from harness.model.law import damping_ratio
from harness.theory.contact import (
    duration_clipped,
    duration_unclipped,
    largest_overlap,
    restitution_clipped,
    restitution_unclipped,
)
from harness.theory.contact import rebound as rebound_under_gravity


def collide(zeta, ends):
    """Integrate the contact until ``ends(x, v)`` falls to zero; return the duration and -v."""

    def motion(_, state):
        return [state[1], -state[0] - 2 * zeta * state[1]]

    def event(_, state):
        return ends(*state)

    event.terminal, event.direction = True, -1.0
    # a step past x = v = 0 so that the events do not fire at the first touch
    early = 1e-9
    start = [early, 1.0 - 2 * zeta * early]
    run = solve_ivp(
        motion, (early, 500.0), start, events=event, rtol=1e-11, atol=1e-13, method="DOP853"
    )
    assert run.status == 1
    return run.t[-1], -run.y[1, -1]


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.3, 0.6, 0.85])
def test_unclipped_restitution_and_duration_against_integration_until_the_overlap_is_gone(zeta):
    duration, restitution = collide(zeta, lambda x, _: x)
    assert duration_unclipped(zeta) == pytest.approx(duration, rel=1e-6)
    assert restitution_unclipped(zeta) == pytest.approx(restitution, rel=1e-5)


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.3, 0.6, 0.9, 0.9999, 1.0, 1.0001, 1.5, 5.0])
def test_clipped_restitution_and_duration_against_integration_until_the_force_is_gone(zeta):
    duration, restitution = collide(zeta, lambda x, v: x + 2 * zeta * v)
    assert duration_clipped(zeta) == pytest.approx(duration, rel=1e-6)
    assert restitution_clipped(zeta) == pytest.approx(restitution, rel=1e-5)


@given(st.floats(0.0, 0.999), st.floats(0.0, 3.0))
def test_clipping_never_lowers_the_restitution(zeta, other):
    assert restitution_clipped(zeta) >= restitution_unclipped(zeta)
    low, high = sorted((zeta, other))
    assert restitution_clipped(high) <= restitution_clipped(low) * (1 + 1e-9)


@given(st.floats(1e-12, 1.0))
def test_damping_ratio_inverts_the_unclipped_restitution(restitution):
    assert restitution_unclipped(damping_ratio(restitution)) == pytest.approx(restitution, rel=1e-9)


def test_ends_of_the_damping_ratio():
    assert damping_ratio(0.0) == 1.0
    assert damping_ratio(1.0) == 0.0
    assert damping_ratio(1e-20) == pytest.approx(0.99768, abs=5e-6)
    assert restitution_unclipped(1.0) == restitution_unclipped(5.0) == 0.0


@pytest.mark.parametrize("zeta", [0.0, 0.2, 0.7, 1.1, 2.0, 10.0])
def test_the_largest_overlap_is_that_of_the_integrated_motion(zeta):
    root = cmath.sqrt(1.0 - zeta * zeta)
    t = np.linspace(0.0, duration_clipped(zeta), 200_001)
    x = np.exp(-zeta * t) * (np.sin(root * t) / root).real
    assert largest_overlap(zeta) == pytest.approx(x.max(), rel=1e-9)


# ---- a falling sphere

G, OMEGA = 9.81, math.sqrt(1e5 / 0.01)
DAMPING = damping_ratio(0.8)


@pytest.mark.parametrize("speed", [1.0, 0.02])
def test_rebound_is_that_of_the_integrated_contact(speed):
    def leaves(_, y):
        return y[0]

    def turns(_, y):
        return y[1]

    leaves.terminal, leaves.direction = True, -1.0
    path = solve_ivp(
        lambda _, y: [y[1], G - 2.0 * DAMPING * OMEGA * y[1] - OMEGA**2 * y[0]],
        (0.0, 1.0), [0.0, speed], "DOP853", rtol=1e-13, atol=1e-18, events=[leaves, turns],
        first_step=1e-9,
    )  # fmt: skip
    rebound = rebound_under_gravity(OMEGA, DAMPING, G, speed)
    expected = path.t[-1], -path.y[1, -1], path.y_events[1][0, 0]
    assert tuple(rebound) == pytest.approx(expected, rel=1e-10)


def test_without_gravity_it_is_the_dashpot_alone_and_a_slow_sphere_stays():
    rebound = rebound_under_gravity(OMEGA, DAMPING, 0.0, 2.0)
    assert rebound.speed / 2.0 == pytest.approx(0.8, rel=1e-12)
    duration = math.pi / OMEGA / math.sqrt(1.0 - DAMPING**2)
    assert rebound.duration == pytest.approx(duration, rel=1e-12)
    assert rebound_under_gravity(OMEGA, DAMPING, G, 1e-5) is None
