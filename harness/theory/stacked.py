"""Spheres stacked between two plates, pressed so that no contact opens: a linear system.

Neighbours are joined by springs and dashpots, so that the motion is the exponential of a matrix
(MFiX's verification case DEM03 has two spheres).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import expm

Floats = NDArray[np.float64]


def motion(
    times: ArrayLike,
    start: ArrayLike,
    masses: ArrayLike,
    radii: ArrayLike,
    plates: tuple[float, float],
    contact: tuple[float, ArrayLike, float],
) -> tuple[Floats, Floats]:
    """Return heights and velocities of the spheres, (times, spheres) [m, m/s], from rest.

    ``start``: heights [m], from below; ``plates``: heights of the lower and the upper one [m];
    ``contact``: stiffness [N/m], dashpots [kg/s] of the contacts from below (one more than
    spheres) and gravity [m/s2].
    """
    mass, radius, place = (np.asarray(values, dtype=float) for values in (masses, radii, start))
    stiffness, dashpots, gravity = contact
    size = len(mass)
    # overlaps = ahead - difference @ heights, for the contacts from below
    difference = np.vstack([np.eye(size), np.zeros(size)]) - np.eye(size + 1, size, -1)
    ahead = np.append(radius, 0.0) + np.insert(radius, 0, 0.0)
    ahead[0] += plates[0]
    ahead[-1] -= plates[1]
    eta = np.asarray(dashpots, dtype=float)[:, None]
    rates = np.zeros((2 * size + 1, 2 * size + 1))
    rates[:size, size:-1] = np.eye(size)
    rates[size:-1, :size] = -(difference.T * stiffness) @ difference / mass[:, None]
    rates[size:-1, size:-1] = -difference.T @ (eta * difference) / mass[:, None]
    rates[size:-1, -1] = difference.T @ (stiffness * ahead) / mass - gravity
    first = np.concatenate([place, np.zeros(size), [1.0]])
    states = np.array([expm(rates * time) @ first for time in np.atleast_1d(times)])
    return states[:, :size], states[:, size:-1]
