"""The spring of a contact as the routes of the incline need it: overlap and energy of a load."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from harness.cases.incline.parameters import Incline
from harness.parameters.contact import Spring as SpringLaw


@dataclass(frozen=True)
class Linear:
    """Force k delta."""

    case: Incline

    def overlap(self, force: float) -> float:
        """Return F / k."""
        return force / self.case.stiffness

    def change(self, force: float, by: float) -> float:
        """Return dF / k, the same at every force."""
        return by / self.case.stiffness

    def energy_under(self, force: float) -> float:
        """Return F^2 / 2k."""
        return 0.5 * force**2 / self.case.stiffness

    def energy(self, *overlaps: Any) -> Any:
        """Return k delta^2 / 2, summed."""
        first, *others = (overlap**2 for overlap in overlaps)
        return 0.5 * self.case.stiffness * sum(others, start=first)

    def small_motion(self, force: float) -> tuple[float, float]:
        """Return sqrt(k/m) and the contact's own damping ratio."""
        omega = math.sqrt(self.case.stiffness / self.case.mass)
        return omega, self.case.contact.zeta_against_full_mass

    def most_rebound(self) -> float:
        """Return 0: the hops of contacts near critical damping are over when it has settled."""
        return 0.0


@dataclass(frozen=True)
class HertzSpring:
    """Force K delta^(3/2), K as :mod:`harness.parameters.hertz` makes it from the stiffness."""

    case: Incline

    def overlap(self, force: float) -> float:
        """Return (F / K)^(2/3)."""
        return self.case.hertz.rest(force)

    def change(self, force: float, by: float) -> float:
        """Return dF / (3/2 K sqrt(delta))."""
        return by / self.case.hertz.slope(self.overlap(force))

    def energy_under(self, force: float) -> float:
        """Return 2/5 F delta."""
        return 0.4 * force * self.overlap(force)

    def energy(self, *overlaps: Any) -> Any:
        """Return 2/5 K delta^(5/2), summed."""
        return 0.4 * self.case.hertz.coefficient * sum(overlap**2.5 for overlap in overlaps)

    def small_motion(self, force: float) -> tuple[float, float]:
        """Return sqrt(3/2 K sqrt(delta) / m) and its damping ratio."""
        law, overlap, mass = self.case.hertz, self.overlap(force), self.case.mass
        return math.sqrt(law.slope(overlap) / mass), law.damping_ratio(overlap, mass)

    def most_rebound(self) -> float:
        """Return the law's bound: it rebounds more than a linear contact of its damping ratio."""
        return self.case.hertz.most_rebound()


Spring = Linear | HertzSpring
"""A spring under loads [N] and at overlaps [m]: the overlap and the energy [J] that bear a load,
the change of the overlap with it, the energy of overlaps, omega [rad/s] and zeta of small motions
about the rest under it, and a bound on the restitution of the shock, for the hops after it."""


def spring_of(case: Incline, law: SpringLaw) -> Spring:
    """Return the spring of a case under a law."""
    return Linear(case) if law == "linear" else HertzSpring(case)
