"""Twisting resistance: a sphere spins about the line of contact until it stands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact_base.motion import Array, Motion
from harness.cases.contact_base.parameters import Turning, reduced_shear_modulus
from harness.cases.contact_base.presets import Told
from harness.cases.contact_base.resting import Resting, RestingCase
from harness.cases.contact_base.scales import rest_overlap
from harness.cases.contact_base.scans import Scan
from harness.cases.contact_base.submodels import STICKING, TWISTING, named
from harness.cases.contact_base.undamped import TWISTING_UNDAMPED
from harness.parameters.contact_scene import ZERO, Vector
from harness.theory.rolling import twisting_deceleration

TWISTING_BESIDE = named(
    {
        "twisting sds, linear_history, tied": {
            **STICKING,
            "twisting": "sds",
            "twisting_stiffness": 2e1 / 7.0,
            "twisting_damping": 0.0,
            "twisting_friction": 1e-4,
        }
    }
)
"""A twisting spring without a dashpot, of k_t R*^2 for the sphere of 1 cm on a plane."""


class Twist(Resting):
    """A sphere on a floor or on a frozen sphere that spins about the vertical; in SI units."""

    spin: Turning = Field(20.0, description="[rad/s] at the start")
    carried_by = ("wall", "frozen")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        super().check()
        name = "friction" if self.twisting_friction is None else "twisting_friction"
        if not getattr(self, name):
            raise ValueError(
                f"{name} = {getattr(self, name)!r}: must be greater than 0 to slow down"
            )

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return the spin about the line of contact."""
        return ZERO, (0.0, 0.0, self.spin)


class TwistCase(RestingCase[Twist]):
    """A sphere that spins about the line of contact is slowed down by a constant torque."""

    name = "twist"
    submodels = TWISTING
    beside = (*TWISTING_BESIDE, *TWISTING_UNDAMPED)
    sets: ClassVar[Told] = {"spins": {"friction": 0.3, **TWISTING[0].law}}
    systems: ClassVar[Told] = {
        "wall, spins": {"partner": "wall"},
        "wall, stands": {"partner": "wall", "spin": 2.0},
        "frozen sphere, spins": {"partner": "frozen"},
    }
    scan = Scan(
        "spin_ratio",
        "spin",
        (2.0, 5.0, 10.0, 15.0, 20.0, 30.0),
        (
            ("twisting sds, linear_history, tied", "twisting sds, linear_history, elastic"),
            ("twisting marshall, mindlin",),
        ),
    )

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

    def axes(self, parameters: Twist) -> tuple[str, str]:
        """Return what is drawn: the spin over the time."""
        return "time (ms)", "spin (rad/s)"

    def curves(self, parameters: Twist, motion: Motion) -> Mapping[str, tuple[Array, Array]]:
        """Return the spin about the vertical."""
        return {"": (1e3 * motion.time, motion.omega[:, 0, 2])}

    def closed_forms(self, parameters: Twist) -> Mapping[str, float]:
        """Return the deceleration where it slips from before halfway to the end.

        The spring takes the torque of slipping after t with spin t - slipping t^2 / 2 of turning at
        least, as its own torque is smaller before; a dashpot makes it sooner.
        """
        half, slipping = 0.5 * self.scene(parameters).duration, self._slipping(parameters)
        turned = half * (parameters.spin - 0.5 * slipping * half)
        loaded = (
            slipping * 0.4 * parameters.mass * parameters.radius**2 / self._stiffness(parameters)
        )
        lasts = 2.0 * half * slipping < parameters.spin
        return {"deceleration_ratio": 1.0} if lasts and loaded < turned else {}

    def _stiffness(self, parameters: Twist) -> float:
        """Return the stiffness of the twisting spring [N m]; Marshall's is k_t a^2 / 2."""
        if parameters.twisting_stiffness is not None:
            return parameters.twisting_stiffness
        squared = self._contact_radius(parameters) ** 2
        k = parameters.tangential_stiffness
        if k is None:
            k = 8.0 * reduced_shear_modulus(parameters) * math.sqrt(squared)
        return 0.5 * k * squared

    def _contact_radius(self, parameters: Twist) -> float:
        overlap = rest_overlap(parameters, parameters.mass * parameters.gravity)
        return math.sqrt(parameters.reduced_radius * overlap)

    def _slipping(self, parameters: Twist) -> float:
        """Return 5/2 mu_t g / r^2 [rad/s2]."""
        length = parameters.twisting_friction
        if length is None:
            length = 2.0 / 3.0 * self._contact_radius(parameters) * (parameters.friction or 0.0)
        return twisting_deceleration(length, parameters.radius, parameters.gravity)


CASE = TwistCase()
