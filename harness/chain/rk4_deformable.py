"""RK4 under the deformable law, where a force acts all along a touching chain at once.

Each stage solves the contact set of the stage before, factorised once and kept,
and checks it; only when it is wrong the contact set is looked for anew. This
kernel takes the row as a whole: with the least to do about a step, it is the one
for short rows. :mod:`harness.chain.rk4_long_rows` is the one for long rows.
"""

from __future__ import annotations

import numpy as np

from harness.chain.arrays import Chain
from harness.chain.compiled import compiled
from harness.chain.record import Record, chain_of_grain, with_room, write_sample
from harness.chain.stages import (
    ContactSet,
    accelerate,
    count_wrong,
    kick,
    move,
    set_overlaps,
    update_contact_set,
)
from harness.chain.twisted import factorise_from_both_ends, substitute_from_both_ends


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
    u, v, gravity = chain.displacement, chain.velocity, chain.gravity
    mobility, diagonal, beside = chain.mobility, chain.diagonal, chain.beside
    tolerance = 1e-14 * chain.length
    n = diagonal.size
    a, b, c, d = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    overlap, force, closed = np.zeros(n), np.zeros(n + 2), np.zeros(n, np.bool_)
    factor, pivot, carry = np.zeros((3, n)), np.zeros(n), np.zeros(n)
    # all open: the first stage finds the set, and holds a preloaded row to its longest chain
    factorise_from_both_ends(closed, diagonal, beside, 0, n, pivot, carry)
    found = ContactSet(closed, pivot, carry)
    rows, contacts = 0, -1
    for count in range(steps + 1):
        for stage in range(4):
            shift = 0.0 if stage == 0 else 0.5 * step if stage < 3 else step
            lift = 0.0 if stage < 2 else 0.5 * step * shift
            set_overlaps(u, v, a if stage < 3 else b, 0, n, shift, lift, overlap)
            substitute_from_both_ends(overlap, pivot, carry, 0, n, force)
            if count_wrong(overlap, beside, pivot, 0, 0, n, force, tolerance):
                most = update_contact_set(chain, found, 0, n, overlap, factor, force, tolerance)
                if most < 0 or most > longest:
                    return record, -abs(most)
            if stage == 0:
                touching = chain_of_grain(force[1:-1])
                if touching != contacts or count % every == 0 or count == steps:
                    contacts = touching
                    record = with_room(record, rows)
                    write_sample(record, rows, count * step, chain, u, v, overlap, force[1:-1])
                    rows += 1
                if count == steps:
                    return record, rows
                accelerate(force, mobility, gravity, 0, n, a)
            elif stage < 3:
                accelerate(force, mobility, gravity, 0, n, b if stage == 1 else c)
        accelerate(force, mobility, gravity, 0, n, d)
        move(u, v, u, a, b, c, step)
        kick(v, v, a, b, c, d, step)
    return record, rows
