"""Drag, conduction of heat and oscillating walls: closed forms against their equations in steps."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.special import j0, j1

from harness.theory import contact

EXACT = {"rtol": 1e-11, "atol": 1e-14, "method": "DOP853"}


@pytest.mark.parametrize("times", [0.01, 1.0, 12.0])
def test_a_sphere_that_is_dragged_falls_as_its_equation_says(times):
    path = solve_ivp(lambda _, y: [1.0 - y[0], y[0]], (0.0, times), [0.0, 0.0], **EXACT)
    assert contact.dragged(times) == pytest.approx(tuple(path.y[:, -1]), rel=1e-9)


def test_the_temperatures_of_two_bodies_approach_one_another():
    first, second, rate = 3.0, 0.5, 0.2

    def flows(_, temperature):
        heat = rate * (temperature[0] - temperature[1])
        return [-heat / first, heat / second]

    path = solve_ivp(flows, (0.0, 4.0), [400.0, 300.0], **EXACT)
    left = math.exp(-4.0 * contact.cooling_rate(rate, (first, second)))
    assert path.y[0, -1] - path.y[1, -1] == pytest.approx(100.0 * left, rel=1e-9)
    # of what is kept at its temperature the capacity is beyond bounds
    wall = contact.cooling_rate(rate, (first,))
    assert contact.cooling_rate(rate, (first, 1e20)) == pytest.approx(wall, rel=1e-14)


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


@pytest.mark.parametrize("decay", [0.0, 0.3, 5.0])
def test_a_contact_on_an_oscillating_wall_is_a_driven_oscillator(decay):
    frequency, acceleration, drive, end = 2.0, 0.7, 0.9, 13.0

    def rates(t, y):
        pull = -2.0 * decay * y[1] - frequency**2 * y[0]
        return [y[1], pull - acceleration * math.cos(drive * t)]

    path = solve_ivp(rates, (0.0, end), [0.0, 0.0], **EXACT)
    y, speed = contact.driven(np.array([0.0, end]), frequency, decay, acceleration, drive)
    assert (y[0], speed[0]) == pytest.approx((0.0, 0.0), abs=1e-15)
    assert (y[1], speed[1]) == pytest.approx(tuple(path.y[:, -1]), abs=1e-8)
