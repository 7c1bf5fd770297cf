"""Impacts in no plane, with spins about all axes, at 50 steps a contact."""

import numpy as np

from harness.model.scene import Motion, Scene, sphere
from harness.solvers import reference
from tests.solvers.reference.scenes import FLOOR, LINEAR, MASS, RHO, R, contact_time, difference

STEPS = 50  # a contact
SPRING = {"tangential": "linear_history", "tangential_stiffness": 3e4, "friction": 0.3}
ROLLS = {"rolling": "sds", "rolling_damping": 0.0, "rolling_friction": 0.1}
TWISTS = {"twisting": "sds", "twisting_damping": 0.0, "twisting_friction": 1e-4}
VELOCITY, SPIN = (0.3, -0.2, -0.5), (10.0, -20.0, 50.0)


def struck_floor(law):
    """Return a sphere that strikes the floor, under a gravity that is tilted."""
    body = sphere(R, RHO, position=(0.0, 0.0, R - 1e-6), velocity=VELOCITY, angular_velocity=SPIN)
    step = contact_time(law, 0.5) / STEPS
    return Scene(bodies=(body,), walls=FLOOR, law=law, gravity=(1.0, 2.0, -9.0), step=step,
                 steps=2 * STEPS, every=10)  # fmt: skip


def struck_pair(law, size=1.0, motion="free"):
    """Return two spheres that touch, the second of so many radii of the first."""
    towards = np.array([0.1, 0.2, 1.0]) / np.linalg.norm([0.1, 0.2, 1.0])
    place = towards * ((1.0 + size) * R - 1e-6)
    first = sphere(R, RHO, velocity=(0.1, 0.2, 0.5), angular_velocity=SPIN)
    moved = {"velocity": (-0.5, 0.7, -0.5)} if motion == "free" else {}
    second = sphere(size * R, RHO, position=tuple(place), angular_velocity=(3.0, 20.0, -5.0),
                    motion=motion, **moved)  # fmt: skip
    step = contact_time(law, 1.0, min(1.0, size**3) * MASS, min(1.0, size) * R) / STEPS
    return Scene(bodies=(first, second), law=law, step=step, steps=2 * STEPS, every=10)


STRUCK = struck_pair(LINEAR.replace(clipped=True), 0.6)
STRUCK_ELASTIC = struck_pair(LINEAR.replace(damping="none", tangential_damping=0.0), 0.6)


def moving(scene, motion):
    """Return the motion of the bodies that forces or segments move."""
    moves = [bool(scene.segments) or body.motion != "frozen" for body in scene.bodies]
    names = ("position", "velocity", "angular_velocity", "force", "torque")
    return Motion(motion.time, *(getattr(motion, name)[:, moves] for name in names))


def error(scene, motion, rules, faults=None):
    """Return the largest difference of a motion to the reference, over the sizes in the scene."""
    expected = reference.run(scene, rules, faults)
    return difference(moving(scene, motion), moving(scene, expected))
