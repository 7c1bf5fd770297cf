"""RK4 of the deformable law. A force is felt all along a chain of touching particles at once.

Each stage solves the contact set of the stage before, factorised once and kept,
and checks it; only when it is wrong the contact set is looked for anew. The
substitution runs from both ends to the middle and back, two recurrences at a
time, because it waits for each result and not for the arithmetic.
"""

from __future__ import annotations

import numpy as np

from harness.chain.arrays import Chain, Floats
from harness.chain.compiled import compiled
from harness.chain.complementarity import Flags, solve
from harness.chain.record import Record, chain_of_grain, with_room, write_sample


@compiled
def integrate(
    chain: Chain, record: Record, step: float, steps: int, every: int, longest: int
) -> tuple[Record, int]:
    """Advance ``chain`` in place; return the record and how many rows of it are written.

    Samples: every so many steps, at the end, and whenever the number of
    contacts in the grain's chain has changed. Instead of the rows, return minus
    the length of a chain of touching contacts longer than ``longest``, or -1
    where no contact set fits.
    """
    u, v, mass, gravity = chain.displacement, chain.velocity, chain.mass, chain.gravity
    mobility, diagonal, beside = chain.mobility, chain.diagonal, chain.beside
    tolerance = 1e-14 * chain.length
    n = diagonal.size
    a, b, c = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    overlap, force, closed = np.zeros(n), np.zeros(n), np.zeros(n, np.bool_)
    factor, twisted = np.zeros((3, n)), np.zeros((2, n))
    # all open: the first stage finds the set, and holds a preloaded row to its longest chain
    factorise_from_both_ends(closed, diagonal, beside, twisted)
    pivot, carry = twisted[0], twisted[1]
    rows, contacts = 0, -1
    for count in range(steps + 1):
        for stage in range(4):
            shift = 0.0 if stage == 0 else 0.5 * step if stage < 3 else step
            lift = 0.0 if stage < 2 else 0.5 * step * shift
            _overlaps(u, v, a if stage < 3 else b, shift, lift, overlap)
            substitute_from_both_ends(overlap, pivot, carry, force)
            if _wrong(overlap, beside, pivot, force, tolerance):
                found = solve(overlap, diagonal, beside, closed, factor, force, tolerance)
                if found < 0 or found > longest:
                    return record, -abs(found)
                factorise_from_both_ends(closed, diagonal, beside, twisted)
            if stage == 0:
                touching = chain_of_grain(force)
                if touching != contacts or count % every == 0 or count == steps:
                    contacts = touching
                    record = with_room(record, rows)
                    write_sample(record, rows, count * step, u, v, overlap, force, mass, gravity)
                    rows += 1
                if count == steps:
                    return record, rows
                _accelerate(force, mobility, gravity, a)
            elif stage < 3:
                _accelerate(force, mobility, gravity, b if stage == 1 else c)
        _finish(u, v, a, b, c, force, mobility, gravity, step)
    return record, rows


@compiled
def factorise_from_both_ends(
    closed: Flags, diagonal: Floats, beside: Floats, twisted: Floats
) -> None:
    """Factorise the closed contacts from both ends to contact n // 2.

    ``twisted`` (2, n): the inverse pivots, 0 where open, and what a contact
    hands on to its neighbour towards the middle.
    """
    n = closed.size
    middle = n // 2
    for i in range(middle):
        into = beside[i - 1] * twisted[1, i - 1] if i > 0 else 0.0
        twisted[0, i] = 1 / (diagonal[i] - into) if closed[i] else 0.0
        twisted[1, i] = beside[i] * twisted[0, i]
    for i in range(n - 1, middle, -1):
        into = beside[i] * twisted[1, i + 1] if i < n - 1 else 0.0
        twisted[0, i] = 1 / (diagonal[i] - into) if closed[i] else 0.0
        twisted[1, i] = beside[i - 1] * twisted[0, i]
    left = beside[middle - 1] * twisted[1, middle - 1] if middle > 0 else 0.0
    right = beside[middle] * twisted[1, middle + 1] if middle < n - 1 else 0.0
    twisted[0, middle] = 1 / (diagonal[middle] - left - right) if closed[middle] else 0.0
    twisted[1, middle] = 0.0


