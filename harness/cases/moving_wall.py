"""A sphere at rest on a plane that oscillates, or that runs off: LAMMPS's wiggle and shear.

A plane that runs at a constant speed is, seen from it, one at rest under a sphere that slides: the
same law integrated. Under one that oscillates a contact that neither slides nor parts is a driven
oscillator.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from harness.cases.contact.contact_case import Resting, RestingCase, rolling
from harness.cases.contact.motion import Array, Motion
from harness.cases.contact.parameters import (
    Speed,
    dashpots,
    rest_overlap,
    stiffness,
    tangential_stiffness,
)
from harness.cases.contact.submodels import SLIDING, TANGENTIAL, Told
from harness.cases.contact.surroundings import refused
from harness.errors import RequestError
from harness.model.scene import Scene
from harness.parameters.scene import ZERO, Vector
from harness.theory.contact import driven

INSTANTS = 4000
"""At which forces are held against their limits."""


class MovingWall(Resting):
    """A sphere at rest on a plane that moves from the start on; in SI units."""

    moves: Literal["shear", "along", "across"] = Field(
        "shear", description="[-] at a constant speed; oscillating along or across the surface"
    )
    speed: Speed = Field(0.1, description="[m/s] of a plane that shears")
    acceleration: float = Field(
        0.1, gt=0.0, le=1e6, description="[-] largest of an oscillating plane, over gravity"
    )
    period: float = Field(
        7.0, ge=0.1, le=1e6, description="[-] of the oscillation, in half periods of the contact"
    )
    duration: float = Field(20.0, ge=1e-3, le=1e9, description="[-] in half periods of the contact")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        super().check()
        refused(self, normal=("hooke", "hertz"), rolling=("none",), twisting=("none",))
        if self.moves == "across" and not self.linear:
            raise ValueError(
                f"normal = {self.normal!r}: must be a linear spring with a constant dashpot where "
                "the plane moves across"
            )
        if (
            self.moves == "along"
            and not self.tangential_stiffness
            and "mindlin" not in self.tangential
        ):
            raise ValueError(
                f"tangential = {self.tangential!r}: must have a spring where the plane moves along"
            )

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return how the sphere moves as it is seen from the plane."""
        return ((-self.speed, 0.0, 0.0) if self.moves == "shear" else ZERO), ZERO

    @property
    def drive(self) -> float:
        """Return the frequency of the oscillation [rad/s]."""
        return 2.0 * math.pi / (self.period * self.half_period)

    @property
    def largest(self) -> float:
        """Return the largest velocity of the plane [m/s]."""
        if self.moves == "shear":
            return self.speed
        return self.acceleration * self.gravity / self.drive


class MovingWallCase(RestingCase[MovingWall]):
    """A plane that oscillates or runs off takes a sphere along: velocity and spin."""

    name = "moving-wall"
    submodels = tuple(
        replace(submodel, systems=systems, two_materials=False)
        for name, systems in (
            ("linear_nohistory", ("shear",)),
            ("mindlin", ("shear", "along")),
            ("linear_history", ("shear", "along", "across")),
        )
        for submodel in TANGENTIAL
        if submodel.name == name
    )
    sets: ClassVar[Told] = {"shear": SLIDING}
    systems: ClassVar[Told] = {
        "shear": {"moves": "shear"},
        "along": {"moves": "along"},
        "across": {"moves": "across"},
    }

    def setup(self, parameters: MovingWall) -> Scene:
        """Return the scene with the sphere at rest and the plane that moves."""
        scene = super().setup(parameters)
        (body,), (wall,) = scene.bodies, scene.walls
        if parameters.moves == "shear":
            wall = wall.replace(surface_velocity=(parameters.speed, 0.0, 0.0))
        else:
            length = parameters.largest / parameters.drive
            along = parameters.moves == "along"
            amplitude = (length, 0.0, 0.0) if along else (0.0, 0.0, length)
            wall = wall.replace(amplitude=amplitude, frequency=parameters.drive)
        return scene.replace(bodies=(body.replace(velocity=ZERO),), walls=(wall,))

    def observed(self, parameters: MovingWall, motion: Motion) -> Mapping[str, float]:
        """Return what the sphere gained, which is the same seen from the plane that shears."""
        u, spin = rolling(parameters, motion)
        if parameters.moves == "across":
            u = motion.velocity[:, 0, 2]
        gained, half = (u - u[0]) / parameters.largest, len(u) // 2
        quantities = {
            "halfway_gained_velocity_ratio": float(gained[half]),
            "gained_velocity_ratio": float(gained[-1]),
        }
        if parameters.moves != "across":
            rim = float(spin[-1]) / parameters.largest
            quantities["gained_spin_ratio"] = rim
            quantities["surface_momentum_ratio"] = quantities["gained_velocity_ratio"] + 0.4 * rim
        return quantities

    def closed_forms(self, parameters: MovingWall) -> Mapping[str, float]:
        """Return the driven oscillation; of a plane that shears what no friction changes.

        Raise RequestError for one that shakes the sphere off, or on which it slides.
        """
        if parameters.moves == "shear":
            return {"surface_momentum_ratio": 0.0}
        end = self.scene(parameters).duration
        times = np.linspace(0.0, end, 2 * INSTANTS + 1)
        speeds = self._velocity(parameters, times) / parameters.largest
        gained = {
            "halfway_gained_velocity_ratio": float(speeds[INSTANTS]),
            "gained_velocity_ratio": float(speeds[-1]),
        }
        if parameters.moves == "across":
            return gained
        spin = -2.5 * gained["gained_velocity_ratio"]
        return {**gained, "gained_spin_ratio": spin, "surface_momentum_ratio": 0.0}

    def _velocity(self, parameters: MovingWall, times: Array) -> Array:
        """Return the velocity of the sphere [m/s] on a plane that oscillates, (M,)."""
        mass, gravity, w = parameters.mass, parameters.gravity, parameters.drive
        overlap = rest_overlap(parameters, mass * gravity)
        k, eta, factor = stiffness(parameters, overlap), dashpots(parameters, overlap), 1.0
        if parameters.moves == "along":
            k, factor = tangential_stiffness(parameters, overlap), 3.5
            eta *= parameters.tangential_damping or 0.0
        omega, decay = math.sqrt(factor * k / mass), 0.5 * factor * eta / mass
        y, rate = driven(times, omega, decay, parameters.acceleration * gravity, w)
        force = k * y + eta * rate
        load = mass * gravity
        limit = load if parameters.moves == "across" else (parameters.friction or 0.0) * load
        most = float(force.max()) if parameters.moves == "across" else float(np.abs(force).max())
        if most >= limit:
            allowed = parameters.acceleration * limit / most
            raise RequestError(
                f"acceleration = {parameters.acceleration!r}: must be below {allowed:.4g} here: "
                "the sphere must neither slide nor leave the plane"
            )
        wall = parameters.largest * np.sin(w * times)
        return rate + wall if factor == 1.0 else (rate + wall) / factor


CASE = MovingWallCase()
