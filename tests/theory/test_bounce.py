"""Bouncing and stacked spheres in closed form, against the integration of the law."""

import math

import numpy as np
import pytest

from harness.parameters.law import ContactLaw
from harness.parameters.scene import Body, ContactScene, Plane
from harness.solvers.pair.integration import integrate
from harness.theory import contact
from tests.solvers.pair.scenes import FLOOR, MASS, RADIUS
from tests.theory import closed_forms

G = 9.81
LAW = ContactLaw(normal_stiffness=1e5, damping="coeff_restitution", restitution=0.8)
OMEGA = math.sqrt(1e5 / MASS)
ZETA = contact.damping_ratio(0.8)


def test_every_bounce_of_a_falling_sphere():
    height = 0.05
    apexes = closed_forms.apexes(OMEGA, ZETA, G, height, 4)
    ball = Body(RADIUS, MASS, (0.0, 0.0, RADIUS + height))
    steps = 1000
    scene = ContactScene(
        (ball,), (FLOOR,), LAW, apexes[-1][0] / steps, steps, every=steps, gravity=(0.0, 0.0, -G)
    )
    path = integrate(scene)
    assert len(path.of_kind("ends")) == 4
    assert path.positions[-1, 0, 2] - RADIUS == pytest.approx(apexes[-1][1], rel=1e-10)
    assert abs(path.velocities[-1, 0, 2]) < 1e-9
    first = contact.rebound(OMEGA, ZETA, G, math.sqrt(2.0 * G * height))
    assert path.contact_times()[0] == pytest.approx(first.duration, rel=1e-10)
    assert path.of_kind("turns")[0].overlap == pytest.approx(first.overlap, rel=1e-12)


def test_without_gravity_it_is_the_dashpot_alone():
    one = contact.rebound(OMEGA, ZETA, 0.0, 2.0)
    assert one.speed / 2.0 == pytest.approx(0.8, rel=1e-12)
    assert one.duration == pytest.approx(math.pi / OMEGA / math.sqrt(1.0 - ZETA**2), rel=1e-12)


def test_a_hard_sphere_rises_to_the_square_of_the_restitution():
    hard = closed_forms.apexes(1e6, ZETA, G, 0.05, 3)
    assert [height for _, height in hard] == pytest.approx(
        [0.05 * 0.64**n for n in range(4)], rel=1e-4
    )


def test_a_slow_sphere_stays():
    assert contact.rebound(OMEGA, ZETA, G, 1e-5) is None
    assert len(closed_forms.apexes(OMEGA, 0.5, G, 1e-8, 5)) == 1


def test_spheres_pressed_between_plates():
    radii, masses, heights, top = (0.01, 0.012), (0.01, 0.03), (0.0099, 0.0315), 0.043
    zeta = contact.damping_ratio(0.9)
    pair_mass = masses[0] * masses[1] / sum(masses)
    dashpots = [2.0 * zeta * math.sqrt(1e4 * m) for m in (masses[0], pair_mass, masses[1])]
    bodies = tuple(
        Body(r, m, (0.0, 0.0, z)) for r, m, z in zip(radii, masses, heights, strict=True)
    )
    planes = (FLOOR, Plane((0.0, 0.0, top), (0.0, 0.0, -1.0)))
    law = LAW.replace(normal_stiffness=1e4, restitution=0.9)
    scene = ContactScene(bodies, planes, law, 1e-5, 2000, every=100, gravity=(0.0, 0.0, -G))
    path = integrate(scene)
    assert not path.of_kind("ends")
    places, velocities = closed_forms.stacked_motion(
        path.times, heights, masses, radii, (0.0, top), (1e4, dashpots, G)
    )
    assert path.positions[:, :, 2] == pytest.approx(places, abs=1e-12)
    assert path.velocities[:, :, 2] == pytest.approx(velocities, abs=1e-11)
    # at rest, springs bear the weights; the exponential has a round-off of omega t = 1e3
    rest, still = closed_forms.stacked_motion(
        [1.5], heights, masses, radii, (0.0, top), (1e4, dashpots, G)
    )
    overlaps = radii[0] - rest[0, 0], sum(radii) - np.diff(rest[0])[0], rest[0, 1] + radii[1] - top
    assert 1e4 * np.diff(overlaps[::-1]) == pytest.approx([masses[1] * G, masses[0] * G], rel=1e-8)
    assert np.abs(still).max() < 1e-12
