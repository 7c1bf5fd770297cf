"""The first root of a polynomial: what tells when a parabola meets a circle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.compiled import compiled

NEVER = np.inf
MOST_STEPS = 200
"""Of one root; bisection alone takes half as many."""


@compiled
def value(coefficients: NDArray[np.float64], t: float) -> float:
    """Return a polynomial at t; coefficients from the constant on, shape (degree + 1,)."""
    found = 0.0
    for k in range(coefficients.size - 1, -1, -1):
        found = found * t + coefficients[k]
    return found


@compiled
def roots_within(coefficients: NDArray[np.float64], end: float) -> NDArray[np.float64]:
    """Return the real roots between 0 and ``end`` at which a polynomial changes its sign, rising.

    Between two neighbouring roots of its derivative a polynomial is monotone and has one root at
    most, which Newton's method finds inside a bracket. So the roots of the derivatives are found
    one after the other, from the linear one on.
    """
    degree = coefficients.size - 1
    places = np.array([0.0, end])
    for order in range(1, degree + 1):
        times = degree - order
        polynomial = coefficients[times:].copy()
        for k in range(polynomial.size):
            for factor in range(k + 1, k + times + 1):
                polynomial[k] *= factor
        found = np.empty(places.size + 1)
        found[0], count = 0.0, 1
        for k in range(places.size - 1):
            low, high = places[k], places[k + 1]
            if value(polynomial, low) * value(polynomial, high) < 0.0:
                found[count] = _between(polynomial, low, high)
                count += 1
        found[count] = end
        places = found[: count + 1].copy()
    return places[1:-1]


@compiled
def _between(polynomial: NDArray[np.float64], low: float, high: float) -> float:
    """Return the root of a monotone polynomial in a bracket, by Newton's method kept inside it."""
    slope = polynomial[1:].copy()
    for k in range(slope.size):
        slope[k] *= k + 1
    rising = value(polynomial, high) > 0.0
    t = 0.5 * (low + high)
    for _ in range(MOST_STEPS):
        height = value(polynomial, t)
        if height == 0.0:
            return t
        if (height > 0.0) == rising:
            high = t
        else:
            low = t
        steepness = value(slope, t)
        following = t - height / steepness if steepness != 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if following in (t, low, high):
            return following
        t = following
    return t
