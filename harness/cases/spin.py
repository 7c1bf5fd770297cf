"""A spinning sphere meets a wall or another sphere along the normal: friction from spin alone."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact.contact_case import ContactCase, Friction
from harness.cases.contact.impact import impact, relative_velocity
from harness.cases.contact.limits import Scan
from harness.cases.contact.motion import Array, Motion
from harness.cases.contact.parameters import ContactSystem, Speed, Turning, check_impact
from harness.cases.contact.report import OverAngle
from harness.cases.contact.submodels import ROLLING_ON, SLIDING, SPIN, Told
from harness.parameters.scene import ContactScene, Vector


def _spin(parameters: Spin, angle: float) -> float:
    """Return the spin [rad/s] with which the surface meets what it hits at an angle [deg]."""
    return parameters.speed * math.tan(math.radians(angle)) / parameters.radius


def _angle(parameters: Spin) -> float:
    return math.degrees(math.atan(parameters.radius * parameters.spin / parameters.speed))


def _sent(parameters: Spin) -> tuple[Vector, Vector]:
    return (0.0, 0.0, -parameters.speed), (0.0, parameters.spin, 0.0)


def _ratio(parameters: Spin, rim_ratio: Array) -> Array:
    """Return the spin ratio of a sphere, the other without spin.

    An impulse J changes the velocity at the contact by 7/2 J / m*, and r omega by 5/2 J / m.
    """
    return 1.0 - 5.0 / 7.0 * parameters.reduced_mass / parameters.mass * (1.0 - rim_ratio)


OVER_ANGLE = OverAngle(
    quantity="spin_ratio",
    parameter="spin",
    title="Spin ratio over the angle of the velocity at the contact",
    y="spin after over that before",
    value=_spin,
    angle=_angle,
    sent=_sent,
    ratio=_ratio,
)


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
    drawn_quantity = "spin_ratio"
    over_angle = OVER_ANGLE
    scan = Scan("spin_ratio", "spin", (25.0, 50.0, 100.0, 150.0, 200.0, 300.0, 400.0))

    def scene(self, parameters: Spin) -> ContactScene:
        """Return the impact; samples before and after it."""
        spins = (0.0, parameters.spin, 0.0), (0.0, parameters.partner_spin, 0.0)
        return impact(parameters, (0.0, 0.0, -parameters.speed), *spins, finely=False)

    def observed(self, parameters: Spin, motion: Motion) -> Mapping[str, float]:
        """Return ratios of what is left and gained to what was there before."""
        after = relative_velocity(motion)[-1]
        return {
            "normal_restitution": float(after[2]) / parameters.speed,
            "spin_ratio": float(motion.omega[-1, 0, 1]) / parameters.spin,
            "gained_speed_ratio": float(after[0]) / parameters.radius / parameters.spin,
        }


CASE = SpinCase()
