"""Stages of RK4 under the deformable law.

They work on a block of a row: n contacts from ``low`` on and the n + 1 particles
that they join, or the whole row. Arrays of the row are read from ``low`` on, its
constant properties from ``at`` on, where equal particles have the same; overlaps,
forces and accelerations are arrays of the block, from 0 on. Forces stand between
two zeros, that of contact i of the block at ``i + 1``.

Each function works on slices that begin at 0: an index that is known not to be
negative is what lets the compiler take several particles at a time.
"""

from __future__ import annotations

from typing import NamedTuple

from harness.chain.arrays import Chain, Floats
from harness.chain.compiled import compiled
from harness.chain.complementarity import Flags, solve
from harness.chain.twisted import factorise_from_both_ends

STAGES = 4


class ContactSet(NamedTuple):
    """The contact set of a row of n contacts, and its factors from both ends."""

    closed: Flags  # (n,)
    pivot: Floats  # (n,)
    carry: Floats  # (n,)


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
    x: Floats, w: Floats, closed: Flags, gravity: Floats, step: float, tolerance: float
) -> bool:
    """Return whether the contacts of a block (n,) are open in all stages, to ``tolerance`` [m].

    Displacements ``x`` [m], velocities ``w`` [m/s] and ``gravity`` [m/s2] are those of its
    particles (n + 1,). If none is closed at the start and none overlaps under gravity alone, no
    force is the solution. Each overlap of the second and the third stage is the mean of that of
    the first and another: at ``x + step w`` or in the fourth.
    """
    for flag in closed:
        if flag:
            return False
    lift, meeting = 0.5 * step**2, 0
    for i in range(closed.size):
        overlap = x[i] - x[i + 1]
        later = overlap + step * (w[i] - w[i + 1])
        last = later + lift * (gravity[i] - gravity[i + 1])
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
    chain: Chain, contacts: ContactSet, low: int, n: int,
    overlap: Floats, factor: Floats, force: Floats, tolerance: float,
) -> int:  # fmt: skip
    """Find the contact set of a block from the last one, its forces and its factors.

    Return as :func:`harness.chain.complementarity.solve` does.
    """
    row = slice(low, low + n)
    found = solve(
        overlap[:n], chain.diagonal[row], chain.beside[row], contacts.closed[row], factor[:, :n],
        force[1 : n + 1], tolerance,
    )  # fmt: skip
    factorise_from_both_ends(
        contacts.closed, chain.diagonal, chain.beside, low, n, contacts.pivot, contacts.carry
    )
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
def move(x: Floats, w: Floats, after: Floats, a: Floats, b: Floats, c: Floats, step: float) -> None:
    """Set the displacements ``after`` the step [m] from the accelerations of three stages.

    ``x`` [m] and ``w`` [m/s] are the state before it. ``after`` may be ``x`` itself.
    """
    square = step**2 / 6
    for i in range(after.size):
        after[i] = x[i] + step * w[i] + square * (a[i] + b[i] + c[i])


@compiled
def kick(w: Floats, after: Floats, a: Floats, b: Floats, c: Floats, d: Floats, step: float) -> None:
    """Set the velocities ``after`` the step [m/s] from the accelerations of four stages."""
    sixth = step / 6
    for i in range(after.size):
        after[i] = w[i] + sixth * (a[i] + 2 * (b[i] + c[i]) + d[i])
