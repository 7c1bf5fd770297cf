"""The limit of small steps against closed forms that no contact case has.

Those of the cases are held in ``tests/cases/contacts/test_closed_forms.py``, by law and system.
"""
# ruff: noqa: I001

import math

import numpy as np
import pytest

from harness.model.scene import Scene, Wall, sphere
from harness.solvers import contacts, reference
from harness.theory import contact
from tests.theory import closed_forms
from tests.solvers.reference.scenes import (
    G, HERTZ, JKR, LINEAR, MASS, R, RHO, STILL, VISCOUS, final, guided,
    impact,
)  # fmt: skip


def relaxing(clipped):
    """Return the restitution of a viscoelastic impact at 1 m/s."""
    k = contact.stiffness(HERTZ.moduli[0], R)
    relaxation = closed_forms.relaxation(4e5, MASS, R, k)
    damping = relaxation / contact.largest_hertz_overlap(MASS, k, 1.0)
    return closed_forms.hertz_restitution(damping, clipped=clipped)


@pytest.mark.parametrize(
    ("dashpot", "expected", "bound"),
    [
        *(({"damping": "tsuji", "restitution": e}, e, 0.01) for e in (0.3, 0.5, 0.8)),  # a fit
        *(({**VISCOUS, "clipped": clips}, relaxing(clips), 1e-6) for clips in (False, True)),
    ],
)
def test_restitution_of_dashpots(dashpot, expected, bound):
    def measure(steps):
        scene = impact(HERTZ.replace(**dashpot), (0.0, 0.0, -1.0), steps, lasts=4.0)
        return {"e": final(scene)[0][2]}

    found = reference.limit(measure, 0.1 * bound, most=25_600)["e"]
    assert found.error <= bound
    assert found.value == pytest.approx(expected, abs=bound)


@pytest.mark.parametrize("partner", ["wall", "sphere"])
def test_jkr_without_load_and_at_its_largest_tension(partner):
    radius, modulus = R if partner == "wall" else 0.5 * R, JKR.moduli[0]
    rest = contact.jkr_overlap("without load", 0.5, modulus, radius)
    scene = guided(JKR, (1, STILL, STILL), overlap=rest, partner=partner)
    balance = reference.run(scene).force[-1, 0, 2]
    assert abs(balance) < 1e-9 * contact.jkr_pull_off(0.5, radius)
    end = contact.jkr_overlap("largest tension", 0.5, modulus, radius)
    size = contact.jkr_contact_radius("largest tension", 0.5, modulus, radius)
    assert contacts.jkr_radius(modulus, 0.5, radius, end) == pytest.approx(size, rel=1e-9)


# ---- friction


@pytest.mark.parametrize("damping", [0.0, 0.5])
def test_sticks_throughout_as_walton(damping):
    law = LINEAR.replace(friction=1e3, tangential_damping=damping)
    ratio, omega = 1.0 / math.sqrt(1e5 * MASS), math.sqrt(1e5 / MASS)
    lasts = contact.duration_unclipped(ratio) / omega
    expected = closed_forms.held(3.5 * 2e5 / 7 / MASS, 3.5 * damping * 2.0 / MASS, lasts)

    def measure(steps):
        velocity, rim = final(impact(law, (0.1, 0.0, -1.0), steps, time=lasts))
        return {"left": (velocity[0] - rim[1]) / 0.1}

    found = reference.limit(measure, 1e-7)["left"]
    assert found.value == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "power"),
    [("mindlin", 1), ("mindlin/force", 0), ("mindlin_rescale", 2), ("mindlin_rescale/force", 1)],
)
def test_unloading_of_mindlin(name, power):
    """Sheared at a_0 and opened to a_1 the force is 8 G* a_0 s (a_1 / a_0)^p (Thornton 2013)."""
    law = HERTZ.replace(tangential=name, friction=1e6)
    scene = guided(law, (100, (0.01, 0.0, 0.0), STILL), (100, (0.0, 0.0, 0.05), STILL))
    force, ratio = reference.run(scene).force[-1, 0, 0], math.sqrt(0.5)
    first = 8.0 * law.moduli[1] * math.sqrt(R * 1e-5) * 1e-6
    assert -force == pytest.approx(first * ratio**power, rel=1e-9)


# ---- surroundings


@pytest.mark.parametrize("shape", ["sphere", "cylinder"])
def test_bowl(shape):
    """Without friction a sphere swings as a pendulum; in a bowl R* is r W / (W - r)."""
    inside = Wall(shape=shape, radius=0.05, hollow=True, direction=(0.0, 1.0, 0.0))
    law = HERTZ.replace(**VISCOUS)
    curvature = 0.5 if shape == "cylinder" else 1.0
    radius = R * 0.05 / (0.05 - curvature * R)
    overlap = (MASS * G / contact.stiffness(law.moduli[0], radius)) ** (2 / 3)
    length = 0.04 + overlap
    x = 1e-4 * length
    body = sphere(R, RHO, position=(x, 0.0, -math.sqrt(length**2 - x**2)))
    scene = Scene(bodies=(body,), walls=(inside,), law=law, gravity=(0, 0, -G), step=5e-6,
                  steps=40_000)  # fmt: skip
    motion = reference.run(scene.replace(every=100))
    swing = x * np.cos(math.sqrt(G / length) * motion.time)
    assert motion.position[:, 0, 0] == pytest.approx(swing, abs=2e-4 * x)
    assert motion.force[0, 0, 2] == pytest.approx(MASS * G, rel=1e-6)


def test_turning_cylinder_takes_a_sphere_along():
    """Pressed in without weight, it ends where the rims move as one: no slip."""
    wall = Wall(shape="cylinder", radius=0.05, hollow=True, spin=(0.0, 0.0, 2.0))
    body = sphere(R, RHO, position=(0.04 + 1e-6, 0.0, 0.0), axes=(False, False, False))
    scene = Scene(bodies=(body,), walls=(wall,), law=LINEAR, step=1e-6, steps=200_000,
                  every=200_000)  # fmt: skip
    spin = reference.run(scene).angular_velocity[-1, 0, 2]
    assert spin * R == pytest.approx(2.0 * 0.05, rel=1e-6)
