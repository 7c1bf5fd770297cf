"""Validate positions and properties for the contact solvers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harness.chain.arrays import Floats
from harness.errors import RequestError


def checked_positions(positions: ArrayLike, reach: Floats | float) -> Floats:
    """Return ``positions`` [m] as an array (N,).

    ``reach`` [m] is the centre distance at which neighbours just touch, one
    number or one for each contact. Raise RequestError, naming the first value
    at fault, unless there are two particles or more, all finite, ascending, and
    no two neighbours closer than half their reach.
    """
    x = np.asarray(positions, dtype=float)
    if x.ndim != 1 or x.size < 2:
        raise RequestError(f"positions: shape {x.shape}, must be a row of two particles or more")
    for i in np.flatnonzero(~np.isfinite(x)):
        raise RequestError(f"positions[{i}] = {x[i]} m: must be finite")
    distance = np.diff(x)
    for i in np.flatnonzero(distance <= 0):
        raise RequestError(
            f"positions[{i + 1}] = {x[i + 1]} m: must be greater than positions[{i}] = {x[i]} m"
        )
    least = np.broadcast_to(0.5 * np.asarray(reach), distance.shape)
    for i in np.flatnonzero(distance < least):
        raise RequestError(
            f"positions[{i + 1}] - positions[{i}] = {distance[i]} m: "
            f"must be at least {least[i]} m, half the distance at which they touch"
        )
    return x


def checked_positive(name: str, unit: str, value: ArrayLike, size: int) -> Floats:
    """Return ``value`` as an array (size,), or raise RequestError unless finite and above 0."""
    array = np.asarray(value, dtype=float)
    if array.ndim > 1 or (array.ndim == 1 and array.size != size):
        raise RequestError(f"{name}: shape {array.shape}, must be one value or {size} values")
    array = np.array(np.broadcast_to(array, (size,)))
    for i in np.flatnonzero(~(np.isfinite(array) & (array > 0))):
        raise RequestError(f"{name}[{i}] = {array[i]} {unit}: must be finite and greater than 0")
    return array
