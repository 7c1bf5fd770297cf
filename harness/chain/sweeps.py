"""Find the chains of touching particles by sweeps that start at the closest pair.

The readable way, for equal spheres (Harper, Dufek and Breard, Appendix A, "Identifying
chains"); :mod:`harness.chain.complementarity` is the fast one and shares no
code with this.

The source closes a contact once it is *guaranteed*: closed even if the unknown
contacts beyond press as hard as they can. How hard that is follows from its
inequality ``c <= d - (x[i+1] - x[i])`` (corrected), and gets sharper in every
sweep as chains become known. Merging neighbouring chains merely because their
boundaries overlap at the moment is not enough: overlaps of 0.9, 0.6 and 1 would
first join contacts 3 and 2 and then 1, though 1 and 3 push 2 open. So every
undecided contact here carries both its bounds, and the sweeps close in on the
one solution from both sides.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from harness.chain.arrays import Floats
from harness.chain.boundaries import partial_compressions
from harness.chain.validate import checked_positions, checked_positive
from harness.errors import RequestError

_SWEEPS = 10_000


def compressions(positions: ArrayLike, diameter: float) -> Floats:
    """Return the partial compression of every contact (N-1,) [m], 0 where open.

    ``positions`` are the centres (N,) [m] of equal spheres, ascending. Raise
    RequestError for positions that cannot be.
    """
    d = float(checked_positive("diameter", "m", diameter, 1)[0])
    x = checked_positions(positions, d)
    result = np.zeros(x.size - 1)
    for first, last in chains(x, d):
        result[first:last] = partial_compressions(x[first : last + 1], d / 2)
    return result


def chains(x: Floats, diameter: float) -> list[tuple[int, int]]:
    """Return the chains of two particles or more as (first, last) particle, from the left."""
    sweep = _Sweep(x, diameter)
    for _ in range(_SWEEPS):
        for contact in sweep.closest_first:
            sweep.visit(contact)
        if not sweep.undecided:
            return sweep.chains()
    raise RequestError(f"positions = {x.tolist()} m: contacts undecided after {_SWEEPS} sweeps")


@dataclass
class _Sweep:
    """What is known of each contact: closed, open, or between ``low`` and ``high`` [m]."""

    x: Floats
    diameter: float
    low: list[float] = field(init=False)
    high: list[float] = field(init=False)
    closed: list[bool] = field(init=False)
    ends: dict[tuple[int, int], tuple[float, float]] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        overlap = self.diameter - np.diff(self.x)
        self.overlap = [float(value) for value in overlap]
        self.low = [0.0] * len(self.overlap)
        self.high = [max(value, 0.0) for value in self.overlap]
        self.closed = [False] * len(self.overlap)
        self.closest_first = [int(i) for i in np.argsort(-overlap, kind="stable")]
        # what lies below the rounding of the overlaps is nothing
        self.nothing = 4 * np.finfo(float).eps * max(self.diameter, abs(self.x[0]), abs(self.x[-1]))

    @property
    def undecided(self) -> bool:
        """Return whether some contact is neither closed nor open."""
        return any(h > 0 and not c for h, c in zip(self.high, self.closed, strict=True))

    def visit(self, i: int) -> None:
        """Sharpen the bounds of contact ``i``, and close or open it if they suffice."""
        if self.closed[i] or self.high[i] == 0:
            return
        left_low, left_high, left = self._pressed_from(i, -1)
        right_low, right_high, right = self._pressed_from(i, +1)
        give = 1 - 0.5 * left / (left + 1) - 0.5 * right / (right + 1)
        least = (self.overlap[i] - (left_high + right_high) / 2) / give
        most = (self.overlap[i] - (left_low + right_low) / 2) / give
        self.low[i] = max(self.low[i], least)
        self.high[i] = min(self.high[i], most)
        if self.high[i] <= self.nothing:
            self.high[i] = 0.0
        elif self.low[i] > 0:
            self.closed[i] = True

    def _pressed_from(self, i: int, side: int) -> tuple[float, float, int]:
        """Return bounds on the compression next to ``i`` on a side, were ``i`` open, and ...

        the number of contacts L of the known chain there. Inside the chain the
        compression next to ``i`` falls by ``(-1)^(L-1) / (L+1)`` times the one at
        its far end, whose bounds are known.
        """
        far = i + side
        while 0 <= far < len(self.closed) and self.closed[far]:
            far += side
        length = abs(far - i) - 1
        alone = self._end_of_chain(i, far, side) if length else 0.0
        inside = 0 <= far < len(self.closed)
        low, high = (self.low[far], self.high[far]) if inside else (0.0, 0.0)
        if length % 2:
            low, high = -high, -low
        return alone + low / (length + 1), alone + high / (length + 1), length

    def _end_of_chain(self, i: int, far: int, side: int) -> float:
        """Return the compression next to contact ``i`` of the chain between it and ``far``."""
        first, last = (far + 1, i) if side < 0 else (i + 1, far)
        if (first, last) not in self.ends:
            chain = partial_compressions(self.x[first : last + 1], self.diameter / 2)
            self.ends[first, last] = float(chain[0]), float(chain[-1])
        return self.ends[first, last][1 if side < 0 else 0]

    def chains(self) -> list[tuple[int, int]]:
        """Return the runs of closed contacts as (first, last) particle."""
        runs: list[tuple[int, int]] = []
        for i, closed in enumerate(self.closed):
            if closed and runs and runs[-1][1] == i:
                runs[-1] = runs[-1][0], i + 1
            elif closed:
                runs.append((i, i + 1))
        return runs
