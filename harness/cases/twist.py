"""A sphere spins about the line of contact, is stopped by twisting resistance, and swings back.

A spin that the spring stops before the torque reaches its limit swings from the start: a damped
oscillation of frequency sqrt(k / I), I = 2/5 m r^2. A faster one slips first, at a constant rate.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact.contact_case import Resting, RestingCase
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import Turning, rest_overlap, twisting_limit, twisting_spring
from harness.cases.contact.submodels import TWISTING, TWISTING_BESIDE, TWISTING_UNDAMPED, Told
from harness.parameters.scene import ZERO, Vector
from harness.theory.contact import twisting_deceleration, twisting_spin


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
    other_submodels = (*TWISTING_BESIDE, *TWISTING_UNDAMPED)
    lasts = True
    every_level = ("wall, stands", "wall, swings")
    sets: ClassVar[Told] = {"spins": {"friction": 0.3, **TWISTING[0].law}}
    systems: ClassVar[Told] = {
        "wall, spins": {"partner": "wall"},
        "wall, stands": {"partner": "wall", "spin": 0.5, "duration": 120.0},
        "wall, swings": {"partner": "wall", "spin": 5e-3, "duration": 30.0},
        "frozen sphere, spins": {"partner": "frozen"},
    }

    def observed(self, parameters: Twist, motion: Motion) -> Mapping[str, float]:
        """Return the spin halfway and at the end, and what it lost in between."""
        spin = motion.angular_velocity[:, 0, 2]
        half = len(spin) // 2
        lost = float(spin[half] - spin[-1]) / float(motion.time[-1] - motion.time[half])
        return {
            "halfway_spin_ratio": float(spin[half]) / parameters.spin,
            "spin_ratio": float(spin[-1]) / parameters.spin,
            "deceleration_ratio": lost / self._slipping(parameters),
        }

    def closed_forms(self, parameters: Twist) -> Mapping[str, float]:
        """Return the spin that the contact leaves, and what it lost.

        Of springs whose load and overlap are known, with less than critical damping.
        """
        load = parameters.mass * parameters.gravity
        k, c = twisting_spring(parameters, rest_overlap(parameters, load))
        swings = c * c < 4.0 * k * self._inertia(parameters)
        if parameters.normal not in ("hooke", "hertz") or not swings:
            return {}
        end = self.scene(parameters).duration
        spins = [self._spin_after(parameters, time) for time in (0.5 * end, end)]
        lost = (spins[0] - spins[1]) / (0.5 * end)
        return {
            "halfway_spin_ratio": spins[0] / parameters.spin,
            "spin_ratio": spins[1] / parameters.spin,
            "deceleration_ratio": lost / self._slipping(parameters),
        }

    def _spin_after(self, parameters: Twist, time: float) -> float:
        """Return the spin after a time [rad/s]; its load is the weight, at rest."""
        load = parameters.mass * parameters.gravity
        overlap = rest_overlap(parameters, load)
        limit = twisting_limit(parameters, overlap) * load
        spring = twisting_spring(parameters, overlap)
        return twisting_spin(time, parameters.spin, self._inertia(parameters), spring, limit)

    def _inertia(self, parameters: Twist) -> float:
        return 0.4 * parameters.mass * parameters.radius**2

    def _slipping(self, parameters: Twist) -> float:
        """Return 5/2 mu_t g / r^2 [rad/s2]."""
        overlap = rest_overlap(parameters, parameters.mass * parameters.gravity)
        length = twisting_limit(parameters, overlap)
        return twisting_deceleration(length, parameters.radius, parameters.gravity)


CASE = TwistCase()
