"""The normal impact of a spinning sphere: what friction makes of the spin."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from harness.cases.contact_base.contact_case import ContactCase, Friction
from harness.cases.contact_base.further import ROLLING_ON
from harness.cases.contact_base.impact import impact, relative_velocity
from harness.cases.contact_base.motion import Motion
from harness.cases.contact_base.parameters import ContactSystem, Speed, Turning
from harness.cases.contact_base.presets import SLIDING, SPIN, Told
from harness.cases.contact_base.scales import met
from harness.cases.contact_base.scans import Scan
from harness.parameters.contact_scene import ContactScene
from harness.report.sections import Plot

if TYPE_CHECKING:
    from harness.cases.contact_base.evidence import Tried


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
        met(self, "speed", "m/s", self.speed, lambda speed: speed)


class SpinCase(Friction, ContactCase[Spin]):
    """A spinning sphere meets a wall or a sphere: spin left, velocity gained."""

    name = "spin"
    beside = (*Friction.beside, *ROLLING_ON)
    sets: ClassVar[Told] = {"usual": SLIDING, **SPIN}
    shown = "spin_ratio"
    scan = Scan("spin_ratio", "spin", (25.0, 50.0, 100.0, 150.0, 200.0, 300.0, 400.0))

    def plot(self, one: Tried, who: str) -> Plot:
        """Return the spin that is left over the angle of the velocity at the contact."""
        from harness.cases.contact_base.curves import ratio_plot
        from harness.cases.spin.figures import OVER_ANGLE

        return ratio_plot(self, one, who, OVER_ANGLE)

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
