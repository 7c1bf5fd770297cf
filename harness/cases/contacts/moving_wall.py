"""A sphere at rest on a plane that oscillates, or that runs off: LAMMPS's wiggle and shear.

A plane that runs at a constant speed is, seen from it, one at rest under a sphere that slides.
Under one that oscillates a contact that neither slides nor parts is a driven oscillator.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from harness.cases.contacts.contact_case import ContactCase, ratios
from harness.cases.contacts.parameters import Speed
from harness.cases.contacts.resting import Resting
from harness.errors import RequestError
from harness.model.motion import Floats, Motion
from harness.model.scene import Scene
from harness.theory.contact import driven

INSTANTS = 4000  # in half the time, at which forces are held against their limits


class MovingWall(Resting):
    """A sphere at rest on a plane that moves from the start on; in SI units."""

    allowed: ClassVar = {
        **Resting.allowed, "normal": ("hooke", "hertz"), "rolling": ("none",),
        "twisting": ("none",),
    }  # fmt: skip

    # fmt: off
    moves: Literal["shear", "along", "across"] = Field(
        "shear", description="[-] at a constant speed; oscillating along or across the surface")
    speed: Speed = Field(0.1, description="[m/s] of a plane that shears")
    acceleration: float = Field(
        0.1, gt=0.0, le=1e6, description="[-] largest of an oscillating plane, over gravity")
    period: float = Field(
        7.0, ge=0.1, le=1e6, description="[-] of the oscillation, in half periods of the contact")
    duration: float = Field(20.0, ge=1e-3, le=1e9, description="[-] in half periods of the contact")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for a law that no driven oscillator has."""
        super().check()
        if self.moves == "across" and not self.is_linear:
            reason = "must be a linear spring with a constant dashpot where the plane moves across"
            raise self.invalid("normal", reason)
        if self.moves == "along" and not self.has_spring:
            raise self.invalid("tangential", "must have a spring where the plane moves along")

    @property
    def drive(self) -> float:
        """Return the frequency of the oscillation [rad/s]."""
        return 2.0 * math.pi / (self.period * self.half_period)

    @property
    def largest_speed(self) -> float:
        """Return the largest velocity of the plane [m/s]."""
        if self.moves == "shear":
            return self.speed
        return self.acceleration * self.gravity / self.drive

    def scene(self) -> Scene:
        """Return the sphere at rest and the plane that moves."""
        scene = super().scene()
        (wall,) = scene.walls
        if self.moves == "shear":
            return scene.replace(walls=(wall.replace(surface_velocity=(self.speed, 0.0, 0.0)),))
        length = self.largest_speed / self.drive
        amplitude = (length, 0.0, 0.0) if self.moves == "along" else (0.0, 0.0, length)
        return scene.replace(walls=(wall.replace(amplitude=amplitude, frequency=self.drive),))

    def absent(self) -> Collection[str]:
        """Return the quantities of the spin where the plane moves across."""
        return ("gained_spin_ratio", "surface_momentum_ratio") if self.moves == "across" else ()

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the gains of the sphere, the same seen from a plane that shears."""
        u, rim = self.rolling_speeds(motion)
        if self.moves == "across":
            u = motion.velocity[:, 0, 2]
        gained = (u - u[0]) / self.largest_speed
        halfway, end = float(gained[len(u) // 2]), float(gained[-1])
        return self._gains(halfway, end, float(rim[-1]) / self.largest_speed)

    def exact(self) -> Mapping[str, float]:
        """Return the driven oscillation; of a plane that shears what no friction changes.

        Raise RequestError for one that shakes the sphere off, or on which it slides.
        """
        if self.moves == "shear":
            return {"surface_momentum_ratio": 0.0}
        times = np.linspace(0.0, self.scene().duration, 2 * INSTANTS + 1)
        speeds = self._driven_velocity(times) / self.largest_speed
        halfway, end = float(speeds[INSTANTS]), float(speeds[-1])
        return self._gains(halfway, end, -2.5 * end)

    def _gains(self, halfway: float, end: float, rim: float) -> dict[str, float]:
        quantities = {"halfway_gained_velocity_ratio": halfway, "gained_velocity_ratio": end}
        if self.moves == "across":
            return quantities
        return {**quantities, "gained_spin_ratio": rim, "surface_momentum_ratio": end + 0.4 * rim}

    def _driven_velocity(self, times: Floats) -> Floats:
        """Return the velocity of the sphere [m/s] on a plane that oscillates, (M,)."""
        across, overlap = self.moves == "across", self.overlap_at_rest
        factor, k, eta = 1.0, self.slope(overlap), self.eta(overlap)
        if not across:
            factor, k = 3.5, self.tangential_slope(overlap)
            eta *= self.tangential_damping or 0.0
        frequency, decay = math.sqrt(factor * k / self.mass), 0.5 * factor * eta / self.mass
        acceleration = self.acceleration * self.gravity
        y, rate = driven(times, frequency, decay, acceleration, self.drive)
        force, limit = k * y + eta * rate, self.load * (1.0 if across else self.friction or 0.0)
        most = float(force.max() if across else np.abs(force).max())
        if most >= limit:
            raise RequestError(
                f"acceleration = {self.acceleration!r}: must be below "
                f"{self.acceleration * limit / most:.4g} here: the sphere must neither slide nor "
                "leave the plane"
            )
        return (rate + self.largest_speed * np.sin(self.drive * times)) / factor


MOVING_WALL = ContactCase(
    name="moving-wall",
    summary="A plane that oscillates or runs off takes a sphere along: velocity and spin.",
    formula="Shear: as a sphere that slides on a plane at rest, u + 2/5 r omega = 0, at the end "
    "2/7 of its speed. Oscillating with acceleration a cos(w t), y'' + 2 d y' + W^2 y = -a cos(w "
    "t) on the plane: across W^2 = k_n / m, 2 d = eta_n / m; along 7/2 of k_t and eta_t over m, "
    "and 2/7 of the velocity there.",
    parameters=MovingWall,
    quantities=ratios(
        halfway_gained_velocity_ratio="velocity that the sphere gained, over the plane's largest, "
        "halfway",
        gained_velocity_ratio="likewise, at the end",
        gained_spin_ratio="radius times spin, likewise",
        surface_momentum_ratio="of u + 2/5 r omega, over the plane's largest velocity",
    ),
)  # fmt: skip
