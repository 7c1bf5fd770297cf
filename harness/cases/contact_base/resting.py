"""A sphere that rests on the floor or on a frozen sphere, pressed in by its weight."""

from __future__ import annotations

import math

from harness.cases.contact_base.parameters import ContactSystem
from harness.cases.contact_base.scales import counted, resolved, rest_overlap, stiffness
from harness.parameters.contact_scene import ContactScene, Vector


def half_period(parameters: ContactSystem, load: float) -> float:
    """Return pi sqrt(m / k) of small oscillations about rest under a load [N], in s."""
    k = stiffness(parameters, rest_overlap(parameters, load))
    return math.pi * math.sqrt(parameters.mass / k)


def resting(
    parameters: ContactSystem,
    gravity: Vector,
    start: tuple[Vector, Vector],
    duration: float,
    samples: int = 4,
) -> ContactScene:
    """Return a sphere at rest along z under gravity [m/s2], that moves or turns along the surface.

    ``start`` is its velocity [m/s] and angular velocity [rad/s]; ``duration`` is in s, met to a
    step; ``samples`` divide it evenly. Raise RequestError for too many steps, which are told of the
    parameter ``duration``, and for a step that does not resolve the law.
    """
    load = parameters.mass * -gravity[2]
    step = half_period(parameters, load) / parameters.steps_per_contact
    counted(parameters, duration / step)
    every = max(1, round(duration / step / samples))
    overlap = rest_overlap(parameters, load)
    first, *others = parameters.bodies(-overlap, *start)
    scene = ContactScene(
        (first, *others),
        parameters.planes,
        parameters.law,
        # the steps fill the duration: all rungs end at the same time
        step=duration / samples / every,
        steps=samples * every,
        every=every,
        gravity=gravity,
    )
    return resolved(parameters, scene, overlap)
