"""A grain that hits a row without end, overlap law, no gravity: Bessel functions.

Schroedinger's chain: ``u_j'' = omega^2 (u_(j-1) - 2 u_j + u_(j+1))`` with a free
end gives ``v1 = 2 J1(tau)/tau`` for ``tau = 2 omega t``. No contact opens before
the grain's own, so this holds until the grain leaves, at the first zero of J2.
A finite tower obeys it until the echo from its base is back.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import jn_zeros, jv

DETACHMENT_TAU = float(jn_zeros(2, 1)[0])  # 5.135622
DETACHMENT_VELOCITY = float(2 * jv(1, DETACHMENT_TAU) / DETACHMENT_TAU)  # -0.1322795


def grain_velocity(tau: ArrayLike) -> NDArray[np.float64]:
    """Return the velocity of the grain [1], as a part of its speed, while in contact."""
    return _ratio(1, 2.0, np.asarray(tau, dtype=float), 1.0)


def grain_force(tau: ArrayLike) -> NDArray[np.float64]:
    """Return the contact force on the grain [1], in m omega v0, ``4 J2(tau)/tau``."""
    return _ratio(2, 4.0, np.asarray(tau, dtype=float), 0.0)


def _ratio(
    order: int, factor: float, tau: NDArray[np.float64], at_zero: float
) -> NDArray[np.float64]:
    """Return ``factor J(tau)/tau``, ``at_zero`` where tau is 0."""
    result = np.full_like(tau, at_zero)
    np.divide(factor * jv(order, tau), tau, out=result, where=tau != 0)
    return result
