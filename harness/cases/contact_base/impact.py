"""Impacts: the first sphere flies at what it meets, touches, and leaves."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from harness.cases.contact_base.motion import Array, Motion
from harness.cases.contact_base.parameters import ContactSystem, hertz_spring
from harness.cases.contact_base.reference import contact_time
from harness.parameters.contact_scene import ZERO, ContactScene, Vector

SAMPLES = 100
"""Of a contact, about."""

AFTER = 1.1
"""Contact times that are simulated: a contact that a coarse step draws out must be over."""


def impact(
    parameters: ContactSystem,
    velocity: Vector,
    omega: Vector = ZERO,
    other_omega: Vector = ZERO,
    *,
    finely: bool,
    gravity: Vector = ZERO,
) -> ContactScene:
    """Return the impact of the first sphere, which touches half a step after the start.

    The second is at rest, but that it may spin. ``finely``: sampled over the contact, else at its
    ends.
    """
    n = parameters.steps_per_contact
    guess = _guess(parameters, velocity)
    first, *others = parameters.bodies(0.0, velocity, omega)
    touching = ContactScene(
        (first, *(replace(other, omega=other_omega) for other in others)),
        parameters.planes,
        parameters.law,
        step=guess,
        steps=1,
        gravity=gravity,
    )
    step = contact_time(_before(touching, 1e-3 * guess)) / n
    every = max(1, n // SAMPLES) if finely else 1
    steps = every * math.ceil(AFTER * n / every)
    scene = replace(touching, step=step, steps=steps, every=every if finely else steps)
    return _before(scene, 0.5 * step)


def _before(scene: ContactScene, lead: float) -> ContactScene:
    """Return a scene a time [s] before, when its first body flew freely."""
    first, *others = scene.bodies
    v = [u - lead * g for u, g in zip(first.velocity, scene.gravity, strict=True)]
    x = [
        x - lead * u + 0.5 * lead * lead * g
        for x, u, g in zip(first.position, first.velocity, scene.gravity, strict=True)
    ]
    early = replace(first, position=(x[0], x[1], x[2]), velocity=(v[0], v[1], v[2]))
    return replace(scene, bodies=(early, *others))


def _guess(parameters: ContactSystem, velocity: Vector) -> float:
    """Return a time that is longer than the contact [s], without damping."""
    speed, m = -velocity[2], parameters.reduced_mass
    if parameters.normal_stiffness is not None:
        return 4.0 * math.pi * math.sqrt(m / parameters.normal_stiffness)
    overlap: float = (1.25 * m * speed * speed / hertz_spring(parameters)) ** 0.4
    return 12.0 * overlap / speed


def relative_velocity(motion: Motion) -> Array:
    """Return the velocity of the first sphere against what it meets [m/s], (M, 3)."""
    v = motion.velocity
    return v[:, 0] - v[:, 1] if v.shape[1] > 1 else v[:, 0]


def overlap_of(parameters: ContactSystem, motion: Motion) -> tuple[Array, Array]:
    """Return the overlap [m] and its rate [m/s], each (M,)."""
    x, v = motion.position, motion.velocity
    if parameters.partner == "wall":
        return parameters.radius - x[:, 0, 2], -v[:, 0, 2]
    apart, moving = x[:, 0] - x[:, 1], v[:, 0] - v[:, 1]
    distance = np.linalg.norm(apart, axis=1)
    rate = np.einsum("ij,ij->i", apart, moving) / distance
    return parameters.radius + parameters.second_radius - distance, -rate
