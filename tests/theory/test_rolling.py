"""Sliding, rolling and turning under weight: the closed forms against Newton's equations."""

import math

import numpy as np
import pytest

from harness.parameters.scene import Body, ContactScene
from harness.solvers.pair.integration import integrate
from harness.theory import contact
from tests.solvers.pair.scenes import FLOOR, LINEAR, MASS, RADIUS, STILL
from tests.theory import closed_forms

G = 9.81
STIFF = LINEAR.replace(friction=0.3)


def on_the_floor(law, velocity=STILL, omega=STILL, *, time, angle=0.0):
    """Return the motion of a sphere that rests on the floor in the balance of its weight."""
    gravity = (G * math.sin(angle), 0.0, -G * math.cos(angle))
    height = RADIUS + MASS * gravity[2] / law.normal_stiffness
    ball = Body(RADIUS, MASS, (0.0, 0.0, height), velocity, omega)
    scene = ContactScene(
        (ball,), (FLOOR,), law, step=time / 100, steps=100, every=50, gravity=gravity
    )
    return integrate(scene)


def test_a_sphere_that_slides_begins_to_roll():
    expected = closed_forms.slip_to_roll(0.1, 0.3, G)
    path = on_the_floor(STIFF, (0.1, 0.0, 0.0), time=2.0 * expected.time)
    # the spring takes over when the force that it gains, k_t u, is what the dashpot loses, eta u'
    eta = 2.0 * contact.damping_ratio(0.5) * math.sqrt(STIFF.normal_stiffness * MASS)
    early = eta / STIFF.tangential_stiffness
    assert path.of_kind("sticks")[0].time == pytest.approx(expected.time - early, rel=1e-9)
    assert path.velocities[-1, 0, 0] == pytest.approx(expected.speed, rel=1e-6)


@pytest.mark.parametrize(("angle", "rolls"), [(0.5, True), (1.0, False)])
def test_down_an_incline(angle, rolls):
    expected = contact.down_an_incline(angle, 0.3, G)
    assert expected.rolls == rolls
    path = on_the_floor(STIFF, time=1e-2, angle=angle)
    (_, halfway, end) = path.velocities[:, 0, 0]
    turned = np.diff(path.omegas[1:, 0, 1])[0] * RADIUS
    assert end - halfway == pytest.approx(expected.acceleration * 5e-3, rel=1e-6)
    assert turned == pytest.approx(expected.turning * 5e-3, rel=1e-6)


def test_at_the_limit_rolling_and_sliding_are_one():
    limit = math.atan(3.5 * 0.3)
    rolls, slides = (contact.down_an_incline(limit + d, 0.3, G) for d in (-1e-9, 1e-9))
    assert (rolls.rolls, slides.rolls) == (True, False)
    assert slides[1:] == pytest.approx(rolls[1:], rel=1e-7)


def test_rolling_resistance_slows_a_rolling_sphere():
    law = STIFF.replace(
        rolling="sds", rolling_stiffness=1e6, rolling_damping=0.0, rolling_friction=0.05
    )
    path = on_the_floor(law, (0.5, 0.0, 0.0), (0.0, 0.5 / RADIUS, 0.0), time=0.02)
    slowed = -np.diff(path.omegas[1:, 0, 1])[0] / 0.01
    expected = closed_forms.rolling_deceleration(0.05, RADIUS, G)
    # Newton: m r alpha = -f_x, I alpha = r f_x - mu_r r m g
    balance = 0.05 * MASS * G * RADIUS / (0.4 * MASS * RADIUS**2 + MASS * RADIUS**2)
    assert expected == pytest.approx(balance, rel=1e-14)
    assert slowed == pytest.approx(expected, rel=1e-6)


ROLLS = STIFF.replace(
    rolling="sds", rolling_stiffness=1e5, rolling_damping=10.0, rolling_friction=0.05
)


@pytest.mark.parametrize("angle", [0.0175, 0.07])
def test_rolling_resistance_holds_a_sphere_on_an_incline_or_slows_it_down(angle):
    end = 2e-2
    path = on_the_floor(ROLLS, time=end, angle=angle)
    load, damping = MASS * G * math.cos(angle), contact.damping_ratio(0.5)
    eta = 2.0 * damping * math.sqrt(STIFF.normal_stiffness * MASS) * STIFF.tangential_damping
    told = ((STIFF.tangential_stiffness, eta), (1e5, 10.0), (0.3 * load, 0.05 * load))
    states = contact.on_an_incline((0.5 * end, end), G * math.sin(angle), MASS, *told)
    for i, (x, u, _, rim) in enumerate(states, 1):
        assert path.positions[i, 0, 0] == pytest.approx(x, rel=1e-9)
        assert path.velocities[i, 0, 0] == pytest.approx(u, rel=1e-7, abs=1e-12)
        assert RADIUS * path.omegas[i, 0, 1] == pytest.approx(rim, rel=1e-7, abs=1e-12)


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
    law = STIFF.replace(
        twisting="sds", twisting_stiffness=100.0, twisting_damping=0.0, twisting_friction=1e-3
    )
    path = on_the_floor(law, omega=(0.0, 0.0, 50.0), time=0.01)
    slowed = -np.diff(path.omegas[1:, 0, 2])[0] / 0.005
    expected = contact.twisting_deceleration(1e-3, RADIUS, G)
    assert expected == pytest.approx(1e-3 * MASS * G / (0.4 * MASS * RADIUS**2), rel=1e-14)
    assert slowed == pytest.approx(expected, rel=1e-9)