@compiled
def substitute_from_both_ends(overlap: Floats, pivot: Floats, carry: Floats, force: Floats) -> None:
    """Set the forces (n,) [N] of the contact set that is factorised, 0 where open."""
    n = overlap.size
    middle = n // 2
    ends = n - 1 - middle  # contacts right of the middle, as many as left of it or one less
    force[0], force[n - 1] = overlap[0], overlap[n - 1]
    left, right = overlap[0], overlap[n - 1]
    for i in range(1, ends):
        j = n - 1 - i
        left = overlap[i] - carry[i - 1] * left
        right = overlap[j] - carry[j + 1] * right
        force[i], force[j] = left, right
    for i in range(max(ends, 1), middle):
        left = overlap[i] - carry[i - 1] * left
        force[i] = left
    centre = overlap[middle]
    if middle > 0:
        centre -= carry[middle - 1] * force[middle - 1]
    if middle < n - 1:
        centre -= carry[middle + 1] * force[middle + 1]
    centre *= pivot[middle]
    force[middle] = left = right = centre
    for i in range(middle - 1, ends - 1, -1):
        left = pivot[i] * force[i] - carry[i] * left
        force[i] = left
    for k in range(min(ends, middle)):
        i = ends - 1 - k
        j = n - ends + k
        left = pivot[i] * force[i] - carry[i] * left
        right = pivot[j] * force[j] - carry[j] * right
        force[i], force[j] = left, right


@compiled
def _overlaps(u: Floats, v: Floats, a: Floats, shift: float, lift: float, overlap: Floats) -> None:
    """Set the overlaps (n,) [m] at ``u + shift v + lift a``."""
    for i in range(overlap.size):
        overlap[i] = (u[i] - u[i + 1]) + shift * (v[i] - v[i + 1]) + lift * (a[i] - a[i + 1])


@compiled
def _wrong(overlap: Floats, beside: Floats, pivot: Floats, force: Floats, tolerance: float) -> int:
    """Return how many contacts pull, or are open and overlap, by more than ``tolerance`` [m]."""
    n = overlap.size
    wrong = 0
    for i in range(1, n - 1):
        gap = beside[i - 1] * force[i - 1] + beside[i] * force[i + 1] - overlap[i]
        wrong += (gap if pivot[i] == 0 else force[i]) < -tolerance * (
            1.0 if pivot[i] == 0 else pivot[i]
        )
    first = beside[0] * force[1] - overlap[0] if n > 1 else -overlap[0]
    last = beside[n - 2] * force[n - 2] - overlap[n - 1] if n > 1 else first
    for i, gap in ((0, first), (n - 1, last)):
        wrong += gap < -tolerance if pivot[i] == 0 else force[i] < -tolerance * pivot[i]
    return wrong


@compiled
def _accelerate(force: Floats, mobility: Floats, gravity: Floats, acceleration: Floats) -> None:
    """Set the accelerations (N,) [m/s2] from the contact forces (n,) [N]."""
    n = force.size
    acceleration[0] = gravity[0] - force[0] * mobility[0]
    for i in range(1, n):
        acceleration[i] = (force[i - 1] - force[i]) * mobility[i] + gravity[i]
    acceleration[n] = gravity[n] + force[n - 1] * mobility[n]


@compiled
def _finish(
    u: Floats, v: Floats, a: Floats, b: Floats, c: Floats,
    force: Floats, mobility: Floats, gravity: Floats, step: float,
) -> None:  # fmt: skip
    """Complete the step with the forces (n,) [N] of the fourth stage."""
    n = force.size
    square, sixth = step**2 / 6, step / 6
    d = gravity[0] - force[0] * mobility[0]
    u[0] += step * v[0] + square * (a[0] + b[0] + c[0])
    v[0] += sixth * (a[0] + 2 * (b[0] + c[0]) + d)
    for i in range(1, n):
        d = (force[i - 1] - force[i]) * mobility[i] + gravity[i]
        u[i] += step * v[i] + square * (a[i] + b[i] + c[i])
        v[i] += sixth * (a[i] + 2 * (b[i] + c[i]) + d)
    d = gravity[n] + force[n - 1] * mobility[n]
    u[n] += step * v[n] + square * (a[n] + b[n] + c[n])
    v[n] += sixth * (a[n] + 2 * (b[n] + c[n]) + d)
