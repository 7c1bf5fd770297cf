"""A spinning sphere meets a wall or another sphere along the normal: friction from spin alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact.contact_case import ContactCase, Friction
from harness.cases.contact.impact import impact, relative_velocity
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import ContactSystem, Speed, Turning, check_impact
from harness.cases.contact.submodels import ROLLING_ON, SLIDING, SPIN, Told
from harness.parameters.scene import ContactScene


class Spin(ContactSystem):
    """A normal impact with spin about an axis along the surface, in SI units."""

    speed: Speed = Field(1.0, description="[m/s] of the approach")
    spin: Turning = Field(100.0, description="[rad/s] of the sphere, about y")
    partner_spin: float = Field(
        0.0, ge=-1e9, le=1e9, description="[rad/s] of the sphere that it meets, about y"
    )

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        if self.partner_spin and self.partner != "sphere":
            raise ValueError(
                f"partner_spin = {self.partner_spin!r}: partner = {self.partner!r} has none "
                "(partner = sphere does)"
            )
        check_impact(self, "speed", "m/s", self.speed, lambda speed: speed)


class SpinCase(Friction, ContactCase[Spin]):
    """A spinning sphere meets a wall or a sphere: spin left, velocity gained."""

    name = "spin"
    other_submodels = (*Friction.other_submodels, *ROLLING_ON)
    sets: ClassVar[Told] = {"usual": SLIDING, **SPIN}

    def scene(self, parameters: Spin) -> ContactScene:
        """Return the impact; samples before and after it."""
        spins = (0.0, parameters.spin, 0.0), (0.0, parameters.partner_spin, 0.0)
        return impact(parameters, (0.0, 0.0, -parameters.speed), *spins, finely=False)

    def observed(self, parameters: Spin, motion: Motion) -> Mapping[str, float]:
        """Return ratios of what is left and gained to what was there before."""
        after = relative_velocity(motion)[-1]
        return {
            "normal_restitution": float(after[2]) / parameters.speed,
            "spin_ratio": float(motion.angular_velocity[-1, 0, 1]) / parameters.spin,
            "gained_speed_ratio": float(after[0]) / parameters.radius / parameters.spin,
        }


CASE = SpinCase()
