"""A sphere on a curved wall: in a bowl or a cylinder, on a hill, on the rim of an open box.

The walls are LAMMPS's regions. The sphere moves in a plane, in which a cylinder is a bowl; a rim is
a cylinder without a radius.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from harness.cases.contacts.contact_case import ContactCase, ratios
from harness.cases.contacts.parameters import Radius
from harness.cases.contacts.resting import Resting
from harness.model.base import Vector
from harness.model.motion import Motion
from harness.model.scene import Scene, Wall

EDGE = 1e-30  # [m] radius of an edge: none


class CurvedWall(Resting):
    """A sphere let go on a curved wall, pressed in by its weight; in SI units, degrees."""

    allowed: ClassVar = {
        **Resting.allowed, "normal": ("hooke", "hertz"), "rolling": ("none",),
        "twisting": ("none",),
        "damping": ("none", "velocity", "mass_velocity", "coeff_restitution", "viscoelastic"),
    }  # fmt: skip

    # fmt: off
    wall: Literal["bowl", "cylinder", "hill", "rim"] = Field(
        "bowl", description="[-] a bowl, a lying cylinder around the sphere, a hill, or an edge")
    wall_radius: Radius = Field(0.02, description="[m] of the wall; a rim has none")
    angle: float = Field(
        30.0, ge=1e-3, le=60.0, description="[deg] of the sphere, at the start, from the vertical")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for a wall that is not around the sphere, and a law that it has not."""
        if self.is_hollow:
            self.check_range("wall_radius", 1.1 * self.radius, 1e3, "to be around the sphere")
        if self.wall == "rim" and self.normal != "hooke":
            raise self.invalid("normal", "must be hooke on a rim")
        on_hertz = self.wall == "cylinder" and self.normal == "hertz"
        if on_hertz and self.damping in ("coeff_restitution", "viscoelastic"):
            raise self.invalid("damping", "must be without the radius of the contact in a cylinder")
        super().check()

    @property
    def is_hollow(self) -> bool:
        """Return whether the sphere is within the wall."""
        return self.wall in ("bowl", "cylinder")

    @property
    def pull(self) -> Vector:
        """Return gravity along the wall and into it, at the start [m/s2]."""
        angle = math.radians(self.angle)
        return (self.gravity * math.sin(angle), 0.0, -self.gravity * math.cos(angle))

    @property
    def curvature_radius(self) -> float:
        """Return the radius of the wall [m], negative where hollow."""
        if self.wall == "rim":
            return EDGE
        return -self.wall_radius if self.is_hollow else self.wall_radius

    @property
    def effective_radius(self) -> float:
        """Return R* [m] of the mean curvature; on an edge that of the sphere, as at a plane."""
        if self.wall == "rim":
            return self.radius
        other = self.curvature_radius * (2.0 if self.wall == "cylinder" else 1.0)
        return self.radius * other / (self.radius + other)

    def scene(self) -> Scene:
        """Return the sphere at rest along the normal, and the wall about the origin."""
        flat = super().scene()
        angle = math.radians(self.angle)
        distance = self.radius + self.curvature_radius - self.overlap_at_rest
        place = (abs(distance) * math.sin(angle), 0.0, distance * math.cos(angle))
        lies = self.wall in ("cylinder", "rim")
        wall = Wall(
            shape="cylinder" if lies else "sphere",
            direction=(0.0, 1.0, 0.0) if lies else (0.0, 0.0, 1.0),
            radius=abs(self.curvature_radius),
            hollow=self.is_hollow,
        )
        body = flat.bodies[0].replace(position=place)
        return flat.replace(bodies=(body,), walls=(wall,), gravity=(0.0, 0.0, -self.gravity))

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return angles, velocities over those of a plane as steep, and the overlap."""
        x, z = motion.position[:, 0, 0], motion.position[:, 0, 2]
        sign = -1.0 if self.is_hollow else 1.0
        angle = np.arctan2(x, sign * z) / math.radians(self.angle)
        gained = self.pull[0] * float(motion.time[-1])
        overlap = self.radius + self.curvature_radius - sign * np.hypot(x, z)
        rim = self.radius * float(motion.angular_velocity[-1, 0, 1])
        return {
            "angle_ratio": float(angle[-1]),
            "halfway_angle_ratio": float(angle[len(angle) // 2]),
            "sideways_velocity_ratio": sign * float(motion.velocity[-1, 0, 0]) / gained,
            "sideways_spin_ratio": sign * rim / gained,
            "overlap_ratio": float(overlap[-1] / overlap[0]),
        }


CURVED_WALL = ContactCase(
    name="curved-wall",
    summary="A sphere let go on a curved wall swings, rolls or falls.",
    formula="Integrated, R* = r R / (R - r) in a bowl, r R / (R + r) on a hill, r on an edge, and "
    "in a cylinder that of the mean curvature, 2 r R / (2 R - r). Small and stiff it swings with "
    "omega^2 = g / (R - r), rolling with 5/7 of it.",
    parameters=CurvedWall,
    quantities=ratios(
        angle_ratio="angle from the vertical over that of the start",
        halfway_angle_ratio="likewise, halfway",
        sideways_velocity_ratio="horizontal velocity over g sin(angle) t, downhill",
        sideways_spin_ratio="radius times spin over g sin(angle) t, as it rolls down",
        overlap_ratio="overlap at the end over that at the start",
    ),
)
