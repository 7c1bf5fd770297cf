"""The step of MFiX-DEM in the harness's terms."""

from __future__ import annotations

import math
from typing import Literal

from harness.errors import RequestError
from harness.parameters.contact import Contact

Scheme = Literal["EULER", "ADAMS_BASHFORTH"]
"""MFiX's names of its integrators (``DES_INTG_METHOD``)."""

REFERENCE: dict[Scheme, str] = {
    "EULER": "mfix-euler",
    "ADAMS_BASHFORTH": "mfix-adams-bashforth",
}
"""The reference DEM's names of them."""

FIRST_STEP: dict[Scheme, float] = {"EULER": 1.0, "ADAMS_BASHFORTH": 0.5}
"""The part of h a by which the first step's displacement h v + part h^2 a falls behind or ahead:
x+ = x + h (v + h a), and x + h/2 (v + v + h a)."""

LEAST_FACTOR = 10.0
"""What MFiX takes at least for ``DTSOLID_FACTOR`` (21.3.2, ``check_solids_dem.f``)."""


def steps_per_contact(factor: float, contact: Contact) -> float:
    """Return the steps per pi sqrt(m/k) that MFiX takes at a ``DTSOLID_FACTOR``.

    MFiX divides the duration of a damped contact, with m_eff = m/2 also against
    a fixed sphere, pi / sqrt(k/m_eff - (eta / (2 m_eff))^2), by the factor. With eta = 2 zeta
    sqrt(k m_eff) that is pi sqrt(m/k) / sqrt(2 (1 - zeta^2)): at e = 1e-20 it is ten times
    as long, and MFiX's default factor of 50 means 4.8 steps. Raise RequestError for a factor
    that is not positive, or a contact without such a duration (zeta >= 1) or without m/2.
    """
    if not (math.isfinite(factor) and factor > 0.0):
        raise RequestError(f"factor = {factor!r}: must be finite and greater than 0")
    return factor * _steps_of_factor_one(contact)


def factor(steps: float, contact: Contact) -> float:
    """Return the ``DTSOLID_FACTOR`` of so many steps per pi sqrt(m/k).

    The inverse of :func:`steps_per_contact`, with its errors. Raise RequestError below the
    10 that MFiX takes at least.
    """
    wanted = steps / _steps_of_factor_one(contact)
    if not wanted >= LEAST_FACTOR:
        least = LEAST_FACTOR * _steps_of_factor_one(contact)
        raise RequestError(
            f"steps_per_contact = {steps:g} is DTSOLID_FACTOR = {wanted:.4g} in MFiX, which takes "
            f"{LEAST_FACTOR:g} or more: must be at least {least:.4g} with this contact"
        )
    return wanted


def _steps_of_factor_one(contact: Contact) -> float:
    if contact.effective_mass != "half":
        raise RequestError(
            "effective_mass = 'full': MFiX takes half the mass, must be 'half' "
            "(--set contact.effective_mass=half, of critical-angle --half-mass)"
        )
    if contact.zeta >= 1.0:
        raise RequestError(
            f"damping ratio = {contact.zeta:g}: MFiX's contact time asks for less than 1"
        )
    return math.sqrt(2.0 * (1.0 - contact.zeta**2))
