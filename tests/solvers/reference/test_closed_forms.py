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
    DAMPED, G, HERTZ, HOOKE, JKR, LINEAR, MASS, R, RHO, STILL, TORQUE, VISCOUS, final, guided,
    impact, resting,
)  # fmt: skip

UNDAMPED = HOOKE.replace(tangential="linear_history", tangential_stiffness=2e5 / 7, friction=0.3)


def relaxing(clipped):
    """Return the restitution of a viscoelastic impact at 1 m/s."""
    k = contact.stiffness(HERTZ.moduli[0], R)
    relaxation = closed_forms.relaxation(4e5, MASS, R, k)
    damping = relaxation / contact.largest_hertz_overlap(MASS, k, 1.0)
    return closed_forms.impact(damping, clipped=clipped).restitution


@pytest.mark.parametrize(
    ("dashpot", "expected", "bound"),
    [
        *(({"damping": "tsuji", "restitution": e}, e, 0.01) for e in (0.3, 0.5, 0.8)),  # a fit
        *(({**VISCOUS, "clipped": clips}, relaxing(clips), 1e-6) for clips in (False, True)),
    ],
)
def test_restitution_of_dashpots(dashpot, expected, bound):
    def measure(steps):
        return {
            "e": final(impact(HERTZ.replace(**dashpot), (0.0, 0.0, -1.0), steps, lasts=4.0))[0][2]
        }

    found = reference.limit(measure, 0.1 * bound, most=25_600)["e"]
    assert found.error <= bound
    assert found.value == pytest.approx(expected, abs=bound)


@pytest.mark.parametrize("partner", ["wall", "sphere"])
def test_jkr_without_load_and_at_its_largest_tension(partner):
    radius = R if partner == "wall" else 0.5 * R
    rest, end = (
        contact.jkr_overlap(place, 0.5, JKR.moduli[0], radius)
        for place in ("without load", "largest tension")
    )
    scene = guided(JKR, (1, STILL, STILL), overlap=rest, partner=partner)
    balance = reference.run(scene).force[-1, 0, 2]
    assert abs(balance) < 1e-9 * contact.jkr_pull_off(0.5, radius)
    size = contact.jkr_contact_radius("largest tension", 0.5, JKR.moduli[0], radius)
    found = contacts.jkr_radius(JKR.moduli[0], 0.5, radius, end)
    assert found == pytest.approx(size, rel=1e-9)


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


def test_linear_slider_under_a_constant_limit():
    law = HOOKE.replace(**DAMPED, tangential="linear_history", tangential_stiffness=2e4,
                        tangential_damping=0.2, friction=0.3)  # fmt: skip
    speeds = (0.02, 0.05, -0.03, 0.01)
    scene = guided(law, *((200, (v, 0.0, 0.0), STILL) for v in speeds), step=1e-7)
    expected = contact.limited_forces(2e4, 0.4, 0.3, [(v * 2e-5, 2e-5) for v in speeds])
    found = reference.run(scene.replace(every=200)).force[1:, 0, 0]
    assert found == pytest.approx(expected, rel=1e-9)


# ---- rolling, twisting


@pytest.mark.parametrize("friction", [0.1, 0.5])
def test_slip_to_roll(friction):
    law = LINEAR.replace(friction=friction, tangential_damping=20.0)
    until = 2.0 * 0.1 / (7.0 * friction * G)

    def measure(steps):
        half = final(resting(law, 0.5 * until, steps // 2, velocity=(0.1, 0.0, 0.0)))[0]
        end, rim = final(resting(law, 6.0 * until, 6 * steps, velocity=(0.1, 0.0, 0.0)))
        return {"half": half[0], "end": end[0], "rim": rim[1]}

    found = reference.limit(measure, 1e-7, first=6400)
    assert found["half"].value == pytest.approx(0.1 - 0.5 * friction * G * until, abs=1e-5)
    assert found["end"].value == pytest.approx(5 / 7 * 0.1, abs=1e-6)
    assert found["end"].value + 0.4 * found["rim"].value == pytest.approx(0.1, abs=1e-9)


def test_rolling_resistance():
    law = LINEAR.replace(rolling="sds", rolling_stiffness=1e6, rolling_damping=0.0,
                         rolling_friction=0.05)  # fmt: skip
    velocity, _ = final(resting(law, 0.1, 40_000, velocity=(0.1, 0.0, 0.0), spin=(0.0, 10.0, 0.0)))
    assert 0.1 - velocity[0] == pytest.approx(5 / 7 * 0.05 * G * 0.1, rel=2e-3)


def test_constant_torque_of_rolling():
    law, time = UNDAMPED.replace(**TORQUE), 0.01
    moved = contact.against_constant_torque(time, 0.1, 0.0, MASS, 2e5 / 7, (
        0.3 * MASS * G, 0.05 * MASS * G))  # fmt: skip
    start = {"velocity": (0.1, 0.0, 0.0), "spin": (0.0, 10.0, 0.0)}

    def measure(steps):
        velocity, rim = final(resting(law, time, steps, **start))
        return {"speed": velocity[0], "rim": rim[1]}

    limits = reference.limit(measure, 1e-9, first=1000)
    assert (limits["speed"].value, limits["rim"].value) == pytest.approx(moved, abs=2e-9)


@pytest.mark.parametrize("angle", [1.0, 2.5])
def test_sphere_that_a_constant_torque_holds_creeps_down_by_the_step(angle):
    """The sign of the torque changes from step to step: by 5/2 g sin(angle) h, to 0 with h."""
    law, tilt = UNDAMPED.replace(**TORQUE), math.radians(angle)
    assert math.tan(tilt) < 0.05
    pull, creep = (G * math.sin(tilt), 0.0, -G * math.cos(tilt)), []
    for steps in (20_000, 40_000):
        motion = reference.run(resting(law, 0.4, steps, gravity=pull, every=steps // 2))
        way = float(motion.position[2, 0, 0] - motion.position[1, 0, 0])
        creep.append(way / 0.2 / (0.4 / steps * pull[0]))
    assert creep == pytest.approx([2.5, 2.5], rel=0.1)


# ---- surroundings


@pytest.mark.parametrize("along", [True, False])
def test_wall_that_oscillates(along):
    drive, reach, seconds = 600.0, 2e-6, 0.01
    swing = (reach, 0.0, 0.0) if along else (0.0, 0.0, reach)
    wall = Wall(amplitude=swing, frequency=drive)
    scene = resting(LINEAR, seconds, 40_000).replace(walls=(wall,))
    factor, k, eta = (3.5, 2e5 / 7, 1.0) if along else (1.0, 1e5, 2.0)
    decay, omega = 0.5 * factor * eta / MASS, math.sqrt(factor * k / MASS)
    _, rate = contact.driven(np.array([seconds]), omega, decay, reach * drive**2, drive)
    # along the plane the slip moves, of which the sphere has 2/7
    expected = (rate[0] + reach * drive * math.sin(drive * seconds)) / factor
    assert final(scene)[0][0 if along else 2] == pytest.approx(expected, abs=1e-3 * reach * drive)


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
