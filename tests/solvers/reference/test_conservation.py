"""Momentum, angular momentum and energy; scenes that are turned, mirrored, reversed in time."""
# ruff: noqa: I001

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from harness.errors import RequestError
from harness.model.scene import Scene, Wall, sphere
from harness.solvers import reference
from tests.solvers.reference.scenes import (
    HERTZ, HOOKE, JKR, LINEAR, MASS, MDR, MINDLIN, R, RHO, ROLLS, STILL, TWISTS, VISCOUS,
    YIELDS, difference, impact,
)  # fmt: skip

ALL = LINEAR.replace(**ROLLS, **TWISTS)
LAWS = {
    "linear": ALL,
    "mindlin": MINDLIN.replace(**ROLLS, twisting="marshall"),
    "rescaled": MINDLIN.replace(tangential="mindlin_rescale/force"),
    "classic": MINDLIN.replace(tangential="mindlin_classic"),
    "jkr": JKR.replace(tangential="mindlin", friction=0.3, **VISCOUS),
    "mdr": YIELDS.replace(tangential="mindlin", friction=0.3),
}
ASLANT, SPIN = (0.5, 0.3, -1.0), (9.0, 5.0, 7.0)


def pair(law, steps=100, **more):
    return impact(law, ASLANT, steps, partner="sphere", other=0.02, spin=SPIN, every=10, **more)


def per_body(scene, name):
    return np.array([getattr(body, name) for body in scene.bodies])[:, None]


@pytest.mark.parametrize("name", LAWS)
def test_momentum_and_angular_momentum(name):
    """Both levers of the contact point reach from centre to centre."""
    scene = pair(LAWS[name])
    motion = reference.run(scene)
    momenta = per_body(scene, "mass") * motion.velocity
    spins = per_body(scene, "moment_of_inertia") * motion.angular_velocity
    about_origin = np.cross(motion.position, momenta) + spins
    # a sphere of mdr that grows has another inertia, and no lever
    for parts in (momenta,) if name == "mdr" else (momenta, about_origin):
        total = parts.sum(axis=1)
        assert total == pytest.approx(total[:1].repeat(len(motion), axis=0), rel=1e-11)


def energy_ratio(scene):
    """Return the kinetic energy at the end over that at the start."""
    motion = reference.run(scene)
    moving = per_body(scene, "mass") * motion.velocity**2
    turning = per_body(scene, "moment_of_inertia") * motion.angular_velocity**2
    first, *_, last = (moving + turning).sum(axis=(1, 2))
    return last / first


@pytest.mark.parametrize("law", [HOOKE, HERTZ, MDR], ids=["hooke", "hertz", "mdr"])
@pytest.mark.parametrize("partner", ["wall", "sphere"])
def test_energy_of_an_elastic_impact(law, partner):
    mass = MASS * (0.5 if partner == "sphere" else 1.0)
    time = math.pi * math.sqrt(mass / 1e5) if law.normal == "hooke" else None

    def measure(steps):
        scene = impact(law, (0.2, 0.0, -1.0), steps, partner=partner, time=time)
        return {"ratio": energy_ratio(scene)}

    assert reference.limit(measure, 1e-7)["ratio"].value == pytest.approx(1.0, abs=1e-6)


@settings(max_examples=30)
@given(
    friction=st.floats(0.0, 2.0), damping=st.floats(0.0, 8.0), along=st.floats(-3.0, 3.0),
    spin=st.floats(-200.0, 200.0), name=st.sampled_from(["linear", "mindlin", "rescaled"]),
)  # fmt: skip
def test_no_impact_gains_energy(friction, damping, along, spin, name):
    law = LAWS[name].replace(friction=friction)
    if law.damping == "velocity":
        law = law.replace(damping_coefficient=damping)
    scene = impact(law, (along, 0.0, -1.0), 400, spin=(0.0, spin, spin), lasts=3.0)
    # steps, and a spring that parts or is rescaled, have an error of the energy
    assert energy_ratio(scene) <= 1.0 + 2e-3


# ---- one scene seen otherwise


def transformed(scene, turn, drift):
    """Return a scene turned by a matrix, or seen from a moving frame."""
    handed = np.linalg.det(turn)

    def polar(vector, plus=STILL):
        return tuple((turn @ np.array(vector) + np.array(plus)).tolist())

    bodies = tuple(
        body.replace(position=polar(body.position), velocity=polar(body.velocity, drift),
                     angular_velocity=polar(handed * np.array(body.angular_velocity)))
        for body in scene.bodies
    )  # fmt: skip
    walls = tuple(
        wall.replace(point=polar(wall.point), direction=polar(wall.direction),
                     velocity=polar(wall.velocity, drift))
        for wall in scene.walls
    )  # fmt: skip
    return scene.replace(bodies=bodies, walls=walls)


