"""A grain that meets one fixed sphere: what an engine is qualified with before it is believed."""

from __future__ import annotations

import math

from pydantic import Field

from harness.cases.grain import Grain


class Drop(Grain):
    """One run of a grain above a fixed sphere of its size, in SI units.

    The sphere's centre is the origin, the grain starts at (0, diameter + gap) and moves
    down with ``speed`` and along x with ``sideways``; gravity points down. Head-on
    collision, free fall, static contact and oblique contact are cases of it.
    """

    steps_per_contact: float = Field(
        2000.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)"
    )
    gravity: float = Field(0.0, ge=0.0, description="[m/s2] acceleration of gravity, downward")
    gap: float = Field(0.0, gt=-0.25, le=10.0, description="[m] from the sphere; negative: pressed")
    speed: float = Field(0.0, description="[m/s] downward, at the start")
    sideways: float = Field(0.0, description="[m/s] along x, at the start")
    duration: float = Field(
        3.0, gt=0.0, le=1e4, description="[-] of the run, in contact times pi sqrt(m/k)"
    )
    every: int = Field(1, ge=1, description="[-] steps between two samples of the path")

    @property
    def hertz_speed(self) -> float:
        """Return sqrt(speed^2 + sideways^2 + g d) [m/s], at which a Hertz spring stands for k."""
        falls = math.sqrt(self.gravity * self.diameter)
        return math.hypot(self.speed, self.sideways, falls)

    @property
    def steps(self) -> int:
        """Return the number of steps, a multiple of ``every`` that covers the duration."""
        return self.every * math.ceil(self.duration * self.steps_per_contact / self.every - 1e-9)
