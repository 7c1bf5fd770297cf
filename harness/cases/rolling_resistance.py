"""A sphere rolls on a floor and is slowed down by the constant torque of a rolling resistance."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact.contact_case import Resting, RestingCase, speed_ratios
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import Speed
from harness.cases.contact.submodels import ROLLING, ROLLING_BESIDE, ROLLING_UNDAMPED, Told
from harness.parameters.scene import Vector


class RollingResistance(Resting):
    """A sphere that rolls on a floor, pressed in by its weight; in SI units."""

    speed: Speed = Field(0.02, description="[m/s] of rolling, at the start")

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return rolling without slip."""
        return (self.speed, 0.0, 0.0), (0.0, self.speed / self.radius, 0.0)


class RollingResistanceCase(RestingCase[RollingResistance]):
    """A rolling sphere is slowed down by rolling resistance, and stands in the end."""

    name = "rolling-resistance"
    submodels = ROLLING
    other_submodels = (*ROLLING_BESIDE, *ROLLING_UNDAMPED)
    every_level = ("wall, stands",)
    sets: ClassVar[Told] = {"rolls": {"friction": 0.3, **ROLLING[0].law}}
    systems: ClassVar[Told] = {"wall, rolls": {}, "wall, stands": {"speed": 2e-3}}

    def observed(self, parameters: RollingResistance, motion: Motion) -> Mapping[str, float]:
        """Return the speed halfway, speed and spin at the end."""
        return speed_ratios("halfway_speed_ratio", parameters, motion, parameters.speed)


CASE = RollingResistanceCase()
