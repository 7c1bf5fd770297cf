"""A hollow frozen sphere is a spherical wall with the others inside."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from harness.errors import RequestError
from harness.parameters.scene import Body, ContactScene
from harness.solvers.pair.integration import integrate
from harness.theory.contact import largest_force, restitution_unclipped, stiffness
from tests.solvers.pair.scenes import HERTZ, LINEAR, MASS, RADIUS, STILL

BOWL = Body(-0.03, 1.0, STILL, frozen=True)
G = 9.81


def in_a_bowl(law, velocity, place=(0.0, 0.0, -0.015), time=0.01, gravity=STILL):
    """Return a sphere in the bowl of three times its radius, sampled at the end and before."""
    ball = Body(RADIUS, MASS, place, velocity)
    return ContactScene(
        (ball, BOWL), (), law, step=time / 100, steps=100, every=50, gravity=gravity
    )


def test_it_is_met_from_within_and_left_with_the_restitution():
    path = integrate(in_a_bowl(LINEAR, (0.0, 0.0, -1.0)))
    begins, ends = path.of_kind("begins", "ends")
    assert begins.time == pytest.approx(0.005, rel=1e-12)
    assert path.velocities[-1, 0, 2] == pytest.approx(0.5, rel=1e-10)
    assert ends.time > begins.time
    assert restitution_unclipped(
        math.log(2.0) / math.hypot(math.pi, math.log(2.0))
    ) == pytest.approx(0.5)


def test_its_curvature_makes_the_contact_stiffer():
    """R* = r R / (R - r): twice the sphere's would be that of a bowl of twice its radius."""
    elastic = HERTZ.replace(damping="none", restitution=None)
    scene = replace(in_a_bowl(elastic, (0.0, 0.0, -1.0), (0.0, 0.0, -0.02)), step=1e-7, every=1)
    path = integrate(replace(scene, steps=2000))
    modulus = 7e9 / 2.0 / (1.0 - 0.3**2)
    most = largest_force(MASS, stiffness(modulus, 0.01 * 0.03 / 0.02), 1.0)
    assert path.forces[:, 0, 2].max() == pytest.approx(most, rel=1e-4)


@pytest.mark.parametrize(("friction", "factor"), [(0.0, 1.0), (1.0, 5.0 / 7.0)])
def test_a_sphere_in_it_swings_as_a_rigid_pendulum(friction, factor):
    """Of length R - r, rolling with 7/5 of the mass: the limit of a stiff contact."""
    stiff, angle, time = 1e6, 0.8, 0.1
    law = LINEAR.replace(tangential_stiffness=stiff, friction=friction)
    length = 0.02 + MASS * G * math.cos(angle) / stiff
    place = (length * math.sin(angle), 0.0, -length * math.cos(angle))
    path = integrate(in_a_bowl(law, STILL, place, time, gravity=(0.0, 0.0, -G)))
    rate = factor * G / 0.02
    swing = solve_ivp(
        lambda _, y: [y[1], -rate * math.sin(y[0])], (0.0, time), [angle, 0.0], rtol=1e-11
    )
    x, _, z = path.positions[-1, 0]
    assert math.atan2(x, -z) == pytest.approx(swing.y[0, -1], abs=2e-5)
    # it rolls without slip, forwards as it comes down
    spin = friction * length * swing.y[1, -1] / RADIUS
    assert path.omegas[-1, 0, 1] == pytest.approx(spin, rel=1e-4, abs=1e-12)


def test_only_a_frozen_one_is_hollow():
    with pytest.raises(RequestError, match=r"radius = -0\.03: must be a finite number greater"):
        Body(-0.03, 1.0, STILL)
    assert np.sign(BOWL.radius) == -1.0
