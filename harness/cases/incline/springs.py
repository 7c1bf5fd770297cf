"""The spring of a contact as the routes of the incline need it: overlap and energy of a load."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from harness.cases.incline.parameters import Incline
from harness.parameters.contact import Spring as SpringLaw
from harness.parameters.hertz import Hertz, hertz


class Spring(Protocol):
    """A spring under loads [N] and at overlaps [m]."""

    def overlap(self, force: float) -> float:
        """Return the overlap [m] that bears a force."""

    def change(self, force: float, by: float) -> float:
        """Return the change of the overlap [m] when the force changes by a little."""

    def energy_under(self, force: float) -> float:
        """Return the energy [J] of the spring that bears a force."""

    def energy(self, *overlaps: Any) -> Any:
        """Return the energy [J] of springs of these overlaps, numbers or arrays, none negative."""

    def small_motion(self, force: float) -> tuple[float, float]:
        """Return omega [rad/s] and zeta [-] of small motions about the rest under a force."""

    def most_rebound(self) -> float:
        """Return a bound on the restitution of the shock, for the hops after it."""


@dataclass(frozen=True)
class Linear:
    """Force k delta."""

    case: Incline

    def overlap(self, force: float) -> float:
        """Return F / k."""
        return force / self.case.stiffness

    def change(self, force: float, by: float) -> float:  # noqa: ARG002 - the same at every force
        """Return dF / k."""
        return by / self.case.stiffness

    def energy_under(self, force: float) -> float:
        """Return F^2 / 2k."""
        return 0.5 * force**2 / self.case.stiffness

    def energy(self, *overlaps: Any) -> Any:
        """Return k delta^2 / 2, summed."""
        first, *others = (overlap**2 for overlap in overlaps)
        return 0.5 * self.case.stiffness * sum(others, start=first)

    def small_motion(self, force: float) -> tuple[float, float]:  # noqa: ARG002
        """Return sqrt(k/m) and the contact's own damping ratio."""
        omega = math.sqrt(self.case.stiffness / self.case.mass)
        return omega, self.case.contact.zeta_against_full_mass

    def most_rebound(self) -> float:
        """Return 0: the hops of contacts near critical damping are over when it has settled."""
        return 0.0


@dataclass(frozen=True)
class HertzSpring:
    """Force K delta^(3/2), K as :mod:`harness.parameters.hertz` makes it from the stiffness."""

    law: Hertz
    mass: float

    def overlap(self, force: float) -> float:
        """Return (F / K)^(2/3)."""
        return self.law.rest(force)

    def change(self, force: float, by: float) -> float:
        """Return dF / (3/2 K sqrt(delta))."""
        return by / self.law.slope(self.law.rest(force))

    def energy_under(self, force: float) -> float:
        """Return 2/5 F delta."""
        return 0.4 * force * self.law.rest(force)

    def energy(self, *overlaps: Any) -> Any:
        """Return 2/5 K delta^(5/2), summed."""
        return 0.4 * self.law.coefficient * sum(overlap**2.5 for overlap in overlaps)

    def small_motion(self, force: float) -> tuple[float, float]:
        """Return sqrt(3/2 K sqrt(delta) / m) and its damping ratio."""
        overlap = self.law.rest(force)
        omega = math.sqrt(self.law.slope(overlap) / self.mass)
        return omega, self.law.damping_ratio(overlap, self.mass)

    def most_rebound(self) -> float:
        """Return the law's bound: it rebounds more than a linear contact of its damping ratio."""
        return self.law.most_rebound()


def spring_of(case: Incline, law: SpringLaw) -> Spring:
    """Return the spring of a case under a law."""
    makers: dict[SpringLaw, Callable[[], Spring]] = {
        "linear": lambda: Linear(case),
        "Hertz": lambda: HertzSpring(
            hertz(case.contact, case.stiffness, case.mass, case.hertz_speed), case.mass
        ),
    }
    return makers[law]()
