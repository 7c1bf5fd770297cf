"""Rolling resistance on a floor: a constant torque slows the sphere down."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Self

from pydantic import Field, model_validator

from harness.cases.contact_base.contact_case import ContactCase
from harness.cases.contact_base.motion import Array, Motion
from harness.cases.contact_base.parameters import ContactSystem, Duration, Gravity, Speed
from harness.cases.contact_base.resting import half_period, resting
from harness.cases.contact_base.scales import meets, rests
from harness.cases.contact_base.scans import Scan
from harness.cases.contact_base.submodels import ROLLING, ROLLING_BESIDE
from harness.observables.declared import Observable
from harness.parameters.contact_scene import ContactScene


class RollingResistance(ContactSystem):
    """A sphere that rolls on a floor, pressed in by its weight; in SI units."""

    speed: Speed = Field(0.02, description="[m/s] of rolling, at the start")
    gravity: Gravity = Field(9.81, description="[m/s2] downward")
    duration: Duration = Field(20.0, description="[-] in half periods of the contact")

    @model_validator(mode="after")
    def _scaled(self) -> Self:
        meets(self, "wall")
        rests(self, self.gravity)
        return self


class RollingResistanceCase(ContactCase[RollingResistance]):
    """The rolling submodel, beside friction that keeps the sphere from slipping."""

    name = "rolling-resistance"
    summary = "A rolling sphere is slowed down by rolling resistance, and stands in the end."
    parameters = RollingResistance
    quantities = (
        Observable("halfway_speed_ratio", "1", "", "speed over that of the start, halfway"),
        Observable("speed_ratio", "1", "", "speed over that of the start, at the end"),
        Observable("spin_ratio", "1", "", "radius times spin over the speed of the start"),
    )
    submodels = ROLLING
    beside = ROLLING_BESIDE
    systems: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "wall, rolls": {},
        "wall, stands": {"speed": 2e-3},
    }
    scan = Scan(
        "speed_ratio",
        "speed",
        (0.002, 0.005, 0.01, 0.02, 0.03),
        (("rolling sds, linear_history, tied",), ("rolling sds, mindlin/force, elastic",)),
    )
    formula: ClassVar[str] = (
        "The torque is at most mu_r R* F_n, R* = r on a floor: rolling slows down by 5/7 mu_r g, "
        "with what the springs make of it as it begins and when it stands: integrated."
    )

    @property
    def presets(self) -> Mapping[str, RollingResistance]:
        """Return a sphere that rolls on through the run."""
        law = ROLLING[0].law
        return {"rolls": RollingResistance(friction=0.3, **law)}

    def scene(self, parameters: RollingResistance) -> ContactScene:
        """Return the sphere at rest along the vertical, rolling without slip."""
        u = parameters.speed
        start = (u, 0.0, 0.0), (0.0, u / parameters.radius, 0.0)
        period = half_period(parameters, parameters.mass * parameters.gravity)
        gravity = (0.0, 0.0, -parameters.gravity)
        return resting(parameters, gravity, start, parameters.duration * period)

    def observed(self, parameters: RollingResistance, motion: Motion) -> Mapping[str, float]:
        """Return the speed halfway, speed and spin at the end."""
        u, spin = motion.velocity[:, 0, 0], parameters.radius * motion.omega[:, 0, 1]
        return {
            "halfway_speed_ratio": float(u[len(u) // 2]) / parameters.speed,
            "speed_ratio": float(u[-1]) / parameters.speed,
            "spin_ratio": float(spin[-1]) / parameters.speed,
        }

    def axes(self, parameters: RollingResistance) -> tuple[str, str]:  # noqa: ARG002
        """Return what is drawn: both speeds."""
        return "time (ms)", "velocity (m/s)"

    def curves(
        self, parameters: RollingResistance, motion: Motion
    ) -> Mapping[str, tuple[Array, Array]]:
        """Return the speed, and radius times spin."""
        u, spin = motion.velocity[:, 0, 0], parameters.radius * motion.omega[:, 0, 1]
        named = {"speed": u, "radius times spin": spin}
        return {name: (1e3 * motion.time, value) for name, value in named.items()}


CASE = RollingResistanceCase()
