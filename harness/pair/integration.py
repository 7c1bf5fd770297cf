"""The reference integration of a scene: its motion sampled, and what happened in it."""

from __future__ import annotations

from itertools import accumulate

import numpy as np

from harness.pair.motion import Motion
from harness.pair.path import ContactPath
from harness.pair.records import BODY, CONTACT, Floats, System
from harness.pair.sample import sampled
from harness.pair.switching import open_contacts
from harness.pair.system import first_modes, system_of
from harness.parameters.contact_rules import Rules
from harness.parameters.contact_scene import ContactScene

TOLERANCE = 1e-15
"""[overlap, speed of the contact] local error of a step."""


def integrate(
    scene: ContactScene, rules: Rules | None = None, tolerance: float = TOLERANCE
) -> ContactPath:
    """Return the motion of a scene under its law, or the forces along prescribed motion.

    ``tolerance`` bounds the local error of a step in units of the contact's overlap and speed.
    """
    system = system_of(scene, rules or Rules())
    motion = Motion(system, _first_state(scene, system), first_modes(system), tolerance)
    open_contacts(motion.y, system, motion.modes)
    motion.start()
    samples = []
    starts = dict(
        zip(accumulate(s.steps for s in scene.segments), scene.segments[1:], strict=False)
    )
    if scene.segments:
        motion.prescribe(scene.segments[0])
    for number in sorted({*range(0, scene.steps + 1, scene.every), *starts}):
        motion.advance(number * scene.step)
        if number % scene.every == 0:
            samples.append(_sample(motion))
        if number in starts:
            motion.prescribe(starts[number])
    times, bodies, acting, overlaps, springs = (
        np.array(part) for part in zip(*samples, strict=True)
    )
    return ContactPath(
        times=times,
        positions=bodies[:, :, 0],
        velocities=bodies[:, :, 1],
        omegas=bodies[:, :, 2],
        forces=acting[:, :, :3],
        torques=acting[:, :, 3:],
        overlaps=overlaps,
        springs=springs,
        contacts=tuple(motion.name(c) for c in range(len(system.contacts))),
        events=tuple(motion.events),
        steps=motion.steps,
    )


def _first_state(scene: ContactScene, system: System) -> Floats:
    y = np.zeros(BODY * len(scene.bodies) + CONTACT * len(system.contacts))
    for b, body in enumerate(scene.bodies):
        y[BODY * b : BODY * b + BODY] = (*body.position, *body.velocity, *body.omega)
    return y


def _sample(motion: Motion) -> tuple[Floats, ...]:
    """Return time, bodies, forces, overlaps and springs as they are now."""
    y, system = motion.y, motion.system
    bodies = y[: BODY * len(system.bodies)].reshape(-1, 3, 3).copy()
    return np.array(motion.time), bodies, *sampled(y, system, motion.modes)
