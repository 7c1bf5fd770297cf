"""The Hertz contact that stands for a linear one, for engines that have no other.

The force along the normal is ``K (delta^(3/2) + A sqrt(delta) d(delta)/dt)`` for an overlap
``delta``: Hertz's spring with the viscous dashpot of Brilliantov, Spahn, Hertzsch and Poeschel,
Phys. Rev. E 53, 5382 (1996), who write 3/2 A where this writes A.

Two conditions make K and A from a stiffness k and a damping ratio zeta. Both are
set at ``overlap``, the largest of an undamped head-on impact at a reference speed v on a fixed
sphere, sqrt(m/k) v with the linear spring.

- The undamped impact reaches the same overlap: 2/5 K overlap^(5/2) = 1/2 k overlap^2, hence
  K = 5/4 k / sqrt(overlap).
- The dashpot's coefficient is the same there: K A sqrt(overlap) = 2 zeta sqrt(k m_eff), hence
  A = 8/5 zeta sqrt(m_eff / k).

The reference speed is sqrt(g d) on the incline. A drop adds the square of its own speed,
so that there is one without gravity too.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from harness.errors import RequestError
from harness.parameters.contact import Contact

STIFFEST = 15.0 / 8.0
"""[k] slope of the spring at the reference overlap: 3/2 K sqrt(overlap)."""


@dataclass(frozen=True)
class Hertz:
    """A Hertz contact: ``coefficient`` K [N/m^(3/2)] and ``relaxation`` A [s].

    ``overlap`` [m] is the one at which it stands for the linear contact, ``damping`` [-] is
    A v / overlap, 8/5 zeta.
    """

    coefficient: float
    relaxation: float
    overlap: float
    damping: float

    def rest(self, force: float) -> float:
        """Return the overlap [m] at which the spring bears a force [N]: (F/K)^(2/3)."""
        return float((force / self.coefficient) ** (2.0 / 3.0))

    def most_rebound(self) -> float:
        """Return a bound on the restitution at the reference speed: at most 1.

        The dashpot alone stops the grain at an overlap of (6/5a)^(2/3), and it leaves at
        1/a of it where the clipped force vanishes (a the damping).
        """
        if self.damping <= 1.0:
            return 1.0
        return float((1.2 / self.damping) ** (2.0 / 3.0) / self.damping)

    def slope(self, overlap: float) -> float:
        """Return the stiffness [N/m] of small motions about an overlap: 3/2 K sqrt(overlap)."""
        return 1.5 * self.coefficient * math.sqrt(overlap)

    def damping_ratio(self, overlap: float, mass: float) -> float:
        """Return the damping ratio [-] of small motions of a mass about an overlap."""
        dashpot = self.coefficient * self.relaxation * math.sqrt(overlap)
        return dashpot / (2.0 * math.sqrt(self.slope(overlap) * mass))


def hertz(contact: Contact, stiffness: float, mass: float, speed: float) -> Hertz:
    """Return the Hertz contact for a linear one, at an impact speed [m/s].

    Raise RequestError for a speed of 0: then there is no scale.
    """
    if speed == 0.0:
        raise RequestError(
            "speed = 0.0 m/s: a Hertz contact needs a speed or gravity greater than 0, which "
            "set its scale"
        )
    overlap = speed * math.sqrt(mass / stiffness)
    # A = 8/5 zeta sqrt(m_eff/k), and the effective mass is in the ratio with the whole mass
    damping = 1.6 * contact.zeta_against_full_mass
    relaxation = damping * math.sqrt(mass / stiffness)
    return Hertz(1.25 * stiffness / math.sqrt(overlap), relaxation, overlap, damping)


def fewest_steps_per_contact(contact: Contact) -> float:
    """Return the bound below which v+ = v + h a, x+ = x + h v+ may be unstable in the well.

    Motion normal to the row feels 3/2 of one contact: with the spring at its stiffest
    p = 3 zeta omega h and q = 45/16 (omega h)^2 must keep p + q/2 < 2 (Jury's criterion).
    """
    zeta = contact.zeta_against_full_mass
    half = 0.75 * STIFFEST
    longest = (math.sqrt(9.0 * zeta * zeta + 8.0 * half) - 3.0 * zeta) / (2.0 * half)
    return math.pi / longest
