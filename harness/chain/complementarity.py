"""Contact forces of a chain as a linear complementarity problem, in O(N) from a warm start.

    w = A f - overlap >= 0,   f >= 0,   f w = 0

with A symmetric positive definite and tridiagonal (see
:class:`harness.chain.arrays.Chain`): one solution, whatever the positions. Its
entries beside the diagonal are positive, so A is no M-matrix and the usual
one-sided methods for tridiagonal problems do not apply.

Given a contact set, forces and gaps follow from one factorisation (Thomas) of
each run of closed contacts. Block principal pivoting (Judice and Pires 1994)
flips all contacts with the wrong sign at once; from the set of the last step
none or one pass is needed. Flipping all at once can cycle, so when the number
at fault has not fallen for ten passes, :mod:`harness.chain.elimination`, which
does not iterate, takes over.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.chain.arrays import Floats, compliance
from harness.chain.compiled import compiled
from harness.chain.elimination import closed_contacts
from harness.chain.validate import checked_positions, checked_positive
from harness.errors import RequestError

Flags = NDArray[np.bool_]

_PATIENCE = 10


@compiled
def factorise(closed: Flags, diagonal: Floats, beside: Floats, factor: Floats) -> int:
    """Factorise A on the closed contacts; return the longest run of them.

    ``factor`` (3, n) takes the inverse pivots, and what the forward and the
    backward substitution carry over; all are 0 where open.
    """
    longest = run = 0
    for i in range(closed.size):
        if closed[i]:
            run += 1
            longest = max(longest, run)
            carried = beside[i - 1] * factor[0, i - 1] if run > 1 else 0.0
            before = beside[i - 1] if run > 1 else 0.0
            factor[0, i] = 1 / (diagonal[i] - before * carried)
            factor[1, i] = carried
            factor[2, i] = beside[i] * factor[0, i]
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
    overlap: Floats, diagonal: Floats, beside: Floats,
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
                slack += beside[i - 1] * force[i - 1]
            if i < n - 1:
                slack += beside[i] * force[i + 1]
        if slack < -tolerance:
            closed[i] = not closed[i]
            wrong += 1
    return wrong


@compiled
def solve(
    overlap: Floats, diagonal: Floats, beside: Floats,
    closed: Flags, factor: Floats, force: Floats, tolerance: float,
) -> int:  # fmt: skip
    """Find ``closed`` and ``force`` (n,) [N] from the set that ``closed`` holds on entry.

    Return the longest run of closed contacts, or -1 if there is no solution to
    ``tolerance`` [m] times the number of contacts, which rounding alone, of
    overlaps far beyond the scale of the tolerance, can bring about.
    """
    fewest, patience = overlap.size + 1, _PATIENCE
    while patience >= 0:
        longest = factorise(closed, diagonal, beside, factor)
        substitute(overlap, factor, force)
        wrong = flip_wrong(overlap, diagonal, beside, force, closed, tolerance)
        if wrong == 0:
            return longest
        patience = _PATIENCE if wrong < fewest else patience - 1
        fewest = min(fewest, wrong)
    closed_contacts(overlap, diagonal, beside, closed)
    longest = factorise(closed, diagonal, beside, factor)
    substitute(overlap, factor, force)
    allowed = tolerance * overlap.size
    wrong = flip_wrong(overlap, diagonal, beside, force, closed.copy(), allowed)
    return -1 if wrong else longest


def contact_forces(
    positions: ArrayLike, diameter: ArrayLike, stiffness: ArrayLike, *, deformable: bool = True
) -> Floats:
    """Return the force of every contact (N-1,) [N], from the centres alone.

    ``positions`` (N,) [m] ascend; ``diameter`` [m] and ``stiffness`` [N/m] are
    one value or one for each particle. ``force / stiffness`` is the partial
    compression. Raise RequestError for input that cannot be.
    """
    particles = np.size(np.asarray(positions))
    d = checked_positive("diameter", "m", diameter, max(particles, 2))
    k = checked_positive("stiffness", "N/m", stiffness, max(particles, 2))
    reach = 0.5 * (d[:-1] + d[1:])
    x = checked_positions(positions, reach if particles > 1 else 1.0)
    overlap = reach - np.diff(x)
    return forces_of_overlaps(overlap, *compliance(k, deformable))


def forces_of_overlaps(overlap: Floats, diagonal: Floats, beside: Floats) -> Floats:
    """Return the force of every contact (n,) [N] from the overlaps (n,) [m], without warm start.

    ``diagonal`` and ``beside`` (n,) [m/N] are those of :func:`harness.chain.arrays.compliance`.
    """
    if not np.isfinite(overlap).all():
        raise RequestError(f"overlaps = {overlap.tolist()} m: must be finite")
    closed, force = overlap > 0, np.empty_like(overlap)
    tolerance = 1e-15 * float(np.abs(overlap).max())
    factor = np.empty((3, overlap.size))
    if solve(overlap, diagonal, beside, closed, factor, force, tolerance) < 0:
        raise RequestError(f"overlaps = {overlap.tolist()} m: no contact set fits them")
    return np.maximum(force, 0.0)
