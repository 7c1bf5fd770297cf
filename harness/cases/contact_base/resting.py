"""A sphere that rests on the floor or on a frozen sphere, pressed in by its weight."""

from __future__ import annotations

import math

from harness.cases.contact_base.parameters import ContactSystem, hertz_spring
from harness.parameters.contact_scene import ContactScene, Vector


def rest_overlap(parameters: ContactSystem, load: float) -> float:
    """Return the overlap under a load [N] at rest [m]; attraction is not taken into account."""
    if parameters.normal_stiffness is not None:
        return load / parameters.normal_stiffness
    overlap: float = (load / hertz_spring(parameters)) ** (2.0 / 3.0)
    return overlap


def half_period(parameters: ContactSystem, load: float) -> float:
    """Return pi sqrt(m / k) of small oscillations about rest under a load [N], in s."""
    k = parameters.normal_stiffness
    if k is None:
        k = 1.5 * hertz_spring(parameters) * math.sqrt(rest_overlap(parameters, load))
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
    step; ``samples`` divide it evenly.
    """
    load = parameters.mass * -gravity[2]
    step = half_period(parameters, load) / parameters.steps_per_contact
    every = max(1, round(duration / step / samples))
    first, *others = parameters.bodies(-rest_overlap(parameters, load), *start)
    return ContactScene(
        (first, *others),
        parameters.planes,
        parameters.law,
        # the steps fill the duration: all rungs end at the same time
        step=duration / samples / every,
        steps=samples * every,
        every=every,
        gravity=gravity,
    )
