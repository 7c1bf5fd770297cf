"""A sphere rolls on a floor and is slowed down by the constant torque of a rolling resistance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import tables
from harness.cases.contacts.parameters import Speed
from harness.cases.contacts.resting import Resting, RestingCase, speed_ratios
from harness.model.base import Vector
from harness.model.motion import Motion
from harness.theory.contact import against_constant_torque


class RollingResistance(Resting):
    """A sphere that rolls on a floor, pressed in by its weight; in SI units."""

    speed: Speed = Field(0.02, description="[m/s] of rolling, at the start")

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return rolling without slip."""
        return (self.speed, 0.0, 0.0), (0.0, self.speed / self.radius, 0.0)


class RollingResistanceCase(RestingCase[RollingResistance]):
    """Speed and spin of a sphere that rolling resistance stops."""

    name = "rolling-resistance"
    summary = "A rolling sphere is slowed down by rolling resistance, and stands in the end."
    formula = (
        "The torque is at most mu_r R* F_n, R* = r on a floor: rolling slows down by 5/7 mu_r g, "
        "with what the springs make of it as it begins and when it stands: integrated. A constant "
        "torque (model A of Ai and others, 2011) acts at any rate; at rest its sign changes from "
        "step to step."
    )
    parameters = RollingResistance
    quantities = (
        Quantity("halfway_speed_ratio", "1", "speed over that of the start, halfway"),
        Quantity("speed_ratio", "1", "speed over that of the start, at the end"),
        Quantity(
            "rim_speed_ratio", "1", "radius times spin at the end over the speed at the start"
        ),
    )
    laws: ClassVar = tables.laws(
        "rolling", "further_rolling", "undamped_rolling", "constant_rolling"
    )
    systems: ClassVar = {"wall, rolls": {}, "wall, stands": {"speed": 2e-3}}
    always = ("wall, stands",)

    def observe(self, p: RollingResistance, motion: Motion) -> Mapping[str, float]:
        """Return the speed halfway, speed and rim speed at the end."""
        return speed_ratios("halfway_speed_ratio", p, motion, p.speed)

    def exact(self, p: RollingResistance) -> Mapping[str, float]:
        """Return the speeds under a constant torque and a spring, while it rolls."""
        spring, duration = p.tangential_slope(p.overlap_at_rest), self.scene(p).duration
        if p.rolling != "constant" or p.tangential_damping or not spring:
            return {}
        limits = (p.friction or 0.0) * p.load, (p.rolling_friction or 0.0) * p.load
        half, end = (
            against_constant_torque(time, p.speed, 0.0, p.mass, spring, limits)
            for time in (0.5 * duration, duration)
        )
        if half is None or end is None:
            return {}
        speeds = {"halfway_speed_ratio": half[0], "speed_ratio": end[0], "rim_speed_ratio": end[1]}
        return {name: value / p.speed for name, value in speeds.items()}


CASE = RollingResistanceCase()
