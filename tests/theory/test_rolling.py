"""Sliding, rolling and turning under weight: the closed forms against Newton's equations."""

import math

import pytest
from scipy.integrate import solve_ivp

from harness.model.law import damping_ratio
from harness.theory import contact
from tests.theory.sliding import MASS, RADIUS, G, Sphere

STIFFNESS, FRICTION = 1e6, 0.3
ALONG = 2.0 / 7.0 * STIFFNESS
ETA = 2.0 * damping_ratio(0.5) * math.sqrt(STIFFNESS * MASS)


def friction_under(load, share=0.5):
    """Return the tangential spring, its dashpot, and Coulomb's limit."""
    return ALONG, share * ETA, FRICTION * load


def test_a_sphere_that_slides_begins_to_roll():
    begins = 2.0 * 0.1 / (7.0 * FRICTION * G)  # u0 - mu g t = 5/2 mu g t
    sphere = Sphere(friction_under(MASS * G, 1.0))
    ((_, speed, *_),) = sphere.run([2.0 * begins], (0.1, 0.0))
    # the spring takes over when the force that it gains, k_t u, is what the dashpot loses, eta u'
    sticks = next(time for time, _, sign in sphere.changes if sign == 0)
    assert sticks == pytest.approx(begins - ETA / ALONG, rel=1e-9)
    assert speed == pytest.approx(5.0 / 7.0 * 0.1, rel=1e-6)


@pytest.mark.parametrize(("angle", "rolls"), [(0.5, True), (1.0, False)])
def test_down_an_incline(angle, rolls):
    expected = contact.down_an_incline(angle, FRICTION, G)
    assert expected.rolls == rolls
    sphere = Sphere(friction_under(MASS * G * math.cos(angle)), pull=G * math.sin(angle))
    halfway, end = sphere.run((5e-3, 1e-2))
    assert (end - halfway)[1] == pytest.approx(expected.acceleration * 5e-3, rel=1e-6)
    assert (end - halfway)[2] == pytest.approx(expected.turning * 5e-3, rel=1e-6)


def test_at_the_limit_rolling_and_sliding_are_one():
    limit = math.atan(3.5 * 0.3)
    rolls, slides = (contact.down_an_incline(limit + d, 0.3, G) for d in (-1e-9, 1e-9))
    assert (rolls.rolls, slides.rolls) == (True, False)
    assert slides[1:] == pytest.approx(rolls[1:], rel=1e-7)


def test_rolling_resistance_slows_a_rolling_sphere():
    load = MASS * G
    sphere = Sphere(friction_under(load), (1e6, 0.0, 0.05 * load))
    halfway, end = sphere.run((0.01, 0.02), (0.5, 0.5))
    # Newton: m r alpha = -f_x, I alpha = r f_x - mu_r r m g
    expected = 0.05 * MASS * G * RADIUS / (0.4 * MASS * RADIUS**2 + MASS * RADIUS**2)
    assert -(end - halfway)[2] / RADIUS / 0.01 == pytest.approx(expected, rel=1e-6)


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


def test_a_constant_torque_without_a_motion_in_closed_form():
    load = MASS * G
    down = contact.against_constant_torque(1.0, 0.0, 1.0, MASS, 1e22, (load, 0.0))
    expected = contact.down_an_incline(math.asin(1.0 / G), 1.0, G)
    assert down == pytest.approx((expected.acceleration, expected.turning), rel=1e-8)
    for limits, time in (((0.01 * load, 0.05 * load), 0.01), ((load, 0.05 * load), 2.0)):
        assert contact.against_constant_torque(time, 0.5, 0.0, MASS, ALONG, limits) is None


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
