"""Mixing index, angle of a surface and contacts of grains, by their places."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


class Contacts(NamedTuple):
    """Pairs of grains that touch, by their numbers, and their overlaps [m], (K,) each."""

    i: NDArray[np.int64]
    j: NDArray[np.int64]
    overlap: Floats


def lacey_index(cells: Floats, chosen: NDArray[np.bool_]) -> float:
    """Return Lacey's mixing index [-]: 0 for unmixed kinds, 1 for a random mixture.

    ``cells`` (N, 2) are column and row of the cell of each grain, ``chosen`` (N,) whether it is of
    one kind. With n_i grains in a cell, p_i of them chosen, and p of all, the variance is
    S = sum n_i (p_i - p)^2 / N: p (1 - p) for unmixed kinds, and p (1 - p) (K - 1)/(N - 1)
    in K cells of a random mixture. The index is the share of the way from the one to the other:
    Lacey, J. Appl. Chem. 4, 257 (1954), for cells of any content. NaN where all grains are of one
    kind, or each is in a cell of its own.
    """
    _, place = np.unique(cells, axis=0, return_inverse=True)
    content = np.bincount(place).astype(np.float64)
    share = np.bincount(place, weights=chosen) / content
    total, p = len(cells), float(np.mean(chosen))
    unmixed = p * (1.0 - p)
    at_random = unmixed * (len(content) - 1) / (total - 1)
    if unmixed == 0.0 or len(content) == total:
        return math.nan
    variance = float((content * (share - p) ** 2).sum() / total)
    return (unmixed - variance) / (unmixed - at_random)


def find_contacts(places: Floats, radius: Floats) -> Contacts:
    """Return the pairs that touch, each once, of grains at places (N, 3) with radii (N,) [m]."""
    from scipy.spatial import KDTree  # slow to load

    i, j = KDTree(places).query_pairs(2.0 * radius.max(), output_type="ndarray").T
    overlap = radius[i] + radius[j] - np.linalg.norm(places[i] - places[j], axis=1)
    touch = overlap > 0.0
    return Contacts(i[touch], j[touch], overlap[touch])


def surface_angle(x: Floats, z: Floats, radius: Floats, half_width: float, step: float) -> float:
    """Return the angle of the surface [deg], positive where it falls along +x.

    By a straight line through the highest points of the grains (N,) in columns of width ``step``
    between -``half_width`` and ``half_width`` [m]. NaN where fewer than three columns hold grains.
    """
    number = round(2.0 * half_width / step)
    edges = np.linspace(-half_width, half_width, number + 1)
    column = np.digitize(x, edges) - 1
    inside = (column >= 0) & (column < number)
    top = np.full(number, -np.inf)
    np.maximum.at(top, column[inside], (z + radius)[inside])
    filled = np.isfinite(top)
    if filled.sum() < 3:
        return math.nan
    middle = 0.5 * (edges[1:] + edges[:-1])
    return -math.degrees(math.atan(np.polyfit(middle[filled], top[filled], 1)[0]))
