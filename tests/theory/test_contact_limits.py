"""Forms of contacts that the limit of the reference does not reach, and where there is no form.

Sliding, rolling, twisting, drag, heat and moving walls are compared with that limit by law and
system, with the cases.
"""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.special import j0, j1

from harness.model.scene import sphere
from harness.theory import contact

RADIUS, STIFFNESS, G = 0.01, 3e5, 9.81
MASS = sphere(RADIUS, 2500.0).mass


@pytest.mark.parametrize(("speed", "pull"), [(0.5, 0.0), (0.5, -1.0), (0.02, 1.5)])
def test_a_constant_torque_slows_a_sphere_that_rolls(speed, pull):
    load, end = MASS * G, 0.01
    limits = 0.3 * load, 0.05 * load

    def newton(_, y):
        spring, u, rim = y
        force = STIFFNESS * spring
        return u - rim, pull - force / MASS, (force - limits[1]) / (0.4 * MASS)

    ran = solve_ivp(newton, (0.0, end), (0.0, speed, speed), "DOP853", rtol=1e-13, atol=1e-18)
    state = contact.against_constant_torque(end, speed, pull, MASS, STIFFNESS, limits)
    assert state == pytest.approx(ran.y[1:, -1], rel=1e-9)
    # a stiff spring: it rolls, and the torque takes 5/7 mu_r g from 5/7 of the pull
    rigid = contact.against_constant_torque(end, speed, pull, MASS, 1e22, limits)
    assert rigid[0] == pytest.approx(speed + 5 / 7 * (pull - 0.05 * G) * end, rel=1e-9)
    assert rigid[1] == pytest.approx(rigid[0], rel=1e-7)


def test_a_constant_torque_without_a_motion_in_closed_form():
    load = MASS * G
    down = contact.against_constant_torque(1.0, 0.0, 1.0, MASS, 1e22, (load, 0.0))
    expected = contact.down_an_incline(math.asin(1.0 / G), 1.0, G)
    assert down == pytest.approx((expected.acceleration, expected.turning), rel=1e-8)
    for limits, time in (((0.01 * load, 0.05 * load), 0.01), ((load, 0.05 * load), 2.0)):
        assert contact.against_constant_torque(time, 0.5, 0.0, MASS, STIFFNESS, limits) is None


def test_a_sphere_on_an_incline_ends_where_the_springs_hold_it_or_rolls_at_a_constant_rate():
    springs = ((1e4, 30.0), (2e4, 30.0))
    (rests,) = contact.on_an_incline((1.0,), 0.2, 0.01, *springs, (1.0, 4.1e-3))
    assert rests == pytest.approx([0.002 / 1e4 + 0.002 / 2e4, 0.0, 0.002 / 2e4, 0.0], abs=1e-15)
    one, two = contact.on_an_incline((1.0, 2.0), 0.2, 0.01, *springs, (1.0, 1e-3))
    rate = 5.0 / 7.0 * (0.2 - 1e-3 / 0.01)
    assert (two - one)[[1, 3]] == pytest.approx([rate, rate], rel=1e-9)
    # it slides; it is held again after it rolled
    assert contact.on_an_incline((1.0,), 0.2, 0.01, *springs, (1e-3, 1e-3)) is None
    assert contact.on_an_incline((1.0,), 0.2, 0.01, *springs, (1.0, 2.1e-3)) is None


def test_a_sphere_that_turns_on_its_spot_is_slowed_down_by_the_limit_of_the_torque():
    inertia, limit = 0.4 * MASS * RADIUS**2, 1e-3 * MASS * G
    halfway, end = (
        contact.twisting_spin(time, 50.0, inertia, (100.0, 0.0), limit) for time in (0.005, 0.01)
    )
    expected = contact.twisting_deceleration(1e-3, RADIUS, G)
    assert (halfway - end) / 0.005 == pytest.approx(expected, rel=1e-9)


def test_a_circle_between_two_half_spaces_conducts_2_k_a():
    """Heat through a circle of one temperature: of the potential integral J0(sr) sin(sa)/s e^-sz.

    2/pi of it is 1 on the circle. Its flow is 2 pi a k 2/pi integral J1(sa) sin(sa)/s ds = 4 k a
    into a half-space: 2 k a for the difference that both share.
    """
    # Weber's integral for a = 1, damped: the limit of e^-sz as z falls
    found = []
    for z in (0.04, 0.02, 0.01):
        flow = quad(
            lambda s, z=z: j1(s) * np.sin(s) / s * np.exp(-s * z), 0.0, 60.0 / z, limit=4000
        )
        there = quad(
            lambda s, z=z: j0(0.3 * s) * np.sin(s) / s * np.exp(-s * z), 0, 60 / z, limit=4000
        )
        found.append((4.0 * flow[0], 2.0 / math.pi * there[0]))
    # it falls with the root of z at the rim, linearly within
    flows, levels = np.array(found).T
    assert flows[2] + (flows[2] - flows[1]) / (math.sqrt(2.0) - 1.0) == pytest.approx(4.0, rel=0.02)
    assert 2.0 * levels[2] - levels[1] == pytest.approx(1.0, rel=1e-3)
    assert contact.conductance("radius", 3.0, 2.0) == 0.5 * 4.0 * 3.0 * 2.0
    assert contact.conductance("area", 3.0, 2.0) == pytest.approx(3.0 * math.pi * 4.0)
