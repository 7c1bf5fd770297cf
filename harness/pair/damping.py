"""The normal dashpot eta_n [kg/s] of a contact, and how it grows with the overlap.

velocity: eta_0. mass_velocity: eta_0 m*. viscoelastic: eta_0 m* a (Brilliantov et al. 1996).
secant: c sqrt(m* F/delta) with the elastic force F; the restitution depends on c alone. c = 2 zeta
for a linear spring, sqrt(5) zeta for Hertz's (Antypov and Elliott, EPL 94, 50004 (2011)), with
zeta = -ln e / sqrt(pi^2 + ln^2 e). Tsuji, Tanaka and Ishida, Powder Technol. 71, 239 (1992), fit
the second one: alpha(e) sqrt(m F/delta) with the mass m = 2 m* of one of two equal spheres.
stiffness (mdr's): c sqrt(m* k) with k = 2 E_eff a, the manual of LAMMPS says: the slope of the
elastic force of two equal spheres, E_eff = E*, and of one on a rigid wall, E_eff = 2 E*.
"""

from __future__ import annotations

import math

from harness.pair.normal import Elastic
from harness.pair.vectors import compiled
from harness.parameters.contact_law import ContactLaw
from harness.parameters.contact_rules import Rules

NONE, VELOCITY, MASS_VELOCITY, VISCOELASTIC, SECANT, STIFFNESS = range(6)

KINDS = {
    "none": NONE,
    "velocity": VELOCITY,
    "mass_velocity": MASS_VELOCITY,
    "viscoelastic": VISCOELASTIC,
    "tsuji": SECANT,
    "coeff_restitution": SECANT,
    "mdr": STIFFNESS,
}

TSUJI = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)
"""alpha(e) by powers of e: the fit to Tsuji's figure by Marshall, J. Comput. Phys. 228, 1541."""


def coefficient(law: ContactLaw, rules: Rules) -> float:
    """Return eta_0, or c of a secant dashpot and of one of the stiffness."""
    if law.restitution is None:
        return law.damping_coefficient or 0.0
    if law.damping == "tsuji":
        return tsuji(law.restitution) * math.sqrt(
            2.0 if rules.tsuji_mass == "twice_effective" else 1.0
        )
    logarithm = -math.log(law.restitution)
    zeta = logarithm / math.hypot(math.pi, logarithm)
    linear = law.normal == "hooke" or rules.hertz_restitution == "linear"
    return zeta * (2.0 if linear else math.sqrt(5.0))


def tsuji(restitution: float) -> float:
    """Return alpha(e)."""
    return sum(factor * restitution**power for power, factor in enumerate(TSUJI))


@compiled
def dashpot(
    kind: int, coefficient: float, mass: float, overlap: float, elastic: Elastic, modulus: float
) -> tuple[float, float]:
    """Return eta_n [kg/s] and d(eta_n)/d(overlap) [kg/(m s)] for the effective mass [kg].

    ``modulus`` is E_eff [Pa] of a dashpot that goes with the stiffness.
    """
    if kind == VELOCITY:
        return coefficient, 0.0
    if kind == MASS_VELOCITY:
        return coefficient * mass, 0.0
    if kind == VISCOELASTIC:
        eta = coefficient * mass * elastic.radius
        return eta, eta * elastic.growth
    if kind == SECANT and elastic.force > 0.0:
        eta = coefficient * math.sqrt(mass * elastic.force / overlap)
        return eta, 0.5 * eta * (elastic.slope / elastic.force - 1.0 / overlap)
    if kind == STIFFNESS:
        eta = coefficient * math.sqrt(mass * 2.0 * modulus * elastic.radius)
        return eta, 0.5 * eta * elastic.growth
    return 0.0, 0.0
