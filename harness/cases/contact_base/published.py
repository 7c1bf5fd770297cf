"""The literature's curve of an impact with friction: the velocity at the contact that is left."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from harness.cases.contact_base.closed_forms import oscillator
from harness.cases.contact_base.motion import Array
from harness.cases.contact_base.parameters import ContactSystem
from harness.theory import dashpot
from harness.theory.oblique import held, two_branches
from harness.theory.partial_slip import rebounds, stiffness_ratio

ANGLES = np.arange(4.0, 86.5, 0.5)
"""[deg] to the normal, of the velocity at the contact."""


@dataclass(frozen=True)
class Published:
    """A curve: its name, what it is in words, angles of the incidence [deg] and what is left.

    ``left`` is the tangential velocity at the contact after over that before, (M,).
    """

    name: str
    told: str
    angles: Array = field(repr=False)
    left: Array = field(repr=False)


def published(parameters: ContactSystem, restitution: float) -> Published | None:
    """Return the curve of a linear contact or of a solid sphere; None where there is none."""
    mu = parameters.friction or 0.0
    if mu <= 0.0:
        return None
    if parameters.two_materials:  # the theory has those of equal ones, or with nu = 1/2
        return None
    if parameters.normal == "hertz" and "mindlin" in parameters.tangential:
        return _partial_slip(parameters, mu, restitution)
    linear = parameters.normal == "hooke" and parameters.tangential.startswith("linear")
    if not linear or parameters.damping == "viscoelastic":
        return None
    sticking = _sticking(parameters)
    left = [two_branches(u, mu, restitution, sticking) for u in np.tan(np.radians(ANGLES))]
    told = (
        "the branches of Walton (1993), sticking or sliding to the end with the lesser impulse: "
        "the law does both in turn between them"
    )
    return Published("Walton 1993: sticks or slides", told, ANGLES, np.array(left))


def _sticking(parameters: ContactSystem) -> float:
    """Return what is left of the velocity at a linear contact that sticks throughout."""
    zeta, omega = oscillator(parameters)
    clipped = parameters.clipped
    lasts = (dashpot.duration_clipped if clipped else dashpot.duration_unclipped)(zeta) / omega
    stiffness = (parameters.tangential_stiffness or 0.0) / parameters.reduced_mass
    damping = (parameters.tangential_damping or 0.0) * 2.0 * zeta * omega
    return held(3.5 * stiffness, 3.5 * damping, lasts)


def _partial_slip(parameters: ContactSystem, mu: float, restitution: float) -> Published:
    """Return the curve of an elastic sphere; of one that dissipates with mu (1 + e) / 2 for mu.

    So impacts that slide throughout are on it whatever they dissipate along the normal: inelastic
    ones are drawn over 2 tan / (mu (1 + e)) (Thornton, Cummins and Cleary, Powder Technol. 233,
    30 (2013)).
    """
    poisson = parameters.poisson_ratio
    assert poisson is not None
    kappa = stiffness_ratio(poisson)
    scale = 0.5 * mu * (1.0 + restitution) / kappa  # u / v of psi = 1
    psi, back = rebounds(poisson)
    sliding = np.tan(np.radians(ANGLES)) / scale
    sliding = sliding[sliding > psi[-1]]
    incidence = np.concatenate([psi, sliding])
    left = np.concatenate([back / psi, 1.0 - 7.0 * kappa / sliding])
    told = "an elastic sphere with partial slip, by Maw, Barber and Fawcett (1976)"
    if restitution < 1.0 - 1e-6:
        told += (
            ", with mu (1 + e) / 2 for mu, so that impacts that slide throughout are on it; it has "
            "no dashpot along the surface"
        )
    angles = np.degrees(np.arctan(incidence * scale))
    shown = angles >= ANGLES[0]
    return Published("Maw, Barber and Fawcett 1976", told, angles[shown], left[shown])
