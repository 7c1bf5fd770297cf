"""The law alone, along motion that is prescribed: each submodel's force over its displacement."""

import math

import numpy as np
import pytest

from harness.parameters.rules import Rules
from harness.parameters.scene import Body, ContactScene, Segment
from harness.solvers.pair.integration import integrate
from harness.solvers.pair.system import effective_moduli
from tests.solvers.pair.scenes import ELASTIC, HERTZ, LINEAR, MASS, RADIUS, STILL, guided

PRESSED = 1e-5
SPEED = 0.01
UP, DOWN = (0.0, 0.0, SPEED), (0.0, 0.0, -SPEED)
ACROSS = (SPEED, 0.0, 0.0)
MINDLIN = HERTZ.replace(damping="none", tangential_damping=0.0, friction=100.0)
MODULUS, SHEAR = effective_moduli(HERTZ)


def test_a_normal_load_cycle_with_a_dashpot():
    law = HERTZ.replace(damping="viscoelastic", damping_coefficient=1e6, tangential="none")
    path = integrate(guided(law, (500, DOWN, STILL), (500, UP, STILL), overlap=PRESSED))
    overlap = path.overlaps[:, 0]
    assert overlap[500] == pytest.approx(PRESSED + 500e-6 * SPEED, rel=1e-12)
    a = np.sqrt(RADIUS * overlap)
    closing = np.where(np.arange(1001) <= 500, SPEED, -SPEED)
    force = 4.0 / 3.0 * MODULUS * a * overlap + 1e6 * MASS * a * closing
    assert path.forces[:, 0, 2] == pytest.approx(force, rel=1e-12)


@pytest.mark.parametrize(
    ("law", "loaded", "unloaded"),
    [
        ("mindlin", 1.0, 1.0),
        ("mindlin/force", 0.0, 0.0),
        ("mindlin_rescale", 1.0, 2.0),
        ("mindlin_rescale/force", 0.0, 1.0),
    ],
)
def test_mindlins_spring_held_while_the_overlap_changes(law, loaded, unloaded):
    """The force follows a power of the contact radius: of its growth, and of its shrinking."""
    scene = guided(
        MINDLIN.replace(tangential=law),
        (100, ACROSS, STILL),
        (300, DOWN, STILL),
        (600, UP, STILL),
        overlap=PRESSED,
    )
    path = integrate(scene)
    force = path.forces[[100, 400, 1000], 0, 0]
    a = np.sqrt(RADIUS * path.overlaps[[100, 400, 1000], 0])
    assert force[0] == pytest.approx(-8.0 * SHEAR * a[0] * 100e-6 * SPEED, rel=1e-11)
    assert force[1] / force[0] == pytest.approx((a[1] / a[0]) ** loaded, rel=1e-11)
    assert force[2] / force[1] == pytest.approx((a[2] / a[1]) ** unloaded, rel=1e-11)


def test_shear_reversed_past_the_limit():
    """A hysteresis: up to the limit, along it, back over twice the spring's reach, and along."""
    law = ELASTIC.replace(friction=0.2)
    cap = 0.2 * 1e6 * PRESSED
    reach = round(cap / law.tangential_stiffness / SPEED / 1e-6)
    back = (-SPEED, 0.0, 0.0)
    path = integrate(
        guided(law, (3 * reach, ACROSS, STILL), (5 * reach, back, STILL), overlap=PRESSED)
    )
    moved = np.concatenate([np.arange(3 * reach + 1), 3 * reach - np.arange(1, 5 * reach + 1)])
    spring = law.tangential_stiffness * SPEED * 1e-6 * moved
    force = np.minimum(spring, cap)
    force[3 * reach :] = np.maximum(cap - spring[3 * reach] + spring[3 * reach :], -cap)
    assert path.forces[:, 0, 0] == pytest.approx(-force, abs=1e-11 * cap)
    kinds = [event.kind for event in path.of_kind("slides", "sticks")]
    assert kinds == ["slides", "sticks", "slides"]
    assert path.of_kind("sticks")[0].time == pytest.approx(3e-6 * reach, rel=1e-12)


def test_rolling_and_twisting_reach_their_limits():
    law = LINEAR.replace(
        damping="none",
        rolling="sds",
        rolling_stiffness=1e5,
        rolling_damping=0.5,
        rolling_friction=0.01,
        twisting="sds",
        twisting_stiffness=2.0,
        twisting_damping=1e-4,
        twisting_friction=1e-4,
    )
    spin, load = 2.0, 1e6 * PRESSED
    # rolling without slip: v = omega x r n
    roll = ((0.0, -spin * RADIUS, 0.0), (spin, 0.0, spin))
    path = integrate(guided(law, (20, *roll), (480, *roll), overlap=PRESSED))
    early = 20e-6 * spin
    couple = RADIUS * (1e5 * RADIUS * early + 0.5 * RADIUS * spin)
    assert path.torques[20, 0, 0] == pytest.approx(-couple, rel=1e-9)
    assert path.torques[20, 0, 2] == pytest.approx(-2.0 * early - 1e-4 * spin, rel=1e-9)
    assert path.torques[-1, 0, 0] == pytest.approx(-0.01 * RADIUS * load, rel=1e-9)
    assert path.torques[-1, 0, 2] == pytest.approx(-1e-4 * load, rel=1e-9)
    assert np.abs(path.forces[:, 0, :2]).max() < 1e-12 * load


@pytest.mark.parametrize("lever", ["contact_point", "radius"])
def test_a_pair_that_turns_as_a_rigid_body_keeps_its_force_in_its_own_frame(lever):
    """But for the rule that takes the slip at the full radii: overlap times angle of slip."""
    shear, rate, parts, length = 100, 50.0, 400, 40
    offset, reach = shear * 1e-6 * SPEED, 2.0 * RADIUS - PRESSED
    bodies = (Body(RADIUS, MASS, (0.0, 0.0, reach)), Body(RADIUS, MASS, STILL))
    # chords of a circle about the other sphere, both spheres turning along
    turn = rate * length * 1e-6
    angles = math.atan2(offset, reach) + turn * np.arange(parts + 1)
    circle = np.stack([np.sin(angles), np.zeros(parts + 1), np.cos(angles)], axis=1)
    velocities = np.diff(math.hypot(offset, reach) * circle, axis=0) / (length * 1e-6)
    spin = (0.0, rate, 0.0)
    pieces = [Segment(shear, (ACROSS, STILL), (STILL, STILL))]
    pieces += [Segment(length, (tuple(v), STILL), (spin, spin)) for v in velocities]
    count = shear + parts * length
    scene = ContactScene(bodies, (), ELASTIC, 1e-6, count, shear, segments=tuple(pieces))
    path = integrate(scene, Rules(velocity_lever=lever))
    normal = path.positions[1:, 0] / np.linalg.norm(path.positions[1:, 0], axis=1)[:, None]
    spring = path.springs[1:, 0, 0]
    force = (spring * np.cross((0.0, 1.0, 0.0), normal)).sum(axis=1)
    assert (spring * normal).sum(axis=1) == pytest.approx(0.0, abs=1e-9 * abs(force[0]))
    slip = PRESSED * turn * parts if lever == "radius" else 0.0
    lost = (force[-1] - force[0]) / ELASTIC.tangential_stiffness
    # a chord is shorter than its arc by 1/24 of the square of its angle
    assert lost == pytest.approx(slip, abs=reach * turn**3 / 24.0 * parts + 1e-3 * slip)
