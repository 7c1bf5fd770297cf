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


def test_twisting_resistance_slows_a_sphere_that_turns_on_its_spot():
    law = STIFF.replace(
        twisting="sds", twisting_stiffness=100.0, twisting_damping=0.0, twisting_friction=1e-3
    )
    path = on_the_floor(law, omega=(0.0, 0.0, 50.0), time=0.01)
    slowed = -np.diff(path.omegas[1:, 0, 2])[0] / 0.005
    expected = contact.twisting_deceleration(1e-3, RADIUS, G)
    assert expected == pytest.approx(1e-3 * MASS * G / (0.4 * MASS * RADIUS**2), rel=1e-14)
    assert slowed == pytest.approx(expected, rel=1e-9)
