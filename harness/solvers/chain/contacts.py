"""Which contacts of a chain touch, and how hard: one linear complementarity problem.

With the overlaps given, the forces f of the contacts solve

    w = A f - overlap >= 0,   f >= 0,   f w = 0

with the symmetric positive definite, tridiagonal A of :class:`harness.solvers.chain.motion.Chain`:
there is one solution for all positions (Cottle, Pang and Stone 1992, theorem 3.1.6). The set of the
step before is corrected by block principal pivoting (Judice and Pires 1994): all contacts of the
wrong sign are exchanged at once, and the last one alone where that cycles, which ends for every
such A (Murty 1974). A pass is O(n), and a set that still holds needs none.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from harness.compiled import compiled
from harness.errors import RequestError
from harness.solvers.chain.motion import Flags, Floats, compliance

PATIENCE = 10  # passes without fewer wrong contacts before they are exchanged one by one
MOST_PASSES = 1000  # one by one, for each contact


def contact_forces(
    positions: ArrayLike, diameter: ArrayLike, stiffness: ArrayLike, *, deformable: bool = True
) -> Floats:
    """Return the force of every contact (N - 1,) [N], from the centres alone.

    ``positions`` (N,) [m] ascend; ``diameter`` [m] and ``stiffness`` [N/m] are one value or one
    for each particle. Raise RequestError for neighbours closer than half their touching distance.
    """
    x = np.asarray(positions, dtype=float)
    d, k = (np.broadcast_to(np.asarray(part, float), x.shape) for part in (diameter, stiffness))
    reach = 0.5 * (d[:-1] + d[1:])
    check_distances(x, reach)
    return forces_of_overlaps(reach - np.diff(x), *compliance(k, deformable))


def check_distances(x: Floats, reach: Floats | float) -> None:
    """Raise RequestError unless neighbours are at least half of ``reach`` [m] from each other."""
    if not (np.diff(x) >= 0.5 * np.asarray(reach)).all():
        raise RequestError(
            f"positions = {x.tolist()} m: must ascend, neighbours at least half the distance "
            "from each other at which they touch"
        )


def forces_of_overlaps(overlap: Floats, diagonal: Floats, coupling: Floats) -> Floats:
    """Return the force of every contact (n,) [N] from the overlaps (n,) [m], which are finite.

    ``diagonal`` and ``coupling`` (n,) [m/N] are those of :class:`Chain`.
    """
    closed, force, factor = overlap > 0.0, np.empty_like(overlap), np.empty((3, overlap.size))
    factorise(closed, diagonal, coupling, factor)
    tolerance = 1e-15 * float(np.abs(overlap).max())
    if not solve(overlap, diagonal, coupling, closed, factor, force, tolerance):
        raise RequestError(f"overlaps = {overlap.tolist()} m: no contact set fits them")
    return np.maximum(force, 0.0)


@compiled
def solve(
    overlap: Floats, diagonal: Floats, coupling: Floats,
    closed: Flags, factor: Floats, force: Floats, tolerance: float,
) -> bool:  # fmt: skip
    """Find ``closed`` and ``force`` (n,) [N], from the set and its factors on entry.

    Return False where rounding leaves no set with gaps above -``tolerance`` [m], times n.
    """
    n = overlap.size
    fewest, patience = n + 1, PATIENCE
    for _ in range(MOST_PASSES + MOST_PASSES * n):
        substitute(overlap, factor, force)
        alone = patience < 0
        allowed = tolerance * n if alone else tolerance
        wrong = _exchange_wrong(overlap, diagonal, coupling, force, closed, allowed, alone)
        if wrong == 0:
            return True
        patience = PATIENCE if wrong < fewest else patience - 1
        fewest = min(fewest, wrong)
        factorise(closed, diagonal, coupling, factor)
    return False


@compiled
def _exchange_wrong(
    overlap: Floats, diagonal: Floats, coupling: Floats,
    force: Floats, closed: Flags, tolerance: float, last_only: bool,
) -> int:  # fmt: skip
    """Exchange the contacts that pull, or are open and overlap; return how many are wrong."""
    n, wrong, last = overlap.size, 0, -1
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
            last, wrong = i, wrong + 1
            if not last_only:
                closed[i] = not closed[i]
    if last_only and wrong:
        closed[last] = not closed[last]
    return wrong


@compiled
def factorise(closed: Flags, diagonal: Floats, coupling: Floats, factor: Floats) -> None:
    """Factorise A on the closed contacts (Thomas).

    ``factor`` (3, n) takes the inverse pivots, and the multipliers of the forward and the backward
    substitution; all are 0 where open.
    """
    before = pivot = 0.0
    for i in range(closed.size):
        carried = before * pivot
        pivot = 1.0 / (diagonal[i] - before * carried) if closed[i] else 0.0
        factor[0, i] = pivot
        factor[1, i] = carried if closed[i] else 0.0
        before = coupling[i]
        factor[2, i] = before * pivot


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
