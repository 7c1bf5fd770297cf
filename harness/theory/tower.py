"""A tower of equal particles on a fixed base: at rest, its modes, its stiffness."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def static_forces(contacts: int, mass: float, gravity: float) -> Floats:
    """Return the contact forces at rest (n,) [N]: the weight above, under either law."""
    return np.arange(1.0, contacts + 1) * (mass * gravity)


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
