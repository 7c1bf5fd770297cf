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

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.parameters import Radius
from harness.cases.contacts.resting import Resting, RestingCase
from harness.model.base import Vector
from harness.model.motion import Motion
from harness.model.scene import Scene, Wall

EDGE = 1e-30  # [m] radius of an edge: none


class CurvedWall(Resting):
    """A sphere let go on a curved wall, pressed in by its weight; in SI units, degrees."""

    # fmt: off
    wall: Literal["bowl", "cylinder", "hill", "rim"] = Field(
        "bowl", description="[-] a bowl, a lying cylinder around the sphere, a hill, or an edge")
    wall_radius: Radius = Field(0.02, description="[m] of the wall; a rim has none")
    angle: float = Field(
        30.0, ge=1e-3, le=60.0, description="[deg] of the sphere, at the start, from the vertical")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        if self.is_hollow and self.wall_radius < 1.1 * self.radius:
            raise ValueError(
                f"wall_radius = {self.wall_radius!r} m: must be at least {1.1 * self.radius:.6g}, "
                "a tenth more than the sphere's, to be round it"
            )
        dampings: tuple[str, ...] = ("none", "velocity", "mass_velocity")
        if self.wall != "cylinder" or self.normal != "hertz":
            dampings += ("coeff_restitution", "viscoelastic")
        normals = ("hooke", "hertz") if self.wall != "rim" else ("hooke",)
        bounds.check_words(
            self, normal=normals, damping=dampings, rolling=("none",), twisting=("none",)
        )
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


class CurvedWallCase(RestingCase[CurvedWall]):
    """Angle, velocity, spin and overlap of a sphere on a curved wall."""

    name = "curved-wall"
    summary = "A sphere let go on a curved wall swings, rolls or falls."
    formula = (
        "Integrated, R* = r R / (R - r) in a bowl, r R / (R + r) on a hill, r on an edge, and in a "
        "cylinder that of the mean curvature, 2 r R / (2 R - r). Small and stiff it swings with "
        "omega^2 = g / (R - r), rolling with 5/7 of it."
    )
    parameters = CurvedWall
    quantities = (
        Quantity("angle_ratio", "1", "angle from the vertical over that of the start"),
        Quantity("halfway_angle_ratio", "1", "likewise, halfway"),
        Quantity(
            "sideways_velocity_ratio", "1", "horizontal velocity over g sin(angle) t, downhill"
        ),
        Quantity(
            "sideways_spin_ratio", "1", "radius times spin over g sin(angle) t, as it rolls down"
        ),
        Quantity("overlap_ratio", "1", "overlap at the end over that at the start"),
    )
    laws: ClassVar = (
        tables.pick("hertz, mass_velocity", systems=("bowl", "cylinder", "hill"))
        | tables.pick("linear_history", "hooke, velocity", "linear_nohistory")
        | tables.pick("mindlin", systems=("bowl", "hill"))
    )
    systems: ClassVar = {
        "bowl": {"wall": "bowl", "duration": 60.0},
        "cylinder": {"wall": "cylinder", "duration": 60.0},
        "hill": {"wall": "hill", "angle": 20.0},
        "rim": {"wall": "rim", "angle": 20.0},
    }

    def build(self, p: CurvedWall) -> Scene:
        """Return the sphere at rest along the normal, and the wall about the origin."""
        flat = super().build(p)
        angle = math.radians(p.angle)
        distance = p.radius + p.curvature_radius - p.overlap_at_rest
        place = (abs(distance) * math.sin(angle), 0.0, distance * math.cos(angle))
        lies = p.wall in ("cylinder", "rim")
        wall = Wall(
            shape="cylinder" if lies else "sphere",
            direction=(0.0, 1.0, 0.0) if lies else (0.0, 0.0, 1.0),
            radius=abs(p.curvature_radius),
            hollow=p.is_hollow,
        )
        body = flat.bodies[0].replace(position=place)
        return flat.replace(bodies=(body,), walls=(wall,), gravity=(0.0, 0.0, -p.gravity))

    def observe(self, p: CurvedWall, motion: Motion) -> Mapping[str, float]:
        """Return angles, velocities over those of a plane as steep, and the overlap."""
        x, z = motion.position[:, 0, 0], motion.position[:, 0, 2]
        sign = -1.0 if p.is_hollow else 1.0
        angle = np.arctan2(x, sign * z) / math.radians(p.angle)
        gained = p.pull[0] * float(motion.time[-1])
        overlap = p.radius + p.curvature_radius - sign * np.hypot(x, z)
        rim = p.radius * float(motion.angular_velocity[-1, 0, 1])
        return {
            "angle_ratio": float(angle[-1]),
            "halfway_angle_ratio": float(angle[len(angle) // 2]),
            "sideways_velocity_ratio": sign * float(motion.velocity[-1, 0, 0]) / gained,
            "sideways_spin_ratio": sign * rim / gained,
            "overlap_ratio": float(overlap[-1] / overlap[0]),
        }


CASE = CurvedWallCase()
