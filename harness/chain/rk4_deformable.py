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
from harness.chain.record import Counts, Record, chain_of_grain, with_room, write_sample
from harness.chain.slices import Advance, Plan
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


def begin(chain: Chain, plan: Plan) -> Advance:
    """Return what advances ``chain`` in place, from one step to another.

    Samples: every so many steps, at the end, and whenever the number of
    contacts in the grain's chain has changed. Instead of the rows of the record, it returns minus
    the length of a chain of touching contacts longer than ``plan.longest``, or -1
    where no contact set fits.
    """
    n = chain.diagonal.size
    found = ContactSet(np.zeros(n, np.bool_), np.zeros(n), np.zeros(n))
    # all open: the first stage finds the set, and holds a preloaded row to its longest chain
    factorise_from_both_ends(found.closed, chain.diagonal, chain.beside, 0, n, *found[1:])
    counts = np.array([0, -1])

    def advance(record: Record, first: int, last: int) -> tuple[Record, int]:
        return _advance(chain, found, counts, record, plan, first, last)

    return advance


@compiled
def _advance(
    chain: Chain, found: ContactSet, counts: Counts, record: Record, plan: Plan,
    first: int, last: int,
) -> tuple[Record, int]:  # fmt: skip
    """Do the steps from ``first`` to before ``last``.

    ``counts`` are the rows of the record and the contacts in the grain's chain so far.
    """
    u, v, gravity, step = chain.displacement, chain.velocity, chain.gravity, plan.step
    mobility, diagonal, beside = chain.mobility, chain.diagonal, chain.beside
    tolerance = 1e-14 * chain.length
    n = diagonal.size
    a, b, c, d = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    overlap, force, factor = np.zeros(n), np.zeros(n + 2), np.zeros((3, n))
    pivot, carry = found.pivot, found.carry
    rows, contacts = counts
    for count in range(first, last):
        for stage in range(4):
            shift = 0.0 if stage == 0 else 0.5 * step if stage < 3 else step
            lift = 0.0 if stage < 2 else 0.5 * step * shift
            set_overlaps(u, v, a if stage < 3 else b, 0, n, shift, lift, overlap)
            substitute_from_both_ends(overlap, pivot, carry, 0, n, force)
            if count_wrong(overlap, beside, pivot, 0, 0, n, force, tolerance):
                most = update_contact_set(chain, found, 0, n, overlap, factor, force, tolerance)
                if most < 0 or most > plan.longest:
                    return record, -abs(most)
            if stage == 0:
                touching = chain_of_grain(force[1:-1])
                if touching != contacts or count % plan.every == 0 or count == plan.steps:
                    contacts = touching
                    record = with_room(record, rows)
                    write_sample(record, rows, count * step, chain, u, v, overlap, force[1:-1])
                    rows += 1
                if count == plan.steps:
                    return record, rows
                accelerate(force, mobility, gravity, 0, n, a)
            elif stage < 3:
                accelerate(force, mobility, gravity, 0, n, b if stage == 1 else c)
        accelerate(force, mobility, gravity, 0, n, d)
        move(u, v, u, a, b, c, step)
        kick(v, v, a, b, c, d, step)
    counts[0], counts[1] = rows, contacts
    return record, rows
