"""A sphere on a curved wall: in a bowl or a cylinder, on a hill, on the rim of an open box.

The walls are LAMMPS's regions. A bowl is a hollow sphere that is frozen, a hill one that is solid,
a rim one without a radius; the sphere moves in a plane, in which a cylinder is a bowl.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from harness.cases.contact.contact_case import Resting, RestingCase
from harness.cases.contact.motion import Motion, scene_of
from harness.cases.contact.parameters import Radius, rest_overlap
from harness.cases.contact.submodels import NORMAL, SLIDING, TANGENTIAL, Told
from harness.cases.contact.surroundings import refused
from harness.model.scene import Scene, Wall
from harness.parameters.scene import Body, ContactScene, Vector

EDGE = 1e-30
"""[m] radius of an edge: none."""


class CurvedWall(Resting):
    """A sphere let go on a curved wall, pressed in by its weight; in SI units, degrees."""

    wall: Literal["bowl", "cylinder", "hill", "rim"] = Field(
        "bowl",
        description="[-] the sphere is in a bowl or a lying cylinder, on a hill, or on an edge",
    )
    wall_radius: Radius = Field(0.02, description="[m] of the wall; a rim has none")
    angle: float = Field(
        30.0, ge=1e-3, le=60.0, description="[deg] of the sphere, at the start, from the vertical"
    )

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        if self.hollow and self.wall_radius < 1.1 * self.radius:
            raise ValueError(
                f"wall_radius = {self.wall_radius!r} m: must be at least {1.1 * self.radius:.6g}, "
                "a tenth more than the sphere's, to be round it"
            )
        hertzian = ("hooke", "hertz") if self.wall != "rim" else ("hooke",)
        constant: tuple[str, ...] = (
            *("none", "velocity", "mass_velocity", "coeff_restitution", "viscoelastic"),
        )
        if self.wall == "cylinder" and self.normal == "hertz":
            constant = ("none", "velocity", "mass_velocity")
        refused(self, normal=hertzian, damping=constant, rolling=("none",), twisting=("none",))
        super().check()

    @property
    def hollow(self) -> bool:
        """Return whether the sphere is within the wall."""
        return self.wall in ("bowl", "cylinder")

    @property
    def pull(self) -> Vector:
        """Return gravity along the wall and into it, at the start [m/s2]."""
        angle = math.radians(self.angle)
        return (self.gravity * math.sin(angle), 0.0, -self.gravity * math.cos(angle))

    @property
    def curvature(self) -> float:
        """Return the radius of the body that stands for the wall [m], negative where hollow."""
        if self.wall == "rim":
            return EDGE
        return -self.wall_radius if self.hollow else self.wall_radius

    @property
    def reduced_radius(self) -> float:
        """Return R* [m] of the mean curvature; on an edge that of the sphere, as at a plane."""
        if self.wall == "rim":
            return self.radius
        other = self.curvature * (2.0 if self.wall == "cylinder" else 1.0)
        return self.radius * other / (self.radius + other)


class CurvedWallCase(RestingCase[CurvedWall]):
    """A sphere let go on a curved wall swings, rolls or falls: angle, velocity, spin, overlap."""

    name = "curved-wall"
    submodels = (
        *(
            replace(submodel, systems=("bowl", "cylinder", "hill"), two_materials=False)
            for submodel in NORMAL
            if submodel.name == "hertz, mass_velocity"
        ),
        *(submodel for submodel in TANGENTIAL if submodel.name == "linear_history"),
        *(submodel for submodel in NORMAL if submodel.name == "hooke, velocity"),
        *(submodel for submodel in TANGENTIAL if submodel.name == "linear_nohistory"),
        *(
            replace(submodel, systems=("bowl", "hill"), two_materials=False)
            for submodel in TANGENTIAL
            if submodel.name == "mindlin"
        ),
    )
    lasts = True
    sets: ClassVar[Told] = {"bowl": SLIDING}
    systems: ClassVar[Told] = {
        "bowl": {"wall": "bowl", "duration": 60.0},
        "cylinder": {"wall": "cylinder", "duration": 60.0},
        "hill": {"wall": "hill", "angle": 20.0},
        "rim": {"wall": "rim", "angle": 20.0},
    }

    def scene(self, parameters: CurvedWall) -> ContactScene:
        """Return the sphere at rest along the normal, and what stands for the wall."""
        flat = super().scene(parameters)
        overlap = rest_overlap(parameters, parameters.mass * -parameters.pull[2])
        angle, away = math.radians(parameters.angle), parameters.radius + parameters.curvature
        place = (abs(away - overlap) * math.sin(angle), 0.0, (away - overlap) * math.cos(angle))
        first = replace(flat.bodies[0], position=place)
        wall = Body(parameters.curvature, parameters.mass, (0.0, 0.0, 0.0), frozen=True)
        down = (0.0, 0.0, -parameters.gravity)
        return replace(flat, bodies=(first, wall), planes=(), gravity=down)

    def setup(self, parameters: CurvedWall) -> Scene:
        """Return the sphere and the wall; an edge is a cylinder without a radius."""
        scene = self.scene(parameters)
        bowl = scene_of(replace(scene, bodies=scene.bodies[:1]), parameters)
        lies = parameters.wall in ("cylinder", "rim")
        wall = Wall(
            shape="cylinder" if lies else "sphere",
            direction=(0.0, 1.0, 0.0) if lies else (0.0, 0.0, 1.0),
            radius=abs(parameters.curvature),
            hollow=parameters.hollow,
        )
        return bowl.replace(walls=(wall,))

    def observed(self, parameters: CurvedWall, motion: Motion) -> Mapping[str, float]:
        """Return angles, velocities over those of a plane as steep, and the overlap."""
        x, z = motion.position[:, 0, 0], motion.position[:, 0, 2]
        hollow = -1.0 if parameters.hollow else 1.0
        angle = np.arctan2(x, hollow * z) / math.radians(parameters.angle)
        gained = parameters.pull[0] * float(motion.time[-1])
        overlap = parameters.radius + parameters.curvature - hollow * np.hypot(x, z)
        return {
            "angle_ratio": float(angle[-1]),
            "halfway_angle_ratio": float(angle[len(angle) // 2]),
            "sideways_velocity_ratio": hollow * float(motion.velocity[-1, 0, 0]) / gained,
            "sideways_spin_ratio": hollow
            * parameters.radius
            * float(motion.angular_velocity[-1, 0, 1])
            / gained,
            "overlap_ratio": float(overlap[-1] / overlap[0]),
        }


CASE = CurvedWallCase()
