"""Chains of touching particles as the source finds them: boundaries, and sweeps over contacts.

Equal spheres, from their centres alone (Harper, Dufek and Breard, arXiv:2409.13633, Appendix A).
A particle keeps its centre in the middle of its deformed boundaries, so that these follow from the
first by b[i] = 2 x[i] - b[i-1]. The alternating sum of the deformations vanishes (Newton's third
law), which gives the first. This route shares no code with :mod:`harness.solvers.chain.contacts`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harness.errors import RequestError
from harness.solvers.chain.contacts import check_distances
from harness.solvers.chain.motion import Floats

MOST_SWEEPS = 10_000


def compressions(positions: ArrayLike, diameter: float) -> Floats:
    """Return the partial compression of every contact (N - 1,) [m], 0 where open.

    ``positions`` are the centres (N,) [m], ascending. Raise RequestError for neighbours closer than
    half a diameter.
    """
    x = np.asarray(positions, dtype=float)
    check_distances(x, diameter)
    result = np.zeros(x.size - 1)
    for first, last in _touching_chains(x, diameter):
        result[first:last] = partial_compressions(x[first : last + 1], diameter / 2)
    return result


def first_boundary(positions: Floats, radius: float) -> float:
    """Return the outer boundary of the first particle of a chain [m].

    ``b_0 = (1/n) (((-1)^n - 1)/2 r0 + sum_i (-1)^(i+1) (2(n-i)+1) x_i)`` with n particles at
    ``positions`` (n,) [m]. The source prints ``(-1)^n r0``, which contradicts its own example of
    four particles.
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


def partial_compressions(positions: Floats, radius: float) -> Floats:
    """Return the n - 1 partial compressions c of a chain [m]; a contact carries k c.

    A particle's deformation is the sum of those on its two sides, and the first has one side only.
    Negative values mean that these particles do not all touch.
    """
    deformation = 2 * (radius - (positions - boundaries(positions, radius)[:-1]))
    result = np.empty(positions.size - 1)
    carried = 0.0
    for i in range(result.size):
        carried = deformation[i] - carried
        result[i] = carried
    return result


# ---- sweeps from the closest pair on
#
# The source closes a contact once it is *guaranteed*: closed even if the unknown contacts beyond
# press as hard as they can, by c <= d - (x[i+1] - x[i]) (corrected). To merge neighbouring chains
# because their boundaries overlap at the moment is not enough: overlaps of 0.9, 0.6 and 1 would
# first join contacts 3 and 2 and then 1, though 1 and 3 push 2 open. So every undecided contact
# has both bounds here, and the sweeps close in on the one solution from both sides.


def _touching_chains(x: Floats, diameter: float) -> list[tuple[int, int]]:
    """Return the chains of two particles or more as (first, last) particle, from the left."""
    sweep = _Sweep(x, diameter)
    for _ in range(MOST_SWEEPS):
        for contact in np.argsort(-sweep.overlap, kind="stable"):
            sweep.visit(int(contact))
        if not (~sweep.closed & (sweep.high > 0)).any():
            edges = np.flatnonzero(np.diff([False, *sweep.closed, False]))
            return [(int(first), int(last)) for first, last in edges.reshape(-1, 2)]
    raise RequestError(f"positions = {x.tolist()} m: contacts undecided after {MOST_SWEEPS} sweeps")


class _Sweep:
    """Each contact: closed, open, or with bounds ``low`` and ``high`` on its compression [m]."""

    def __init__(self, x: Floats, diameter: float) -> None:
        self.x, self.radius, self.overlap = x, diameter / 2, diameter - np.diff(x)
        self.low, self.high = np.zeros_like(self.overlap), np.maximum(self.overlap, 0.0)
        self.closed = np.zeros(self.overlap.size, np.bool_)
        # a compression below the rounding of the overlaps counts as 0
        self.rounding = 4 * np.finfo(float).eps * max(diameter, abs(x[0]), abs(x[-1]))

    def visit(self, i: int) -> None:
        """Sharpen the bounds of contact ``i``, and close or open it if they suffice."""
        if self.closed[i] or self.high[i] == 0:
            return
        left_low, left_high, before = self._next_compression(i, -1)
        right_low, right_high, after = self._next_compression(i, +1)
        give = 1 - 0.5 * before / (before + 1) - 0.5 * after / (after + 1)
        least = (self.overlap[i] - (left_high + right_high) / 2) / give
        most = (self.overlap[i] - (left_low + right_low) / 2) / give
        self.low[i], self.high[i] = max(self.low[i], least), min(self.high[i], most)
        if self.high[i] <= self.rounding:
            self.high[i] = 0.0
        self.closed[i] = self.high[i] > 0 and self.low[i] > 0

    def _next_compression(self, i: int, side: int) -> tuple[float, float, int]:
        """Return bounds on the compression next to ``i`` on a side, were ``i`` open, and L.

        L is the number of contacts of the known chain there. Inside the chain the compression next
        to ``i`` falls by ``(-1)^(L-1) / (L+1)`` times the one at its far end.
        """
        far = i + side
        while 0 <= far < self.closed.size and self.closed[far]:
            far += side
        length = abs(far - i) - 1
        alone = 0.0
        if length:
            first, last = (far + 1, i) if side < 0 else (i + 1, far)
            chain = partial_compressions(self.x[first : last + 1], self.radius)
            alone = float(chain[-1] if side < 0 else chain[0])
        inside = 0 <= far < self.closed.size
        low, high = (self.low[far], self.high[far]) if inside else (0.0, 0.0)
        if length % 2:
            low, high = -high, -low
        return alone + low / (length + 1), alone + high / (length + 1), length
