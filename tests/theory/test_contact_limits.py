"""Closed forms of contacts against their equations of motion, and where there is no form.

SciPy integrates them, with the limits of friction and of torques as events. The cases compare the
same forms with the limit of small steps of the reference, by law and system, less narrowly.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp
from scipy.special import j0, j1

from harness.model.scene import sphere
from harness.theory import contact

RADIUS, STIFFNESS, G = 0.01, 3e5, 9.81
MASS = sphere(RADIUS, 2500.0).mass
EXACT = {"rtol": 1e-12, "atol": 1e-18, "method": "DOP853"}
SLIDER = STIFFNESS, 2.0, 0.3  # of friction: spring, dashpot, coefficient
NONE = 0.0, 0.0, math.inf  # of spring, dashpot and limit


class Sphere:
    """A sphere on a floor under a constant load: x, speed, rim speed, the springs of two sliders.

    A slider is a spring k and a dashpot eta under a constant limit: it sticks while |k q + eta s|,
    s its velocity, is below the limit; beyond it the spring is cut back so that both hold the
    limit, until the spring would grow more slowly than the limit lets it.

    ``springs`` are (k, eta, limit) of friction and of rolling; ``pull`` [m/s2] is along the floor.
    """

    def __init__(self, *springs, pull=0.0):
        self.springs, self.pull, self.signs = springs, pull, [0, 0]  # of those that slide

    def force(self, k, y):
        stiffness, eta, limit = self.springs[k]
        stuck = stiffness * y[3 + k] + eta * self.velocities(y)[k]
        return self.signs[k] * limit if self.signs[k] else stuck

    def velocities(self, y):
        return y[1] - y[2], y[2]

    def rates(self, _, y):
        friction, rolling = self.force(0, y), self.force(1, y)
        dv, drim = self.pull - friction / MASS, (friction - rolling) / (0.4 * MASS)
        growth = [
            -eta * rate / stiffness if sign else velocity
            for (stiffness, eta, _), sign, rate, velocity in zip(
                self.springs, self.signs, (dv - drim, drim), self.velocities(y), strict=True
            )
        ]
        return [y[1], dv, drim, *growth]

    def change(self, k):
        def event(t, y):
            if sign := self.signs[k]:
                return sign * (self.rates(t, y)[3 + k] - self.velocities(y)[k])
            return abs(self.force(k, y)) - self.springs[k][2]

        event.terminal, event.direction = True, 1.0
        return event

    def run(self, times, spin=0.0):
        """Return the states at times, from rest or from a rim speed."""
        y, t, states = np.array([0.0, 0.0, spin, 0.0, 0.0]), 0.0, []
        stiffness, eta, limit = self.springs[1]
        if eta * spin > limit:
            self.signs[1], y[4] = 1, (limit - eta * spin) / stiffness
        for end in times:
            while t < end:
                found = solve_ivp(
                    self.rates, (t, end), y, events=[self.change(0), self.change(1)], **EXACT
                )
                t, y = found.t[-1], found.y[:, -1]
                for k, at in enumerate(found.t_events):
                    if at.size:
                        self.signs[k] = 0 if self.signs[k] else int(np.sign(self.force(k, y)))
            states.append(y)
        return np.array(states)


def friction_under(load):
    return (*SLIDER[:2], SLIDER[2] * load)


@pytest.mark.parametrize(("angle", "rolls"), [(0.5, True), (1.0, False)])
def test_down_an_incline(angle, rolls):
    expected = contact.down_an_incline(angle, SLIDER[2], G)
    assert expected.rolls == rolls
    friction = friction_under(MASS * G * math.cos(angle))
    found = Sphere(friction, NONE, pull=G * math.sin(angle)).run((0.1, 0.2))
    gained = (found[1] - found[0])[1:3] / 0.1
    assert gained == pytest.approx((expected.acceleration, expected.turning), rel=1e-9)


@pytest.mark.parametrize("angle", [0.0175, 0.07])
def test_rolling_resistance_holds_a_sphere_on_an_incline_or_slows_it_down(angle):
    times, load, pull = (1e-2, 2e-2), MASS * G * math.cos(angle), G * math.sin(angle)
    friction, rolling = friction_under(load), (1e5, 10.0, 0.05 * load)
    limits = (friction[2], rolling[2])
    states = contact.on_an_incline(times, pull, MASS, friction[:2], rolling[:2], limits)
    for (x, u, _, rim), found in zip(
        states, Sphere(friction, rolling, pull=pull).run(times), strict=True
    ):
        assert (x, u, rim) == pytest.approx(tuple(found[:3]), rel=1e-8, abs=1e-16)


@pytest.mark.parametrize("dashpot", [0.0, 0.1, 0.6])  # over critical damping
@pytest.mark.parametrize("start", [0.5, 3.0, 30.0])  # over the amplitude at the limit
def test_a_twist_slips_stops_and_swings_back(start, dashpot):
    """Turning about the normal is rolling of a rim of one metre, with the inertia of the sphere."""
    k, limit, inertia = 1.0, 1e-5, 0.4 * MASS
    c, largest = 2.0 * dashpot * math.sqrt(k * inertia), limit / math.sqrt(k * inertia)
    times = np.arange(1.0, 41.0) * math.sqrt(inertia / k)
    found = Sphere(NONE, (k, c, limit)).run(times, start * largest)[:, 2]
    expected = [contact.twisting_spin(t, start * largest, inertia, (k, c), limit) for t in times]
    assert found == pytest.approx(expected, abs=1e-9 * largest)


@given(st.floats(1.01, 20.0), st.floats(3e4, 4e4))
def test_a_twist_swings_on_as_it_began(start, late):
    """It is damped little: two values of the swing determine all later ones."""
    rate, damping = math.sqrt(1.0 - 1e-10), 1e-5

    def spin(at):
        return contact.twisting_spin(at, start, 1.0, (1.0, 2.0 * damping), 1.0)

    def swings(at):
        return math.exp(-damping * at) * np.array([math.cos(rate * at), math.sin(rate * at)])

    early = [25.0, 26.5]
    parts = np.linalg.solve([swings(at) for at in early], [spin(at) for at in early])
    assert spin(late) == pytest.approx(parts @ swings(late), abs=1e-8)


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


@pytest.mark.parametrize("times", [0.01, 1.0, 12.0])
def test_a_sphere_that_is_dragged_falls_as_its_equation_says(times):
    path = solve_ivp(lambda _, y: [1.0 - y[0], y[0]], (0.0, times), [0.0, 0.0], **EXACT)
    assert contact.dragged(times) == pytest.approx(tuple(path.y[:, -1]), rel=1e-9)


@pytest.mark.parametrize("decay", [0.0, 0.3, 5.0])
def test_a_contact_on_an_oscillating_wall_is_a_driven_oscillator(decay):
    frequency, acceleration, drive, end = 2.0, 0.7, 0.9, 13.0

    def rates(t, y):
        pull = -2.0 * decay * y[1] - frequency**2 * y[0]
        return [y[1], pull - acceleration * math.cos(drive * t)]

    path = solve_ivp(rates, (0.0, end), [0.0, 0.0], **EXACT)
    y, speed = contact.driven(np.array([0.0, end]), frequency, decay, acceleration, drive)
    assert (y[0], speed[0]) == pytest.approx((0.0, 0.0), abs=1e-15)
    assert (y[1], speed[1]) == pytest.approx(tuple(path.y[:, -1]), abs=1e-9)


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
