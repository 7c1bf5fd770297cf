"""A sphere at rest along the normal that moves or turns along the surface."""

from __future__ import annotations

import math
from typing import ClassVar, TypeVar

from pydantic import Field

from harness.cases.contacts import bounds
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import ContactSystem, Duration, Gravity
from harness.model.base import ZERO, Vector
from harness.model.motion import Floats, Motion
from harness.model.scene import Scene


class Resting(ContactSystem):
    """A sphere pressed into its partner by its weight; in SI units."""

    partners: ClassVar[tuple[str, ...]] = ("wall",)

    gravity: Gravity = Field(9.81, description="[m/s2] downward")
    duration: Duration = Field(20.0, description="[-] in half periods of the contact")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        bounds.check_words(self, partner=self.partners)
        bounds.check_rest(self, -self.pull[2])

    @property
    def pull(self) -> Vector:
        """Return the acceleration of gravity [m/s2]."""
        return (0.0, 0.0, -self.gravity)

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return velocity [m/s] and angular velocity [rad/s] at the start."""
        return ZERO, ZERO

    @property
    def load(self) -> float:
        """Return the normal force at rest [N]."""
        return self.mass * -self.pull[2]

    @property
    def overlap_at_rest(self) -> float:
        """Return the overlap [m]; attraction is not taken into account."""
        return self.rest_overlap(self.load)

    @property
    def half_period(self) -> float:
        """Return pi sqrt(m / k) of small oscillations about rest [s]."""
        return math.pi * math.sqrt(self.mass / self.slope(self.overlap_at_rest))

    @property
    def seconds(self) -> float:
        """Return the duration [s]. Raise RequestError where it has none."""
        return self.duration * self.half_period


R = TypeVar("R", bound=Resting)


class RestingCase(ContactCase[R]):
    """The scene of a sphere at rest, with a sample after each quarter."""

    def build(self, p: R) -> Scene:
        """Return the sphere at rest along z under gravity; the steps fill the duration.

        Raise RequestError for too many steps, and for a step that does not resolve the law.
        """
        step = p.half_period / p.steps_per_contact
        grid = bounds.quarters(p.duration, p.seconds / step, p.seconds)
        bodies = p.bodies(-p.overlap_at_rest, *p.start)
        bounds.check_steps(p, bodies, grid["step"], p.overlap_at_rest)
        return Scene(
            bodies=bodies,
            walls=p.walls,
            law=p.stated_law,
            gravity=p.pull,
            **grid,
        )


def rolling(p: Resting, motion: Motion) -> tuple[Floats, Floats]:
    """Return the speed along x, and radius times the spin about y, each (M,) [m/s]."""
    return motion.velocity[:, 0, 0], p.radius * motion.angular_velocity[:, 0, 1]


def speed_ratios(halfway: str, p: Resting, motion: Motion, speed: float) -> dict[str, float]:
    """Return the speed halfway, by a name, speed and rim speed at the end, over a speed [m/s]."""
    u, rim = rolling(p, motion)
    speeds = {halfway: u[len(u) // 2], "speed_ratio": u[-1], "rim_speed_ratio": rim[-1]}
    return {name: float(value) / speed for name, value in speeds.items()}
