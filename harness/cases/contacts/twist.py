"""A sphere spins about the line of contact, is stopped by twisting resistance, and swings back.

A spin that the spring stops before the torque reaches its limit swings from the start: a damped
oscillation of frequency sqrt(k / I), I = 2/5 m r^2. A faster one slips first, at a constant rate.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import tables
from harness.cases.contacts.parameters import AngularSpeed
from harness.cases.contacts.resting import Resting, RestingCase
from harness.model.base import ZERO, Vector
from harness.model.motion import Motion
from harness.theory.contact import twisting_deceleration, twisting_spin


class Twist(Resting):
    """A sphere on a floor or on a frozen sphere that spins about the vertical; in SI units."""

    partners: ClassVar[tuple[str, ...]] = ("wall", "frozen")

    spin: AngularSpeed = Field(20.0, description="[rad/s] at the start")

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

    @property
    def slipping(self) -> float:
        """Return the deceleration 5/2 mu_t g / r^2 while it slips [rad/s2]."""
        length = self.twisting_limit(self.overlap_at_rest)
        return twisting_deceleration(length, self.radius, self.gravity)


class TwistCase(RestingCase[Twist]):
    """Spin and deceleration of a sphere that twisting resistance slows down."""

    name = "twist"
    summary = "A sphere that spins about the line of contact is slowed down by a constant torque."
    formula = (
        "The torque is at most mu_t F_n, for Marshall's submodel with mu_t = 2/3 a mu: while it "
        "slips the spin falls by 5/2 mu_t g / r^2. Below that limit it swings, a damped "
        "oscillation of frequency sqrt(k / I), I = 2/5 m r^2; it sticks again at the spin c mu_t m "
        "g / (I k)."
    )
    parameters = Twist
    quantities = (
        Quantity("halfway_spin_ratio", "1", "spin over that of the start, halfway"),
        Quantity("spin_ratio", "1", "spin at the end over that at the start"),
        Quantity("deceleration_ratio", "1", "mean of the second half, over 5/2 mu_t g / r^2"),
    )
    laws: ClassVar = tables.laws("twisting", "further_twisting", "undamped_twisting")
    systems: ClassVar = {
        "wall, spins": {"partner": "wall"},
        "wall, stands": {"partner": "wall", "spin": 0.5, "duration": 120.0},
        "wall, swings": {"partner": "wall", "spin": 5e-3, "duration": 30.0},
        "frozen sphere, spins": {"partner": "frozen"},
    }
    always = ("wall, stands", "wall, swings")

    def observe(self, p: Twist, motion: Motion) -> Mapping[str, float]:
        """Return the spin halfway and at the end, and its loss in between."""
        spin = motion.angular_velocity[:, 0, 2]
        half = len(spin) // 2
        seconds = float(motion.time[-1] - motion.time[half])
        return _ratios(p, float(spin[half]), float(spin[-1]), seconds)

    def exact(self, p: Twist) -> Mapping[str, float]:
        """Return the spin that the contact leaves, and its loss.

        Of springs whose load and overlap are known, with less than critical damping.
        """
        inertia = 0.4 * p.mass * p.radius**2
        spring = k, c = p.twisting_spring(p.overlap_at_rest)
        if p.normal not in ("hooke", "hertz") or c * c >= 4.0 * k * inertia:
            return {}
        end, limit = self.scene(p).duration, p.twisting_limit(p.overlap_at_rest) * p.load
        halfway, last = (
            twisting_spin(time, p.spin, inertia, spring, limit) for time in (0.5 * end, end)
        )
        return _ratios(p, halfway, last, 0.5 * end)


def _ratios(p: Twist, halfway: float, last: float, seconds: float) -> dict[str, float]:
    return {
        "halfway_spin_ratio": halfway / p.spin,
        "spin_ratio": last / p.spin,
        "deceleration_ratio": (halfway - last) / seconds / p.slipping,
    }


CASE = TwistCase()
