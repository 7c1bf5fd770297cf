"""Sliding, rolling and turning under weight: the closed forms against Newton's equations.

These are integrated by scipy, with the limits of friction and of the torque as events.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from harness.model.law import damping_ratio
from harness.model.scene import sphere
from harness.theory import contact

RADIUS, DENSITY, G = 0.01, 2500.0, 9.81
MASS = sphere(RADIUS, DENSITY).mass
STILL = (0.0, 0.0)
STIFFNESS, FRICTION = 1e6, 0.3
ALONG = 2.0 / 7.0 * STIFFNESS
ETA = 2.0 * damping_ratio(0.5) * math.sqrt(STIFFNESS * MASS)


def friction_under(load):
    """Return the tangential spring, its dashpot, and Coulomb's limit."""
    return ALONG, 0.5 * ETA, FRICTION * load


class Sphere:
    """A sphere on a floor under a constant load: speed, rim speed and the springs of two sliders.

    A slider is a spring k and a dashpot eta under a constant limit: it sticks while |k q + eta s|,
    s its velocity, is below the limit; beyond it the spring is cut back so that both hold the
    limit, until the spring would grow more slowly than the limit lets it.

    ``springs`` are (k, eta, limit) of friction and of rolling; ``pull`` [m/s2] is along the floor.
    """

    def __init__(self, *springs, pull=0.0):
        self.springs, self.pull = [*springs, (0.0, 0.0, 0.0)][:2], pull
        self.signs = [0, 0]  # of sliders that slide, 0 of those that stick

    def velocities(self, y):
        _, v, rim, *_ = y
        return v - rim, rim

    def force(self, k, y):
        stiffness, eta, limit = self.springs[k]
        if self.signs[k]:
            return self.signs[k] * limit
        return stiffness * y[3 + k] + eta * self.velocities(y)[k]

    def rates(self, _, y):
        friction, rolling = self.force(0, y), self.force(1, y)
        dv, drim = self.pull - friction / MASS, (friction - rolling) / (0.4 * MASS)
        return [y[1], dv, drim, *(self._growth(k, y, (dv - drim, drim)[k]) for k in (0, 1))]

    def _growth(self, k, y, rate):
        stiffness, eta, _ = self.springs[k]
        return -eta * rate / stiffness if self.signs[k] else self.velocities(y)[k]

    def change(self, k):
        def event(t, y):
            if self.springs[k][2] == 0.0:
                return -1.0
            if self.signs[k]:
                return self.signs[k] * (self.rates(t, y)[3 + k] - self.velocities(y)[k])
            return abs(self.force(k, y)) - self.springs[k][2]

        event.terminal, event.direction = True, 1.0
        return event

    def run(self, times, start=STILL):
        """Return x, v, rim speed and springs at times, (M, 5), from a speed and a rim speed."""
        y, t, states = np.array([0.0, *start, 0.0, 0.0]), 0.0, []
        for k in (0, 1):
            if self.springs[k][2] and abs(self.force(k, y)) > self.springs[k][2]:
                self.signs[k] = int(np.sign(self.force(k, y)))
        for end in times:
            while t < end:
                found = solve_ivp(
                    self.rates, (t, end), y, "DOP853", rtol=1e-12, atol=1e-18,
                    events=[self.change(0), self.change(1)],
                )  # fmt: skip
                t, y = found.t[-1], found.y[:, -1]
                for k, at in enumerate(found.t_events):
                    if at.size:
                        self.signs[k] = 0 if self.signs[k] else int(np.sign(self.force(k, y)))
            states.append(y)
        return np.array(states)


@pytest.mark.parametrize(("angle", "rolls"), [(0.5, True), (1.0, False)])
def test_down_an_incline(angle, rolls):
    expected = contact.down_an_incline(angle, FRICTION, G)
    assert expected.rolls == rolls
    sphere = Sphere(friction_under(MASS * G * math.cos(angle)), pull=G * math.sin(angle))
    halfway, end = sphere.run((5e-3, 1e-2))
    assert (end - halfway)[1] == pytest.approx(expected.acceleration * 5e-3, rel=1e-6)
    assert (end - halfway)[2] == pytest.approx(expected.turning * 5e-3, rel=1e-6)


@pytest.mark.parametrize(("speed", "pull"), [(0.5, 0.0), (0.5, -1.0), (0.02, 1.5)])
def test_a_constant_torque_slows_a_sphere_that_rolls(speed, pull):
    load, end = MASS * G, 0.01
    limits = FRICTION * load, 0.05 * load

    def newton(_, y):
        spring, u, rim = y
        force = ALONG * spring
        return u - rim, pull - force / MASS, (force - limits[1]) / (0.4 * MASS)

    ran = solve_ivp(newton, (0.0, end), (0.0, speed, speed), "DOP853", rtol=1e-13, atol=1e-18)
    state = contact.against_constant_torque(end, speed, pull, MASS, ALONG, limits)
    assert state == pytest.approx(ran.y[1:, -1], rel=1e-9)
    # a stiff spring: it rolls, and the torque takes 5/7 mu_r g from 5/7 of the pull
    rigid = contact.against_constant_torque(end, speed, pull, MASS, 1e22, limits)
    assert rigid[0] == pytest.approx(speed + 5 / 7 * (pull - 0.05 * G) * end, rel=1e-9)
    assert rigid[1] == pytest.approx(rigid[0], rel=1e-7)


@pytest.mark.parametrize("angle", [0.0175, 0.07])
def test_rolling_resistance_holds_a_sphere_on_an_incline_or_slows_it_down(angle):
    times, load, pull = (1e-2, 2e-2), MASS * G * math.cos(angle), G * math.sin(angle)
    friction, rolling = friction_under(load), (1e5, 10.0, 0.05 * load)
    found = Sphere(friction, rolling, pull=pull).run(times)
    limits = (friction[2], rolling[2])
    states = contact.on_an_incline(times, pull, MASS, friction[:2], rolling[:2], limits)
    for (x, u, _, rim), state in zip(states, found, strict=True):
        assert state[0] == pytest.approx(x, rel=1e-9)
        assert state[1] == pytest.approx(u, rel=1e-7, abs=1e-12)
        assert state[2] == pytest.approx(rim, rel=1e-7, abs=1e-12)


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


def test_twisting_resistance_slows_a_sphere_that_turns_on_its_spot():
    limit, inertia = 1e-3 * MASS * G, 0.4 * MASS * RADIUS**2
    # turning about the normal is rolling of a rim of one metre, with the inertia of the sphere
    sphere = Sphere(
        (0.0, 0.0, 0.0), (100.0 * 0.4 * MASS / inertia, 0.0, limit * 0.4 * MASS / inertia)
    )
    halfway, end = sphere.run((0.005, 0.01), (0.0, 50.0))
    expected = contact.twisting_deceleration(1e-3, RADIUS, G)
    assert expected == pytest.approx(limit / inertia, rel=1e-14)
    assert (halfway - end)[2] / 0.005 == pytest.approx(expected, rel=1e-9)
