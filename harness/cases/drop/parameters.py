"""A grain that meets one fixed sphere: what an engine is qualified with before it is believed."""

from __future__ import annotations

import math

from pydantic import Field

from harness.parameters.base import Parameters
from harness.parameters.contact import SOURCE, NamedContact
from harness.parameters.material import UNIT_MASS_DENSITY


class Drop(Parameters):
    """One run of a grain above a fixed sphere of its size, in SI units.

    The sphere's centre is the origin, the grain starts at (0, diameter + gap) and moves
    down with ``speed`` and along x with ``sideways``; gravity points down. Head-on
    collision, free fall, static contact and oblique contact are cases of it.
    """

    contact: NamedContact = Field(SOURCE, description="[-] dissipation of the contact")
    stiffness: float = Field(1e6, gt=0.0, description="[N/m] normal stiffness")
    steps_per_contact: float = Field(
        2000.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)"
    )
    diameter: float = Field(1.0, gt=0.0, description="[m] diameter of both spheres")
    density: float = Field(UNIT_MASS_DENSITY, gt=0.0, description="[kg/m3] density of the grain")
    gravity: float = Field(0.0, ge=0.0, description="[m/s2] acceleration of gravity, downward")
    gap: float = Field(0.0, gt=-0.25, le=10.0, description="[m] from the sphere; negative: pressed")
    speed: float = Field(0.0, description="[m/s] downward, at the start")
    sideways: float = Field(0.0, description="[m/s] along x, at the start")
    duration: float = Field(
        3.0, gt=0.0, le=1e4, description="[-] of the run, in contact times pi sqrt(m/k)"
    )
    every: int = Field(1, ge=1, description="[-] steps between two samples of the path")

    @property
    def mass(self) -> float:
        """Return the grain's mass [kg]."""
        return self.density * math.pi / 6.0 * self.diameter**3

    @property
    def hertz_speed(self) -> float:
        """Return sqrt(speed^2 + sideways^2 + g d) [m/s], at which a Hertz spring stands for k."""
        falls = math.sqrt(self.gravity * self.diameter)
        return math.hypot(self.speed, self.sideways, falls)

    @property
    def contact_time(self) -> float:
        """Return pi sqrt(m / k) [s]."""
        return math.pi * math.sqrt(self.mass / self.stiffness)

    @property
    def step(self) -> float:
        """Return the time step [s]."""
        return self.contact_time / self.steps_per_contact

    @property
    def steps(self) -> int:
        """Return the number of steps, a multiple of ``every`` that covers the duration."""
        return self.every * math.ceil(self.duration * self.steps_per_contact / self.every - 1e-9)
