"""Twisting resistance: a sphere spins about the line of contact until it stands."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from harness.cases.contact_base.contact_case import ContactCase
from harness.cases.contact_base.motion import Array, Motion
from harness.cases.contact_base.parameters import ContactSystem
from harness.cases.contact_base.resting import half_period, rest_overlap, resting
from harness.cases.contact_base.scans import Scan
from harness.cases.contact_base.submodels import TWISTING, TWISTING_BESIDE
from harness.observables.declared import Observable
from harness.parameters.contact_scene import ZERO, ContactScene
from harness.theory.rolling import twisting_deceleration


class Twist(ContactSystem):
    """A sphere on a floor or on a frozen sphere that spins about the vertical; in SI units."""

    spin: float = Field(20.0, gt=0.0, description="[rad/s] at the start")
    gravity: float = Field(9.81, gt=0.0, description="[m/s2] downward")
    duration: float = Field(20.0, gt=0.0, description="[-] in half periods of the contact")


class TwistCase(ContactCase[Twist]):
    """The twisting submodel alone: nothing slides or rolls."""

    name = "twist"
    summary = "A sphere that spins about the line of contact is slowed down by a constant torque."
    parameters = Twist
    quantities = (
        Observable("halfway_spin_ratio", "1", "", "spin over that of the start, halfway"),
        Observable("spin_ratio", "1", "", "spin over that of the start, at the end"),
        Observable("deceleration_ratio", "1", "", "mean of the second half, over 5/2 mu g / r^2"),
    )
    submodels = TWISTING
    beside = TWISTING_BESIDE
    systems: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "wall, spins": {"partner": "wall"},
        "wall, stands": {"partner": "wall", "spin": 2.0},
        "frozen sphere, spins": {"partner": "frozen"},
    }
    scan = Scan(
        "spin_ratio",
        "spin",
        (2.0, 5.0, 10.0, 15.0, 20.0, 30.0),
        (("twisting sds, linear_history, tied",), ("twisting marshall, mindlin",)),
    )
    formula: ClassVar[str] = (
        "The torque is at most mu_t F_n, for Marshall's submodel with mu_t = 2/3 a mu: while it "
        "slips the spin falls by 5/2 mu_t g / r^2; the rest is integrated."
    )

    @property
    def presets(self) -> Mapping[str, Twist]:
        """Return a sphere that spins on through the run."""
        return {"spins": Twist(friction=0.3, **TWISTING[0].law)}

    def scene(self, parameters: Twist) -> ContactScene:
        """Return the sphere at rest but for its spin."""
        period = half_period(parameters, parameters.mass * parameters.gravity)
        gravity = (0.0, 0.0, -parameters.gravity)
        start = ZERO, (0.0, 0.0, parameters.spin)
        return resting(parameters, gravity, start, parameters.duration * period)

    def observed(self, parameters: Twist, motion: Motion) -> Mapping[str, float]:
        """Return the spin halfway and at the end, and what it lost in between."""
        spin = motion.omega[:, 0, 2]
        half = len(spin) // 2
        lost = float(spin[half] - spin[-1]) / float(motion.time[-1] - motion.time[half])
        return {
            "halfway_spin_ratio": float(spin[half]) / parameters.spin,
            "spin_ratio": float(spin[-1]) / parameters.spin,
            "deceleration_ratio": lost / self._slipping(parameters),
        }

    def axes(self, parameters: Twist) -> tuple[str, str]:  # noqa: ARG002
        """Return what is drawn: the spin over the time."""
        return "time (ms)", "spin (rad/s)"

    def curves(self, parameters: Twist, motion: Motion) -> Mapping[str, tuple[Array, Array]]:  # noqa: ARG002
        """Return the spin about the vertical."""
        return {"": (1e3 * motion.time, motion.omega[:, 0, 2])}

    def closed_forms(self, parameters: Twist) -> Mapping[str, float]:
        """Return the deceleration where the spin lasts beyond the run by what is lost in it."""
        scene = self.scene(parameters)
        lost = self._slipping(parameters) * scene.duration
        return {"deceleration_ratio": 1.0} if lost < parameters.spin else {}

    def _slipping(self, parameters: Twist) -> float:
        """Return 5/2 mu_t g / r^2 [rad/s2]."""
        length = parameters.twisting_friction
        if length is None:
            overlap = rest_overlap(parameters, parameters.mass * parameters.gravity)
            radius: float = (parameters.reduced_radius * overlap) ** 0.5
            length = 2.0 / 3.0 * radius * (parameters.friction or 0.0)
        return twisting_deceleration(length, parameters.radius, parameters.gravity)


CASE = TwistCase()
