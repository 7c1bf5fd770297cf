"""A sphere that rests on the floor or on a frozen sphere, pressed in by its weight."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, TypeVar

from pydantic import Field

from harness.cases.contact_base.contact_case import ContactCase
from harness.cases.contact_base.motion import Array, Motion
from harness.cases.contact_base.parameters import ContactSystem, Duration, Gravity
from harness.cases.contact_base.scales import (
    counted,
    meets,
    resolved,
    rest_overlap,
    rests,
    stiffness,
)
from harness.parameters.contact_scene import ZERO, ContactScene, Vector

SAMPLES = 4


class Resting(ContactSystem):
    """A sphere at rest along z, that moves or turns along the surface; in SI units."""

    carried_by: ClassVar[tuple[str, ...]] = ("wall",)

    gravity: Gravity = Field(9.81, description="[m/s2] downward")
    duration: Duration = Field(20.0, description="[-] in half periods of the contact")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        meets(self, *self.carried_by)
        rests(self, -self.pull[2])

    @property
    def pull(self) -> Vector:
        """Return the acceleration of gravity [m/s2]."""
        return (0.0, 0.0, -self.gravity)

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return velocity [m/s] and angular velocity [rad/s] at the start."""
        return ZERO, ZERO

    @property
    def half_period(self) -> float:
        """Return pi sqrt(m / k) of small oscillations about rest [s]."""
        k = stiffness(self, rest_overlap(self, self.mass * -self.pull[2]))
        return math.pi * math.sqrt(self.mass / k)

    @property
    def seconds(self) -> float:
        """Return the duration [s]; raise RequestError where it has none."""
        return self.duration * self.half_period


R = TypeVar("R", bound=Resting)


class RestingCase(ContactCase[R]):
    """What the cases of a sphere at rest share: the scene, and the drawing of rolling."""

    def scene(self, parameters: R) -> ContactScene:
        """Return the sphere at rest along z under gravity.

        The duration is met to a step. Raise RequestError for too many steps, which are told of the
        parameter ``duration``, and for a step that does not resolve the law.
        """
        step = parameters.half_period / parameters.steps_per_contact
        counted(parameters, parameters.seconds / step)
        every = max(1, round(parameters.seconds / step / SAMPLES))
        overlap = rest_overlap(parameters, parameters.mass * -parameters.pull[2])
        first, *others = parameters.bodies(-overlap, *parameters.start)
        scene = ContactScene(
            (first, *others),
            parameters.planes,
            parameters.law,
            # the steps fill the duration: all rungs end at the same time
            step=parameters.seconds / SAMPLES / every,
            steps=SAMPLES * every,
            every=every,
            gravity=parameters.pull,
        )
        return resolved(parameters, scene, overlap)

    def axes(self, parameters: R) -> tuple[str, str]:
        """Return what is drawn: both speeds."""
        return "time (ms)", "velocity (m/s)"

    def curves(self, parameters: R, motion: Motion) -> Mapping[str, tuple[Array, Array]]:
        """Return the speed, and radius times spin."""
        named = zip(("speed", "radius times spin"), rolling(parameters, motion), strict=True)
        return {name: (1e3 * motion.time, value) for name, value in named}


def rolling(parameters: Resting, motion: Motion) -> tuple[Array, Array]:
    """Return the speed along x, and radius times the spin about y, each (M,) [m/s]."""
    return motion.velocity[:, 0, 0], parameters.radius * motion.omega[:, 0, 1]


def speed_ratios(
    halfway: str, parameters: Resting, motion: Motion, speed: float
) -> dict[str, float]:
    """Return the speed halfway, by a name, speed and spin at the end, over a speed [m/s]."""
    u, spin = rolling(parameters, motion)
    found = {halfway: u[len(u) // 2], "speed_ratio": u[-1], "rim_speed_ratio": spin[-1]}
    return {name: float(value) / speed for name, value in found.items()}
