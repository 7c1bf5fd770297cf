"""RK4 under the deformable law in a long row, block by block.

The stages of a block stay in the cache, and a change of contacts is looked for
among few: the cost of a particle hardly depends on how many there are. Blocks in
which nothing touches fall freely, and need neither stages nor factors. Blocks
part at open contacts (:mod:`harness.chain.block_partition`). When one of these closes in a
stage after all, the step is done again with the whole row as one block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from harness.chain.arrays import Chain, Floats, equal_run
from harness.chain.block_partition import Cuts, end_of_block, no_cuts, stays_open
from harness.chain.compiled import compiled
from harness.chain.record import Counts, Record, chain_of_grain, with_room, write_sample
from harness.chain.slices import Advance, Plan
from harness.chain.stages import (
    STAGES,
    ContactSet,
    accelerate,
    count_wrong,
    in_free_flight,
    kick,
    move,
    set_overlaps,
    stage_shift,
    update_contact_set,
)
from harness.chain.twisted import factorise_from_both_ends, substitute_from_both_ends


class _Row(NamedTuple):
    """What a step needs to know and keeps of N particles and n contacts."""

    u: Floats  # (N,) [m]
    v: Floats  # (N,) [m/s]
    next_u: Floats  # (N,) [m] after the step
    next_v: Floats  # (N,) [m/s]
    contacts: ContactSet
    cuts: Cuts  # where blocks part
    overlap: Floats  # (n,) [m] at a sample
    force: Floats  # (n,) [N] at a sample


class _Room(NamedTuple):
    """Arrays of a block, which may be the whole row."""

    overlap: Floats  # (n,) [m]
    force: Floats  # (n + 2,) [N] between two zeros
    a: Floats  # (N,) [m/s2] accelerations of four stages
    b: Floats  # (N,) [m/s2]
    c: Floats  # (N,) [m/s2]
    d: Floats  # (N,) [m/s2]
    factor: Floats  # (3, n) of the search for a contact set
    first: Floats  # (STAGES,) [N] force of the first contact
    last: Floats  # (STAGES,) [N] force of the last contact
    before: Floats  # (STAGES,) [N] force of the last contact of the block before


class _Limits(NamedTuple):
    """What a step is held to; the equal particles are those of ``equal_run``."""

    step: float  # [s]
    tolerance: float  # [m] by which a gap may be negative
    longest: int  # touching contacts in a row
    equal_from: int
    equal_to: int


def begin(chain: Chain, plan: Plan) -> Advance:
    """Return what advances ``chain`` in place, as :func:`harness.chain.rk4_deformable.begin`."""
    particles, contacts = chain.mass.size, chain.diagonal.size
    state, factors, sample = (
        np.empty((2, particles)),
        np.empty((2, contacts)),
        np.empty((2, contacts)),
    )
    row = _Row(
        chain.displacement, chain.velocity, state[0], state[1],
        ContactSet(np.zeros(contacts, np.bool_), factors[0], factors[1]), no_cuts(particles),
        sample[0], sample[1],
    )  # fmt: skip
    stages, edges = np.empty((4, particles)), np.zeros((3, STAGES))
    room = _Room(
        np.empty(contacts), np.empty(contacts + 2), stages[0], stages[1], stages[2], stages[3],
        np.empty((3, contacts)), edges[0], edges[1], edges[2],
    )  # fmt: skip
    limits = _Limits(plan.step, 1e-14 * chain.length, plan.longest, *equal_run(chain))
    counts = np.array([0, -1])

    def advance(record: Record, first: int, last: int) -> tuple[Record, int]:
        return _advance(chain, row, room, limits, counts, record, plan, first, last)

    return advance


@compiled
def _advance(
    chain: Chain, row: _Row, room: _Room, limits: _Limits, counts: Counts, record: Record,
    plan: Plan, first: int, last: int,
) -> tuple[Record, int]:  # fmt: skip
    """Do the steps from ``first`` to before ``last``.

    ``counts`` are the rows of the record and the contacts in the grain's chain so far.
    """
    rows, contacts = counts
    # all open: the first stage finds the set, and holds a preloaded row to its longest chain
    renewed = first == 0
    u, v, next_u, next_v = row.u, row.v, row.next_u, row.next_v
    for count in range(first, last):
        here = _Row(u, v, next_u, next_v, row.contacts, row.cuts, row.overlap, row.force)
        touching = contacts
        if count < plan.steps:
            touching = _advance_row(chain, here, room, limits, STAGES, renewed)
            renewed = False
        if touching != contacts or count % plan.every == 0 or count == plan.steps:
            if touching >= 0 or count == plan.steps:
                touching = _advance_row(chain, here, room, limits, 1, renewed)
            if touching < 0:
                return record, touching
            contacts = touching
            record = with_room(record, rows)
            write_sample(
                record, rows, count * limits.step, chain, u, v, row.overlap, row.force
            )  # fmt: skip
            rows += 1
        if count < plan.steps:
            u, next_u, v, next_v = next_u, u, next_v, v
    chain.displacement[:] = u
    chain.velocity[:] = v
    counts[0], counts[1] = rows, contacts
    return record, rows


@compiled
def _advance_row(
    chain: Chain, row: _Row, room: _Room, limits: _Limits, stages: int, renewed: bool
) -> int:
    """Do so many ``stages`` in the row; return how many contacts touch from the grain on.

    One stage alone leaves its overlaps and forces in ``row``. ``renewed`` says that
    the first block has no factors yet. Return a negative number as
    :func:`harness.chain.rk4_deformable.begin` does.
    """
    particles = row.u.size
    low, window, touching = 0, 0, 0
    while low < particles:
        high, window, moved = end_of_block(
            row.u, row.v, row.contacts.closed, row.cuts, window, limits.step
        )
        n = high - low - 1
        if moved or renewed:
            room.a[: n + 1] = 0.0
            factorise_from_both_ends(
                row.contacts.closed, chain.diagonal, chain.beside, low, n,
                row.contacts.pivot, row.contacts.carry,
            )  # fmt: skip
        renewed = moved
        found = _advance_block(chain, row, room, limits, low, n, stages)
        if found < 0:
            return found
        if stages == 1:
            row.overlap[low : high - 1] = room.overlap[:n]
            row.force[low : high - 1] = room.force[1 : n + 1]
        if low == 0:
            touching = found
        elif stages == 1:
            row.overlap[low - 1], row.force[low - 1] = row.u[low - 1] - row.u[low], 0.0
        elif not stays_open(
            chain, row.u, row.v, room.before, room.first, low - 1, limits.step, limits.tolerance
        ):  # fmt: skip
            row.cuts[:] = 0
            low, window, renewed = 0, row.cuts.size, True
            continue
        room.before[:] = room.last
        low = high
    return touching


@compiled
def _advance_block(
    chain: Chain, row: _Row, room: _Room, limits: _Limits, low: int, n: int, stages: int
) -> int:
    """Do so many ``stages`` in the block of n contacts from ``low`` on; return as the row does."""
    within = low >= limits.equal_from and low + n < limits.equal_to
    at = limits.equal_from if within else low
    mobility, gravity, beside, force = chain.mobility, chain.gravity, chain.beside, room.force
    contacts, here, properties = row.contacts, slice(low, low + n + 1), slice(at, at + n + 1)
    force[0] = force[n + 1] = 0.0
    touching = 0
    falls = stages == STAGES and in_free_flight(
        row.u[here], row.v[here], contacts.closed[low : low + n], gravity[properties],
        limits.step, limits.tolerance,
    )  # fmt: skip
    if falls:
        _fall(room, gravity, at, n)
    for stage in range(0 if falls else stages):
        shift, lift = stage_shift(stage, limits.step)
        a = room.a if stage < STAGES - 1 else room.b
        set_overlaps(row.u, row.v, a, low, n, shift, lift, room.overlap)
        substitute_from_both_ends(room.overlap, contacts.pivot, contacts.carry, low, n, force)
        if count_wrong(room.overlap, beside, contacts.pivot, at, low, n, force, limits.tolerance):
            found = update_contact_set(
                chain, contacts, low, n, room.overlap, room.factor, force, limits.tolerance
            )  # fmt: skip
            if found < 0 or found > limits.longest:
                return -abs(found)
        room.first[stage], room.last[stage] = force[1], force[n]
        if stage == 0:
            touching = chain_of_grain(force[1 : n + 1])
        if stage < STAGES - 1:
            to = room.a if stage == 0 else room.b if stage == 1 else room.c
            accelerate(force, mobility, gravity, at, n, to)
    if stages == STAGES:
        # after free flight too: equal particles on both sides of a cut stay equal to the last bit
        x, w, y, z = row.u[here], row.v[here], row.next_u[here], row.next_v[here]
        accelerate(force, mobility, gravity, at, n, room.d)
        move(x, w, y, room.a, room.b, room.c, limits.step)
        kick(w, z, room.a, room.b, room.c, room.d, limits.step)
    return touching


@compiled
def _fall(room: _Room, gravity: Floats, at: int, n: int) -> None:
    """Set the forces and accelerations of all stages of a block of n contacts in free flight."""
    room.force[: n + 2] = room.first[:] = room.last[:] = 0.0
    g = gravity[at : at + n + 1]
    room.a[: n + 1] = room.b[: n + 1] = room.c[: n + 1] = g
