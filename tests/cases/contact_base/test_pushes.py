"""What round-off may leave of a run of mdr: the digits of its force, carried on by the law."""

import math
from dataclasses import replace

import numpy as np
import pytest

from harness.cases.contact.impact import impact
from harness.cases.contact.invariance import lost, of_force
from harness.cases.contact.parameters import ContactSystem
from harness.parameters.rules import Rules
from harness.solvers.pair.integration import integrate
from harness.solvers.pair.normal import segment

DOWN = (0.0, 0.0, -1.0)
SIZES = {"position": 1e-4, "velocity": 1.0, "force": 50.0}


@pytest.mark.parametrize("power", range(-9, 1))
def test_the_force_of_mdr_as_codes_write_it_loses_digits_within_the_bound(power):
    rng = np.random.default_rng(power + 20)
    shares = []
    for y in 10.0 ** (power + rng.random(200)):
        y = min(y, 1.0)
        theta = 2.0 * math.asin(math.sqrt(0.5 * y))
        exact = 0.5 * segment(2.0 * theta)
        for told in (
            math.acos(1.0 - y) - (1.0 - y) * math.sqrt(2.0 * y - y * y),
            math.acos(1.0 - y) - (2.0 - 2.0 * y) * math.sqrt(0.5 * y - (0.5 * y) ** 2),
        ):
            shares.append(abs(told - exact) / lost(theta))
    assert max(shares) <= 1.0
    assert max(shares) > 0.02


@pytest.mark.parametrize("y", [1e-17, 1e-16, 2e-16, 1e-15, 1e-14])
def test_where_nothing_is_left_the_bound_is_the_root_of_eps(y):
    theta = 2.0 * math.asin(math.sqrt(0.5 * y))
    told = math.acos(1.0 - y) - (1.0 - y) * math.sqrt(2.0 * y - y * y)
    assert abs(told - 0.5 * segment(2.0 * theta)) <= lost(theta) <= lost(0.0)


LAW = {"normal": "mdr", "youngs_modulus": 1e8, "poisson_ratio": 0.3, "steps_per_contact": 20}


def width(slack=0.0, **more):
    """Return that of a head-on impact, and its scene."""
    system = ContactSystem(**LAW, **more)
    scene = impact(system, DOWN, finely=True)
    stepped = replace(scene, every=1)
    path = integrate(stepped)
    return of_force(scene, Rules(), path.overlaps[:, 0], SIZES, slack)


def test_the_width_is_that_of_pushes_carried_on_by_a_spring():
    """One push at a step: x = h v_0 n, and the spring of the law takes it back."""
    system = ContactSystem(**LAW)
    scene = impact(system, DOWN, finely=True)
    overlap = 1e-4
    for steps in (1, 2, 3):
        overlaps = np.array([overlap, *[-1.0] * steps])
        h, mass = scene.step, scene.bodies[0].mass
        plane_strain, radius = 1e8 / (1.0 - 0.09), system.radius
        theta = math.acos(1.0 - overlap / (2.0 * radius))
        force = 2.0 * plane_strain * radius**2 * 0.5 * segment(2.0 * theta)
        off = 2.0 * plane_strain * radius**2 * lost(theta) + 8.0 * np.finfo(float).eps * force
        sizes = {"position": 1e-9, "velocity": 1e9, "force": 1e9}
        found = of_force(scene, Rules(), overlaps, sizes, 0.0)
        assert found == pytest.approx(2.0 * steps * h * h / mass * off / 1e-9, rel=1e-9)


def test_a_sphere_that_is_pressed_in_as_it_yields_loses_few_digits():
    elastic, yields = width(), width(yield_stress=1e6)
    assert 1e-14 < yields < 1e-9
    assert 1e-14 < elastic < 1e-9
    assert width(slack=1e-7) > elastic


def test_friction_adds_its_part():
    rubbed = width(tangential="linear_history", tangential_stiffness=1e4, friction=0.4)
    assert rubbed == pytest.approx(2.4 * width(), rel=1e-12)