def back(motion, turn, drift):
    """Return a motion of a transformed scene as the scene has it."""
    handed, drifted = np.linalg.det(turn), motion.time[:, None, None] * np.array(drift)
    return reference.Motion(
        motion.time, (motion.position - drifted) @ turn, (motion.velocity - np.array(drift)) @ turn,
        handed * motion.angular_velocity @ turn, motion.force @ turn,
        handed * motion.torque @ turn,
    )  # fmt: skip


SEEN = {
    "turned": (Rotation.from_euler("xz", (1.9, 0.7)).as_matrix(), STILL),
    "mirrored": (np.diag([-1.0, 1.0, 1.0]), STILL),
    "moving": (np.eye(3), (0.4, -0.2, 0.3)),
}


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("view", SEEN)
def test_seen_otherwise(name, view):
    for scene in (pair(LAWS[name]), impact(LAWS[name], ASLANT, spin=SPIN, every=10)):
        seen = reference.run(transformed(scene, *SEEN[view]))
        assert difference(reference.run(scene), back(seen, *SEEN[view])) < 2e-9


@pytest.mark.parametrize("law", [HOOKE, HERTZ])
def test_reversed_in_time(law):
    scene = impact(law, (0.2, 0.0, -1.0), partner="sphere", lasts=0.5)
    there = reference.run(scene)
    ends = zip(scene.bodies, there.position[-1], -there.velocity[-1], strict=True)
    bodies = tuple(body.replace(position=tuple(x), velocity=tuple(v)) for body, x, v in ends)
    again = reference.run(scene.replace(bodies=bodies))
    assert again.position[-1] == pytest.approx(there.position[0], abs=1e-14)


@pytest.mark.parametrize("name", ["linear", "mindlin"])
def test_over_a_periodic_boundary(name):
    scene = pair(LAWS[name])
    first, second = scene.bodies
    far = first.replace(position=(first.position[0] - 0.3, *first.position[1:]))
    moved = reference.run(scene.replace(bodies=(far, second), period=(0.3, None, 0.2)))
    moved.position[:, 0, 0] += 0.3
    assert difference(reference.run(scene), moved) < 1e-10


def test_laws_by_types_and_pairs():
    """A row of three spheres: contacts have the laws of their types; a pair left out is none."""
    bodies = tuple(
        sphere(R, RHO, position=(0, 0, (2 * R - 1e-5) * k), type=1 + k % 2) for k in range(3)
    )
    soft, hard = HOOKE, HOOKE.replace(normal_stiffness=3e5)
    scene = Scene(bodies=bodies, law=soft, laws={(2, 1): hard}, walls=(Wall(type=2),), step=1e-6,
                  steps=1)  # fmt: skip
    force = reference.run(scene).force[0, :, 2]
    lower = 3e5 * R  # of the wall, which the first centre is on
    assert force == pytest.approx([lower - 3.0, 0.0, 3.0], rel=1e-9, abs=1e-9)
    apart = reference.run(scene.replace(pairs=((0, 1),))).force[0, :, 2]
    assert apart == pytest.approx([lower - 3.0, 3.0, 0.0], rel=1e-9)
    alone = reference.run(scene.replace(pairs=())).force[0, :, 2]
    assert alone == pytest.approx([lower, 0.0, 0.0], rel=1e-9)


def test_a_wall_acts_on_its_bodies_alone():
    bodies = tuple(sphere(R, RHO, position=(3 * R * k, 0, 0.9 * R)) for k in range(2))
    scene = Scene(bodies=bodies, law=HOOKE, walls=(Wall(bodies=(1,)),), step=1e-6, steps=1)
    force = reference.run(scene).force[0, :, 2]
    assert force == pytest.approx([0.0, 1e5 * 0.1 * R], rel=1e-9)
    with pytest.raises(RequestError, match="must be indices from 0 to 1"):
        scene.replace(walls=(Wall(bodies=(2,)),))


def test_frozen_held_and_guided():
    frozen, held = (sphere(R, RHO, position=(0, 0, -R), motion=m) for m in ("frozen", "held"))
    law = HOOKE.replace(damping="damping_ratio", damping_coefficient=0.2)
    first = sphere(R, RHO, position=(0, 0, R), velocity=(0.3, 0, -1.0), axes=(False, True, True))
    ends = []
    for other in (frozen, held):
        scene = Scene(bodies=(first, other), law=law, step=1e-6, steps=3000, every=3000,
                      gravity=(5.0, 0.0, 0.0))  # fmt: skip
        motion = reference.run(scene)
        assert motion.velocity[-1, 1] == pytest.approx([0.0, 0.0, 0.0])
        assert motion.velocity[-1, 0, 0] == 0.3
        ends.append(motion.velocity[-1, 0, 2])
    assert ends[1] > ends[0] + 0.05  # its own mass in m* halves the dashpot's square
