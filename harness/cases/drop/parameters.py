"""A grain that meets one fixed sphere: what an engine is qualified with before it is believed."""

from __future__ import annotations

import math
import sys

from pydantic import Field, model_validator

from harness.cases.grain import Grain

LEAST_OVERLAP = 1e6 * sys.float_info.epsilon
"""[d] below which the rounding of a place is a millionth of the overlap or more."""

MOST_DECADES = 290.0
"""Between 1 and a mass [kg], and between that and a stiffness [N/m]: floats have 308."""


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

    @model_validator(mode="after")
    def _is_sound(self) -> Drop:
        mass = 3.0 * math.log10(self.diameter) + math.log10(self.density)
        if max(abs(mass), abs(mass - math.log10(self.stiffness))) > MOST_DECADES:
            raise ValueError(
                f"diameter = {self.diameter:g} m, density = {self.density:g} kg/m3, stiffness = "
                f"{self.stiffness:g} N/m: mass or contact time is beyond floating point"
            )
        if not self.gap > -0.25 * self.diameter:
            raise ValueError(
                f"gap = {self.gap!r} m: must be greater than {-0.25 * self.diameter:.4g} m, a "
                "quarter of the diameter"
            )
        overlap = self.largest_overlap
        if overlap and not LEAST_OVERLAP <= overlap / self.diameter <= 0.5:
            raise ValueError(
                f"the grain would press itself {overlap / self.diameter:.3g} diameters in at "
                f"stiffness = {self.stiffness:g} N/m, diameter = {self.diameter:g} m, speed = "
                f"{math.hypot(self.speed, self.sideways):g} m/s, gravity = {self.gravity:g} m/s2: "
                f"must be from {LEAST_OVERLAP:.2g} to 0.5"
            )
        return self

    @property
    def largest_overlap(self) -> float:
        """Return an upper bound of the overlap [m]: of a linear spring, undamped, head-on."""
        weight = self.mass * self.gravity / self.stiffness
        fall = math.sqrt(2.0 * self.gravity * max(self.gap, 0.0))
        speed = math.hypot(self.speed, self.sideways, fall)
        return weight + math.hypot(weight, speed * math.sqrt(self.mass / self.stiffness))

    @property
    def hertz_speed(self) -> float:
        """Return sqrt(speed^2 + sideways^2 + g d) [m/s], at which a Hertz spring stands for k."""
        falls = math.sqrt(self.gravity * self.diameter)
        return math.hypot(self.speed, self.sideways, falls)

    @property
    def steps(self) -> int:
        """Return the number of steps, a multiple of ``every`` that covers the duration."""
        return self.every * math.ceil(self.duration * self.steps_per_contact / self.every - 1e-9)
