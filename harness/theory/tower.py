"""A tower of equal particles on a fixed base: at rest, its modes, its stiffness."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def static_forces(contacts: int, mass: float, gravity: float) -> Floats:
    """Return the contact forces at rest (n,) [N]: the weight above, under either law."""
    return np.arange(1.0, contacts + 1) * (mass * gravity)


def static_overlaps(
    contacts: int, mass: float, gravity: float, stiffness: float, deformable: bool
) -> Floats:
    """Return how much closer than touching the centres are at rest (n,) [m].

    Overlap law: weight/k. Deformable law: contact i shares its particles with
    its neighbours, ``2 i m g/k``, and ``(3n - 1)/2 m g/k`` at the base, which
    has none below; one contact alone has ``m g/k``.
    """
    unit = mass * gravity / stiffness
    i = np.arange(1.0, contacts + 1)
    if not deformable or contacts == 1:
        return np.asarray(i * unit)
    overlaps = 2.0 * i * unit
    overlaps[-1] = (3 * contacts - 1) / 2 * unit
    return overlaps


def overlap_modes(mobile: int, omega: float) -> Floats:
    """Return the angular frequencies of M mobile particles on a fixed base (M,) [rad/s].

    Overlap law, all touching: ``2 omega sin((2j-1) pi / (2 (2M+1)))``.
    """
    j = np.arange(1.0, mobile + 1)
    return np.asarray(2 * omega * np.sin((2 * j - 1) * math.pi / (2 * (2 * mobile + 1))))


def series_stiffness(contacts: int, stiffness: float, deformable: bool) -> float:
    """Return force over approach of the outer centres [N/m] of M contacts in series.

    Overlap law k/M. Deformable law k/(2M-1): each of the M - 1 particles in
    between is pressed from both sides and so shortened by 2f/k, the outer two,
    of which one half counts, by f/k. The source's k/n is neither.
    """
    return stiffness / (2 * contacts - 1 if deformable else contacts)


def contact_time_of_gamma(gamma: float) -> float:
    """Return omega t0 [1] of a grain on one fixed particle, ``2 (pi - atan(1/Gamma))``.

    ``Gamma = m g / (v0 sqrt(k m))``; pi without gravity.
    """
    return 2 * (math.pi - math.atan2(1.0, gamma))


def impulse_of_gamma(gamma: float) -> float:
    """Return the impulse of that contact [1], in m v0: ``2 + Gamma omega t0``."""
    return 2 + gamma * contact_time_of_gamma(gamma)
