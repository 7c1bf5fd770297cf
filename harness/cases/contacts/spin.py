"""A spinning sphere hits a wall or another sphere along the normal: friction from spin alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.impact import impact_scene, relative_velocity
from harness.cases.contacts.parameters import AngularSpeed, ContactSystem, Speed
from harness.model.motion import Motion
from harness.model.scene import Scene


class Spin(ContactSystem):
    """A normal impact with spin about an axis along the surface, in SI units."""

    # fmt: off
    speed: Speed = Field(1.0, description="[m/s] of the approach")
    spin: AngularSpeed = Field(100.0, description="[rad/s] of the sphere, about y")
    partner_spin: float = Field(
        0.0, ge=-1e9, le=1e9, description="[rad/s] of the other sphere, about y")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        if self.partner_spin and self.partner != "sphere":
            raise ValueError(
                f"partner_spin = {self.partner_spin!r}: partner = {self.partner!r} has none "
                "(partner = sphere does)"
            )
        bounds.check_impact(self, "speed", "m/s", self.speed, lambda speed: speed)


class SpinCase(ContactCase[Spin]):
    """Spin left and velocity gained in a normal impact."""

    name = "spin"
    summary = "A spinning sphere hits a wall or a sphere: spin left, velocity gained."
    formula = (
        "Integrated under the code's conventions. Where it slides throughout and the normal force "
        "never pulls, vx' = -mu (1 + e) vn against the surface's motion, omega' = omega - 5/2 mu "
        "(1 + e) vn / r on a wall."
    )
    parameters = Spin
    quantities = (
        Quantity("normal_restitution", "1", "normal speed after over that before"),
        Quantity("spin_ratio", "1", "spin at the end over that at the start"),
        Quantity(
            "gained_speed_ratio", "1",
            "tangential velocity gained over radius times spin at the start",
        ),
    )  # fmt: skip
    laws: ClassVar = tables.FLOOR_FRICTION

    def build(self, p: Spin) -> Scene:
        """Return the impact; samples before and after it."""
        spins = (0.0, p.spin, 0.0), (0.0, p.partner_spin, 0.0)
        return impact_scene(p, (0.0, 0.0, -p.speed), *spins, sampled=False)

    def observe(self, p: Spin, motion: Motion) -> Mapping[str, float]:
        """Return ratios of what is left and gained to what was there before."""
        after = relative_velocity(motion)[-1]
        return {
            "normal_restitution": float(after[2]) / p.speed,
            "spin_ratio": float(motion.angular_velocity[-1, 0, 1]) / p.spin,
            "gained_speed_ratio": float(after[0]) / p.radius / p.spin,
        }


CASE = SpinCase()
