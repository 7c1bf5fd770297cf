"""What the stages of RK4 are made of, deformable law.

They work on a block of a row: n contacts from ``low`` on and the n + 1 particles
that they join, or the whole row. Arrays of the row are read from ``low`` on, its
constant properties from ``at`` on, where equal particles have the same; overlaps,
forces and accelerations are arrays of the block, from 0 on. Forces stand between
two zeros, that of contact i of the block at ``i + 1``.

Each function works on slices that begin at 0: an index that is known not to be
negative is what lets the compiler take several particles at a time.
"""

from __future__ import annotations

from harness.chain.arrays import Floats
from harness.chain.compiled import compiled
from harness.chain.complementarity import Flags, solve
from harness.chain.twisted import factorise_from_both_ends

STAGES = 4


@compiled
def stage_shift(stage: int, step: float) -> tuple[float, float]:
    """Return s [s] and l [s2] of a stage at ``u + s v + l a``, a from two stages before."""
    shift = 0.0 if stage == 0 else 0.5 * step if stage < STAGES - 1 else step
    return shift, 0.0 if stage < 2 else 0.5 * step * shift


@compiled
def set_overlaps(
    u: Floats, v: Floats, a: Floats, low: int, n: int, shift: float, lift: float, overlap: Floats
) -> None:
    """Set the overlaps (n,) [m] at ``u + shift v + lift a``."""
    x, w = u[low : low + n + 1], v[low : low + n + 1]
    for i in range(n):
        overlap[i] = (x[i] - x[i + 1]) + shift * (w[i] - w[i + 1]) + lift * (a[i] - a[i + 1])


@compiled
def in_free_flight(
    u: Floats, v: Floats, closed: Flags, gravity: Floats, at: int, low: int, n: int, step: float,
    tolerance: float,
) -> bool:  # fmt: skip
    """Return whether the contacts of a block are open in all stages, to ``tolerance`` [m].

    If none is closed at the start and none overlaps under gravity alone, no force is
    the solution. Each overlap of the second and the third stage is the mean of that of
    the first and another: at ``u + step v`` or in the fourth.
    """
    for flag in closed[low : low + n]:
        if flag:
            return False
    x, w, g = u[low : low + n + 1], v[low : low + n + 1], gravity[at : at + n + 1]
    lift, meeting = 0.5 * step**2, 0
    for i in range(n):
        overlap = x[i] - x[i + 1]
        later = overlap + step * (w[i] - w[i + 1])
        last = later + lift * (g[i] - g[i + 1])
        meeting += max(overlap, later, last) > tolerance
    return meeting == 0


@compiled
def count_wrong(
    overlap: Floats, beside: Floats, pivot: Floats, at: int, low: int, n: int, force: Floats,
    tolerance: float,
) -> int:  # fmt: skip
    """Return how many contacts pull, or are open and overlap, by more than ``tolerance`` [m]."""
    couple, inverse = beside[at : at + n], pivot[low : low + n]
    gap = couple[0] * force[2] - overlap[0]
    wrong = int(
        (gap if inverse[0] == 0 else force[1])
        < -tolerance * (1.0 if inverse[0] == 0 else inverse[0])
    )
    for i in range(1, n):
        gap = couple[i - 1] * force[i] + couple[i] * force[i + 2] - overlap[i]
        wrong += (gap if inverse[i] == 0 else force[i + 1]) < -tolerance * (
            1.0 if inverse[i] == 0 else inverse[i]
        )
    return wrong


@compiled
def update_contact_set(
    overlap: Floats, diagonal: Floats, beside: Floats, closed: Flags, pivot: Floats, carry: Floats,
    low: int, n: int, factor: Floats, force: Floats, tolerance: float,
) -> int:  # fmt: skip
    """Find the contact set of a block from the last one, its forces and its factors.

    Return as :func:`harness.chain.complementarity.solve` does.
    """
    row = slice(low, low + n)
    found = solve(
        overlap[:n], diagonal[row], beside[row], closed[row], factor[:, :n], force[1 : n + 1],
        tolerance,
    )  # fmt: skip
    factorise_from_both_ends(closed, diagonal, beside, low, n, pivot, carry)
    return found


@compiled
def accelerate(
    force: Floats, mobility: Floats, gravity: Floats, at: int, n: int, acceleration: Floats
) -> None:
    """Set the accelerations (n + 1,) [m/s2] from the forces (n + 2,) [N]."""
    m, g = mobility[at : at + n + 1], gravity[at : at + n + 1]
    for i in range(n + 1):
        acceleration[i] = (force[i] - force[i + 1]) * m[i] + g[i]


@compiled
def finish(
    u: Floats, v: Floats, new_u: Floats, new_v: Floats, a: Floats, b: Floats, c: Floats,
    force: Floats, mobility: Floats, gravity: Floats, at: int, low: int, n: int, step: float,
) -> None:  # fmt: skip
    """Set the state after the step from the forces (n + 2,) [N] of the fourth stage."""
    square, sixth = step**2 / 6, step / 6
    m, g = mobility[at : at + n + 1], gravity[at : at + n + 1]
    x, w, y, z = (
        u[low : low + n + 1],
        v[low : low + n + 1],
        new_u[low : low + n + 1],
        new_v[low : low + n + 1],
    )
    for i in range(n + 1):
        d = (force[i] - force[i + 1]) * m[i] + g[i]
        y[i] = x[i] + step * w[i] + square * (a[i] + b[i] + c[i])
        z[i] = w[i] + sixth * (a[i] + 2 * (b[i] + c[i]) + d)
