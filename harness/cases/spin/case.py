"""The normal impact of a spinning sphere: what friction makes of the spin."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact_base.contact_case import ContactCase
from harness.cases.contact_base.impact import impact, relative_velocity
from harness.cases.contact_base.motion import Motion
from harness.cases.contact_base.parameters import ContactSystem
from harness.cases.contact_base.presets import SPIN
from harness.cases.contact_base.submodels import OLD_TANGENTIAL, TANGENTIAL, TANGENTIAL_BESIDE
from harness.observables.declared import Observable
from harness.parameters.contact_scene import ContactScene


class Spin(ContactSystem):
    """A normal impact with spin about an axis along the surface, in SI units."""

    speed: float = Field(1.0, gt=0.0, description="[m/s] of the approach")
    spin: float = Field(100.0, gt=0.0, description="[rad/s] of the sphere, about y")


class SpinCase(ContactCase[Spin]):
    """Tangential force from spin: no tangential velocity of the centre before."""

    name = "spin"
    summary = "A spinning sphere meets a wall or a sphere: spin left, velocity gained."
    parameters = Spin
    quantities = (
        Observable("normal_restitution", "1", "", "normal speed after over that before"),
        Observable("spin_ratio", "1", "", "spin after over that before"),
        Observable("velocity_ratio", "1", "", "tangential velocity gained over radius times spin"),
    )
    submodels = (*TANGENTIAL, *OLD_TANGENTIAL)
    beside = TANGENTIAL_BESIDE
    formula: ClassVar[str] = (
        "Sliding throughout: vx' = -mu (1 + e) vn against the surface's motion, omega' = omega - "
        "5/2 mu (1 + e) vn / r; else integrated."
    )

    @property
    def presets(self) -> Mapping[str, Spin]:
        """Return a linear contact that slides and sticks, and those of the literature."""
        usual = Spin(tangential="linear_history", friction=0.3)
        return {"usual": usual, **{name: Spin(**told) for name, told in SPIN.items()}}

    def scene(self, parameters: Spin) -> ContactScene:
        """Return the impact; samples before and after it."""
        spin = (0.0, parameters.spin, 0.0)
        return impact(parameters, (0.0, 0.0, -parameters.speed), spin, finely=False)

    def observed(self, parameters: Spin, motion: Motion) -> Mapping[str, float]:
        """Return ratios of what is left and gained to what was there before."""
        after = relative_velocity(motion)[-1]
        return {
            "normal_restitution": float(after[2]) / parameters.speed,
            "spin_ratio": float(motion.omega[-1, 0, 1]) / parameters.spin,
            "velocity_ratio": float(after[0]) / parameters.radius / parameters.spin,
        }


CASE = SpinCase()
