"""The rebound of a falling sphere in closed form, against the integration of the law."""

import math

import pytest
from scipy.integrate import solve_ivp

from harness.model.law import damping_ratio
from harness.theory import contact
from tests.theory.sliding import MASS, G

OMEGA = math.sqrt(1e5 / MASS)
ZETA = damping_ratio(0.8)


@pytest.mark.parametrize("speed", [1.0, 0.02])
def test_rebound_is_that_of_the_integrated_contact(speed):
    def leaves(_, y):
        return y[0]

    def turns(_, y):
        return y[1]

    leaves.terminal, leaves.direction = True, -1.0
    path = solve_ivp(
        lambda _, y: [y[1], G - 2.0 * ZETA * OMEGA * y[1] - OMEGA**2 * y[0]],
        (0.0, 1.0), [0.0, speed], "DOP853", rtol=1e-13, atol=1e-18, events=[leaves, turns],
        first_step=1e-9,
    )  # fmt: skip
    rebound = contact.rebound(OMEGA, ZETA, G, speed)
    expected = path.t[-1], -path.y[1, -1], path.y_events[1][0, 0]
    assert tuple(rebound) == pytest.approx(expected, rel=1e-10)


def test_without_gravity_it_is_the_dashpot_alone_and_a_slow_sphere_stays():
    rebound = contact.rebound(OMEGA, ZETA, 0.0, 2.0)
    assert rebound.speed / 2.0 == pytest.approx(0.8, rel=1e-12)
    duration = math.pi / OMEGA / math.sqrt(1.0 - ZETA**2)
    assert rebound.duration == pytest.approx(duration, rel=1e-12)
    assert contact.rebound(OMEGA, ZETA, G, 1e-5) is None
