"""Contact forces of a chain under the deformable law: which particles touch, and how hard.

With the overlaps given, the forces f of the contacts solve a linear complementarity problem,

    w = A f - overlap >= 0,   f >= 0,   f w = 0,

with A symmetric positive definite and tridiagonal (:class:`harness.solvers.chain.motion.Chain`):
one solution, whatever the positions. There are three routes to it: :func:`chains` finds the chains
by sweeps from the centres alone, for equal spheres, as the source describes it; :func:`solve` goes
on from the contact set of the step before, in O(N); :func:`closed_contacts` takes one elimination
without iteration, where that cycles. The sweeps share no code with the other two.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.errors import RequestError
from harness.solvers.chain.motion import (
    Floats,
    checked_positions,
    checked_positive,
    compiled,
    compliance,
    partial_compressions,
)

# ---- sweeps from the closest pair on
#
# For equal spheres (Harper, Dufek and Breard, Appendix A, "Identifying chains"). The source closes
# a contact once it is *guaranteed*: closed even if the unknown contacts beyond press as hard as
# they can. How hard that is follows from its inequality c <= d - (x[i+1] - x[i]) (corrected), and
# gets sharper in every sweep as chains become known. Merging neighbouring chains merely because
# their boundaries overlap at the moment is not enough: overlaps of 0.9, 0.6 and 1 would first join
# contacts 3 and 2 and then 1, though 1 and 3 push 2 open. So every undecided contact here carries
# both its bounds, and the sweeps close in on the one solution from both sides.

_SWEEPS = 10_000


def compressions(positions: ArrayLike, diameter: float) -> Floats:
    """Return the partial compression of every contact (N-1,) [m], 0 where open.

    ``positions`` are the centres (N,) [m] of equal spheres, ascending. Raise
    RequestError for positions that do not ascend.
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
    """Each contact, closed, open, or with bounds ``low`` and ``high`` on its compression [m]."""

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
        # a compression below the rounding of the overlaps counts as 0
        self.rounding = (
            4 * np.finfo(float).eps * max(self.diameter, abs(self.x[0]), abs(self.x[-1]))
        )

    @property
    def undecided(self) -> bool:
        """Return whether some contact is neither closed nor open."""
        return any(h > 0 and not c for h, c in zip(self.high, self.closed, strict=True))

    def visit(self, i: int) -> None:
        """Sharpen the bounds of contact ``i``, and close or open it if they suffice."""
        if self.closed[i] or self.high[i] == 0:
            return
        left_low, left_high, before = self._compression_next_to(i, -1)
        right_low, right_high, after = self._compression_next_to(i, +1)
        give = 1 - 0.5 * before / (before + 1) - 0.5 * after / (after + 1)
        least = (self.overlap[i] - (left_high + right_high) / 2) / give
        most = (self.overlap[i] - (left_low + right_low) / 2) / give
        self.low[i] = max(self.low[i], least)
        self.high[i] = min(self.high[i], most)
        if self.high[i] <= self.rounding:
            self.high[i] = 0.0
        elif self.low[i] > 0:
            self.closed[i] = True

    def _compression_next_to(self, i: int, side: int) -> tuple[float, float, int]:
        """Return bounds on the compression next to ``i`` on a side, were ``i`` open, and L.

        L is the number of contacts of the known chain there. Inside the chain the
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


# ---- one elimination from the left, without iteration
#
# Minimise f A f / 2 - overlap f over f >= 0 with tridiagonal A, contact by contact (Bellman).
# Given the force y on the next contact, the best force on contact i is g_i(y): piecewise linear,
# falling, and 0 beyond some y. From a_i f + b_(i-1) g_(i-1)(f) = overlap_i - b_i y each break
# point (f, g) of g_(i-1) moves to ((overlap_i - a_i f - b_(i-1) g)/b_i, f) of g_i; at most one is
# added and all beyond f = g_i(0) are dropped. The last force is g_n(0), and the others follow
# backwards. Cost O(N) times the break points alive, which are two or three; never more than N.


@compiled
def closed_contacts(
    overlap: Floats, diagonal: Floats, coupling: Floats, closed: NDArray[np.bool_]
) -> None:
    """Set ``closed`` (n,) to the contacts that carry a force under ``overlap`` (n,) [m]."""
    n = overlap.size
    start = np.zeros(n + 1, np.int64)
    y, f = np.zeros(4 * n + 8), np.zeros(4 * n + 8)
    size = 0
    for i in range(n):
        if size + (size - start[i - 1]) + 3 > y.size:
            y, f = np.append(y, np.zeros(y.size)), np.append(f, np.zeros(f.size))
        begin = start[i - 1] if i > 0 else 0
        before = coupling[i - 1] if i > 0 else 0.0
        start[i] = size
        size += _next_response(y, f, begin, size, overlap[i], diagonal[i], before, coupling[i])
    start[n] = size
    force = 0.0
    for i in range(n - 1, -1, -1):
        force = _evaluate(y, f, start[i], start[i + 1], force)
        closed[i] = force > 0


@compiled
def _next_response(
    y: Floats, f: Floats, begin: int, end: int,
    overlap: float, diagonal: float, before: float, coupling: float,
) -> int:  # fmt: skip
    """Write the break points of ``g_i`` at ``end`` from those of ``g_(i-1)``; return how many.

    Those of ``g_(i-1)`` are ``y, f [begin:end]``, y ascending from 0.
    """
    at, total = 0.0, before * f[begin] if end > begin else 0.0
    if overlap <= total:
        y[end] = f[end] = 0.0
        return 1
    lowest, slope, k = total, diagonal, begin + 1
    while k < end:
        reached = diagonal * y[k] + before * f[k]
        if reached >= overlap:
            slope = (reached - total) / (y[k] - at)
            break
        at, total = y[k], reached
        k += 1
    y[end], f[end] = 0.0, at + (overlap - total) / slope
    if coupling == 0:
        return 1
    count = 1
    for p in range(min(k, end) - 1, begin, -1):
        y[end + count] = (overlap - diagonal * y[p] - before * f[p]) / coupling
        f[end + count] = y[p]
        count += 1
    y[end + count], f[end + count] = (overlap - lowest) / coupling, 0.0
    return count + 1


@compiled
def _evaluate(y: Floats, f: Floats, begin: int, end: int, at: float) -> float:
    """Return ``g(at)`` of the break points ``y, f [begin:end]``."""
    for p in range(begin + 1, end):
        if at < y[p]:
            part = (at - y[p - 1]) / (y[p] - y[p - 1])
            return float(f[p - 1] + (f[p] - f[p - 1]) * part)
    return float(f[end - 1])


Flags = NDArray[np.bool_]

_PATIENCE = 10


# ---- block principal pivoting, in O(N) from a warm start
#
# The entries of A beside the diagonal are positive, so A is no M-matrix and the usual one-sided
# methods for tridiagonal problems do not apply. Given a contact set, forces and gaps follow from
# one factorisation (Thomas) of each run of closed contacts. Block principal pivoting (Judice and
# Pires 1994) flips all contacts with the wrong sign at once; from the set of the last step none or
# one pass is needed. Flipping all at once can cycle, so when the number at fault has not fallen
# for ten passes, closed_contacts(), which does not iterate, takes over.


@compiled
def factorise(closed: Flags, diagonal: Floats, coupling: Floats, factor: Floats) -> int:
    """Factorise A on the closed contacts; return the longest run of them.

    ``factor`` (3, n) takes the inverse pivots, and what the forward and the
    backward substitution carry over; all are 0 where open.
    """
    longest = run = 0
    for i in range(closed.size):
        if closed[i]:
            run += 1
            longest = max(longest, run)
            carried = coupling[i - 1] * factor[0, i - 1] if run > 1 else 0.0
            before = coupling[i - 1] if run > 1 else 0.0
            factor[0, i] = 1 / (diagonal[i] - before * carried)
            factor[1, i] = carried
            factor[2, i] = coupling[i] * factor[0, i]
        else:
            run = 0
            factor[0, i] = factor[1, i] = factor[2, i] = 0.0
    return longest


@compiled
def substitute(overlap: Floats, factor: Floats, force: Floats) -> None:
    """Set ``force`` (n,) [N] of the closed contacts, 0 elsewhere, from ``overlap`` (n,) [m]."""
    n = overlap.size
    carried = 0.0
    for i in range(n):
        carried = overlap[i] - factor[1, i] * carried
        force[i] = carried
    carried = 0.0
    for i in range(n - 1, -1, -1):
        carried = factor[0, i] * force[i] - factor[2, i] * carried
        force[i] = carried


@compiled
def flip_wrong(
    overlap: Floats, diagonal: Floats, coupling: Floats,
    force: Floats, closed: Flags, tolerance: float,
) -> int:  # fmt: skip
    """Flip the contacts that pull, or are open and overlap, by more than ``tolerance`` [m].

    Return how many. The forces are those of ``closed`` as it was.
    """
    n = overlap.size
    wrong = 0
    for i in range(n):
        if closed[i]:
            slack = diagonal[i] * force[i]
        else:
            slack = -overlap[i]
            if i > 0:
                slack += coupling[i - 1] * force[i - 1]
            if i < n - 1:
                slack += coupling[i] * force[i + 1]
        if slack < -tolerance:
            closed[i] = not closed[i]
            wrong += 1
    return wrong


@compiled
def solve(
    overlap: Floats, diagonal: Floats, coupling: Floats,
    closed: Flags, factor: Floats, force: Floats, tolerance: float,
) -> int:  # fmt: skip
    """Find ``closed`` and ``force`` (n,) [N] from the set that ``closed`` holds on entry.

    Return the longest run of closed contacts, or -1 if there is no solution to
    ``tolerance`` [m] times the number of contacts, which rounding alone, of
    overlaps far beyond the scale of the tolerance, can bring about.
    """
    fewest, patience = overlap.size + 1, _PATIENCE
    while patience >= 0:
        longest = factorise(closed, diagonal, coupling, factor)
        substitute(overlap, factor, force)
        wrong = flip_wrong(overlap, diagonal, coupling, force, closed, tolerance)
        if wrong == 0:
            return longest
        patience = _PATIENCE if wrong < fewest else patience - 1
        fewest = min(fewest, wrong)
    closed_contacts(overlap, diagonal, coupling, closed)
    longest = factorise(closed, diagonal, coupling, factor)
    substitute(overlap, factor, force)
    allowed = tolerance * overlap.size
    wrong = flip_wrong(overlap, diagonal, coupling, force, closed.copy(), allowed)
    return -1 if wrong else longest


def contact_forces(
    positions: ArrayLike, diameter: ArrayLike, stiffness: ArrayLike, *, deformable: bool = True
) -> Floats:
    """Return the force of every contact (N-1,) [N], from the centres alone.

    ``positions`` (N,) [m] ascend; ``diameter`` [m] and ``stiffness`` [N/m] are
    one value or one for each particle. ``force / stiffness`` is the partial
    compression. Raise RequestError for input out of range.
    """
    particles = np.size(np.asarray(positions))
    d = checked_positive("diameter", "m", diameter, max(particles, 2))
    k = checked_positive("stiffness", "N/m", stiffness, max(particles, 2))
    reach = 0.5 * (d[:-1] + d[1:])
    x = checked_positions(positions, reach if particles > 1 else 1.0)
    overlap = reach - np.diff(x)
    return forces_of_overlaps(overlap, *compliance(k, deformable))


def forces_of_overlaps(overlap: Floats, diagonal: Floats, coupling: Floats) -> Floats:
    """Return the force of every contact (n,) [N] from the overlaps (n,) [m], without warm start.

    ``diagonal`` and ``coupling`` (n,) [m/N] are those of
    :func:`harness.solvers.chain.motion.compliance`.
    """
    if not np.isfinite(overlap).all():
        raise RequestError(f"overlaps = {overlap.tolist()} m: must be finite")
    closed, force = overlap > 0, np.empty_like(overlap)
    tolerance = 1e-15 * float(np.abs(overlap).max())
    factor = np.empty((3, overlap.size))
    if solve(overlap, diagonal, coupling, closed, factor, force, tolerance) < 0:
        raise RequestError(f"overlaps = {overlap.tolist()} m: no contact set fits them")
    return np.maximum(force, 0.0)


# ---- the factorisation of a block, from both ends to the middle
#
# A substitution waits for each result and not for the arithmetic; from both ends there are two
# recurrences to wait for at a time. The contacts are those of a block of the row, n of them from
# low on, as in rk4_deformable.


@compiled
def factorise_from_both_ends(
    closed: Flags,
    diagonal: Floats,
    coupling: Floats,
    low: int,
    n: int,
    pivot: Floats,
    carry: Floats,
) -> None:
    """Factorise the closed contacts of a block from both ends to its contact n // 2.

    Set ``pivot``, the inverse pivots, 0 where open, and ``carry``, what a contact
    hands on to its neighbour towards the middle; both are arrays of the row.
    """
    middle, last = low + n // 2, low + n - 1
    for i in range(low, middle):
        into = coupling[i - 1] * carry[i - 1] if i > low else 0.0
        pivot[i] = 1 / (diagonal[i] - into) if closed[i] else 0.0
        carry[i] = coupling[i] * pivot[i]
    for i in range(last, middle, -1):
        into = coupling[i] * carry[i + 1] if i < last else 0.0
        pivot[i] = 1 / (diagonal[i] - into) if closed[i] else 0.0
        carry[i] = coupling[i - 1] * pivot[i]
    before = coupling[middle - 1] * carry[middle - 1] if middle > low else 0.0
    after = coupling[middle] * carry[middle + 1] if middle < last else 0.0
    pivot[middle] = 1 / (diagonal[middle] - before - after) if closed[middle] else 0.0
    carry[middle] = 0.0


@compiled
def substitute_from_both_ends(
    overlap: Floats, pivot: Floats, carry: Floats, low: int, n: int, force: Floats
) -> None:
    """Set the forces (n + 2,) [N] of the contact set that is factorised, 0 where open.

    ``overlap`` (n,) [m] and ``force`` are arrays of the block.
    """
    pivot, carry = pivot[low : low + n], carry[low : low + n]
    middle = n // 2
    ends = n - 1 - middle  # contacts right of the middle, as many as left of it or one less
    lower, upper = overlap[0], overlap[n - 1]
    force[1], force[n] = lower, upper
    for i in range(1, ends):
        j = n - 1 - i
        lower = overlap[i] - carry[i - 1] * lower
        upper = overlap[j] - carry[j + 1] * upper
        force[i + 1], force[j + 1] = lower, upper
    for i in range(max(ends, 1), middle):
        lower = overlap[i] - carry[i - 1] * lower
        force[i + 1] = lower
    centre = overlap[middle]
    if middle > 0:
        centre -= carry[middle - 1] * force[middle]
    if middle < n - 1:
        centre -= carry[middle + 1] * force[middle + 2]
    centre *= pivot[middle]
    force[middle + 1] = lower = upper = centre
    for i in range(middle - 1, ends - 1, -1):
        lower = pivot[i] * force[i + 1] - carry[i] * lower
        force[i + 1] = lower
    for k in range(min(ends, middle)):
        i = ends - 1 - k
        j = n - ends + k
        lower = pivot[i] * force[i + 1] - carry[i] * lower
        upper = pivot[j] * force[j + 1] - carry[j] * upper
        force[i + 1], force[j + 1] = lower, upper
