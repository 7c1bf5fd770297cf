"""Boundaries of the deformed particles of one chain, from its centres alone.

Equal spheres, all of them touching their neighbours (Harper, Dufek and Breard,
Appendix A). Each particle keeps its centre in the middle, so the boundaries
follow from the first by ``b[i] = 2 x[i] - b[i-1]``; Newton's third law makes the
alternating sum of the deformations vanish, which gives the first.
"""

from __future__ import annotations

import numpy as np

from harness.chain.arrays import Floats


def first_boundary(positions: Floats, radius: float) -> float:
    """Return the outer boundary of the first particle of a chain [m].

    ``b_0 = (1/n) (((-1)^n - 1)/2 r0 + sum_i (-1)^(i+1) (2(n-i)+1) x_i)`` with n
    particles at ``positions`` (n,) [m]. The source prints ``(-1)^n r0``, which
    contradicts its own example of four particles.
    """
    n = positions.size
    i = np.arange(1, n + 1)
    weights = (-1.0) ** (i + 1) * (2 * (n - i) + 1)
    # the weights sum to n: counted from the first centre, long rows lose no digits
    offset = float(weights @ (positions - positions[0])) - (radius if n % 2 else 0.0)
    return float(positions[0]) + offset / n


def boundaries(positions: Floats, radius: float) -> Floats:
    """Return all n + 1 boundaries of a chain of n particles at ``positions`` (n,) [m]."""
    result = np.empty(positions.size + 1)
    result[0] = first_boundary(positions, radius)
    for i, centre in enumerate(positions):
        result[i + 1] = centre + (centre - result[i])
    return result


def deformations(positions: Floats, radius: float) -> Floats:
    """Return how much the diameter of each particle of a chain is shortened (n,) [m]."""
    return 2 * (radius - (positions - boundaries(positions, radius)[:-1]))


def partial_compressions(positions: Floats, radius: float) -> Floats:
    """Return the n - 1 partial compressions c of a chain [m]; a contact carries k c.

    A particle's deformation is the sum of the partial compressions on its two
    sides, and the first particle has one side only. Negative values say that
    these particles do not all touch.
    """
    deformation = deformations(positions, radius)
    result = np.empty(positions.size - 1)
    carried = 0.0
    for i in range(result.size):
        carried = deformation[i] - carried
        result[i] = carried
    return result
