"""Steps of RK4 under the deformable law, where a force acts all along a touching chain at once.

Each stage solves the contact set of the stage before, factorised once and kept, and checks it; only
when it is wrong the contact set is looked for anew. A short row is taken as a whole, with the least
overhead of a step (:func:`short_row_kernel`); a long one block by block
(:func:`long_row_kernel`).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.solvers.chain.forces import (
    Flags,
    factorise_from_both_ends,
    solve,
    substitute_from_both_ends,
)
from harness.solvers.chain.motion import (
    Advance,
    Chain,
    Counts,
    Floats,
    Plan,
    Record,
    chain_of_grain,
    compiled,
    equal_run,
    with_room,
    write_sample,
)

STAGES = 4


# ---- stages of a block
#
# A block has n contacts from low on and the n + 1 particles that they join, or is the whole row.
# Arrays of the row are read from low on, its constant properties from at on, where equal particles
# have the same; overlaps, forces and accelerations are arrays of the block, from 0 on. Forces
# stand between two zeros, that of contact i of the block at i + 1. Each function works on slices
# that begin at 0: an index that is known not to be negative is what lets the compiler take several
# particles at a time.


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
    overlap: Floats, coupling: Floats, pivot: Floats, at: int, low: int, n: int, force: Floats,
    tolerance: float,
) -> int:  # fmt: skip
    """Return how many contacts pull, or are open and overlap, by more than ``tolerance`` [m]."""
    couple, inverse = coupling[at : at + n], pivot[low : low + n]
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

    Return as :func:`harness.solvers.chain.forces.solve` does.
    """
    row = slice(low, low + n)
    longest = solve(
        overlap[:n], chain.diagonal[row], chain.coupling[row], contacts.closed[row], factor[:, :n],
        force[1 : n + 1], tolerance,
    )  # fmt: skip
    factorise_from_both_ends(
        contacts.closed, chain.diagonal, chain.coupling, low, n, contacts.pivot, contacts.carry
    )
    return longest


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


Cuts = NDArray[np.int64]

BLOCK = 512  # particles: its stages fit the cache, and the work about a block is small beside it


# ---- blocks that a step can do one after the other
#
# Blocks end at an open contact: what touches on one side is not felt on the other. It is looked
# for near every multiple of BLOCK particles; where there is none, two blocks are one.


@compiled
def end_of_block(
    u: Floats, v: Floats, closed: Flags, cuts: Cuts, window: int, step: float
) -> tuple[int, int, bool]:
    """Return the end of the block that begins in ``window``, the window there, what is new.

    ``cuts`` holds the first particle after the cut in each window of BLOCK
    particles, 0 where it has none; it is brought up to date. The end is one more
    than the last particle. New: whether a cut on the way has come, gone or moved.
    """
    moved = False
    for at in range(window + 1, cuts.size):
        cut = _safe_cut(u, v, closed, cuts[at], at * BLOCK, step)
        if cut != cuts[at]:
            cuts[at], moved = cut, True
        if cut > 0:
            return cut, at, moved
    return u.size, cuts.size, moved


@compiled
def _safe_cut(u: Floats, v: Floats, closed: Flags, cut: int, begin: int, step: float) -> int:
    """Return ``cut`` while it is safe, else the next that is, or 0."""
    if cut > 0 and _safe(u, v, closed, cut - 1, step):
        return cut
    for contact in range(begin - 1, begin + BLOCK // 2 - 1):
        if _safe(u, v, closed, contact, step):
            return contact + 1
    return 0


@compiled
def _safe(u: Floats, v: Floats, closed: Flags, contact: int, step: float) -> bool:
    """Return whether ``contact`` is open, and should be after a step."""
    overlap = u[contact] - u[contact + 1]
    later = overlap + step * (v[contact] - v[contact + 1])
    return bool(not closed[contact] and overlap <= 0 and later <= 0)


@compiled
def stays_open(
    chain: Chain, u: Floats, v: Floats, before: Floats, after: Floats,
    contact: int, step: float, tolerance: float,
) -> bool:  # fmt: skip
    """Return whether ``contact`` is open in all stages, to ``tolerance`` [m].

    ``before`` and ``after`` (STAGES,) [N] are the forces of its neighbours.
    """
    i, j = contact, contact + 1
    mobility, gravity, coupling = chain.mobility, chain.gravity, chain.coupling
    a = b = 0.0
    for stage in range(STAGES):
        shift, lift = stage_shift(stage, step)
        overlap = (u[i] - u[j]) + shift * (v[i] - v[j])
        overlap += lift * (a if stage < STAGES - 1 else b)
        if coupling[i - 1] * before[stage] + coupling[i] * after[stage] - overlap < -tolerance:
            return False
        pressed = before[stage] * mobility[i] + gravity[i]
        pressed -= gravity[j] - after[stage] * mobility[j]
        if stage == 0:
            a = pressed
        elif stage == 1:
            b = pressed
    return True


# ---- short rows as one block


def short_row_kernel(chain: Chain, plan: Plan) -> Advance:
    """Return what advances ``chain`` in place, from one step to another.

    Samples: every so many steps, at the end, and whenever the number of
    contacts in the grain's chain has changed. Instead of the rows of the record, it returns minus
    the length of a chain of touching contacts longer than ``plan.longest``, or -1
    where no contact set fits.
    """
    n = chain.diagonal.size
    contacts = ContactSet(np.zeros(n, np.bool_), np.zeros(n), np.zeros(n))
    # all open: the first stage finds the set, and holds a preloaded row to its longest chain
    factorise_from_both_ends(contacts.closed, chain.diagonal, chain.coupling, 0, n, *contacts[1:])
    counts = np.array([0, -1])

    def advance(record: Record, first: int, last: int) -> tuple[Record, int]:
        return _advance_deformable(chain, contacts, counts, record, plan, first, last)

    return advance


@compiled
def _advance_deformable(
    chain: Chain, contact_set: ContactSet, counts: Counts, record: Record, plan: Plan,
    first: int, last: int,
) -> tuple[Record, int]:  # fmt: skip
    """Do the steps from ``first`` to before ``last``.

    ``counts`` are the rows of the record and the contacts in the grain's chain so far.
    """
    u, v, gravity, step = chain.displacement, chain.velocity, chain.gravity, plan.step
    mobility, diagonal, coupling = chain.mobility, chain.diagonal, chain.coupling
    tolerance = 1e-14 * chain.length
    n = diagonal.size
    a, b, c, d = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    overlap, force, factor = np.zeros(n), np.zeros(n + 2), np.zeros((3, n))
    pivot, carry = contact_set.pivot, contact_set.carry
    rows, contacts = counts
    for count in range(first, last):
        for stage in range(4):
            shift = 0.0 if stage == 0 else 0.5 * step if stage < 3 else step
            lift = 0.0 if stage < 2 else 0.5 * step * shift
            set_overlaps(u, v, a if stage < 3 else b, 0, n, shift, lift, overlap)
            substitute_from_both_ends(overlap, pivot, carry, 0, n, force)
            if count_wrong(overlap, coupling, pivot, 0, 0, n, force, tolerance):
                most = update_contact_set(
                    chain, contact_set, 0, n, overlap, factor, force, tolerance
                )
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


# ---- long rows, block by block
#
# The stages of a block stay in the cache, and a change of contacts is looked for among few: the
# cost of a particle hardly depends on how many there are. Blocks in which nothing touches fall
# freely, and need neither stages nor factors. When an open contact between two blocks closes in a
# stage after all, the step is done again with the whole row as one block.


class _RowState(NamedTuple):
    """State of N particles and n contacts in a step."""

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


class _StepBounds(NamedTuple):
    """Bounds of a step; the equal particles are those of ``equal_run``."""

    step: float  # [s]
    tolerance: float  # [m] by which a gap may be negative
    longest: int  # touching contacts in a row
    equal_from: int
    equal_to: int


def long_row_kernel(chain: Chain, plan: Plan) -> Advance:
    """Return what advances ``chain`` in place, as :func:`short_row_kernel`."""
    particles, contacts = chain.mass.size, chain.diagonal.size
    no_cuts = np.zeros(max(1, particles // BLOCK), np.int64)
    u, v, a, b, c, d = np.empty((6, particles))
    pivot, carry, overlap, force = np.empty((4, contacts))
    contact_set = ContactSet(np.zeros(contacts, np.bool_), pivot, carry)
    row = _RowState(
        chain.displacement, chain.velocity, u, v, contact_set, no_cuts, overlap, force
    )  # fmt: skip
    edges = np.zeros((3, STAGES))
    room = _Room(
        np.empty(contacts), np.empty(contacts + 2), a, b, c, d, np.empty((3, contacts)),
        edges[0], edges[1], edges[2],
    )  # fmt: skip
    limits = _StepBounds(plan.step, 1e-14 * chain.length, plan.longest, *equal_run(chain))
    counts = np.array([0, -1])

    def advance(record: Record, first: int, last: int) -> tuple[Record, int]:
        return _advance(chain, row, room, limits, counts, record, plan, first, last)

    return advance


@compiled
def _advance(  # noqa: PLR0913 - a compiled kernel takes arrays and numbers, no objects
    chain: Chain, row: _RowState, room: _Room, limits: _StepBounds, counts: Counts, record: Record,
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
        here = _RowState(u, v, next_u, next_v, row.contacts, row.cuts, row.overlap, row.force)
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
    chain: Chain, row: _RowState, room: _Room, limits: _StepBounds, stages: int, renewed: bool
) -> int:
    """Do so many ``stages`` in the row; return how many contacts touch from the grain on.

    One stage alone leaves its overlaps and forces in ``row``. ``renewed`` says that
    the first block has no factors yet. Return a negative number as
    :func:`short_row_kernel` does.
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
                row.contacts.closed, chain.diagonal, chain.coupling, low, n,
                row.contacts.pivot, row.contacts.carry,
            )  # fmt: skip
        renewed = moved
        reached = _advance_block(chain, row, room, limits, low, n, stages)
        if reached < 0:
            return reached
        if stages == 1:
            row.overlap[low : high - 1] = room.overlap[:n]
            row.force[low : high - 1] = room.force[1 : n + 1]
        if low == 0:
            touching = reached
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
    chain: Chain, row: _RowState, room: _Room, limits: _StepBounds, low: int, n: int, stages: int
) -> int:
    """Do so many ``stages`` in the block of n contacts from ``low`` on; return as the row does."""
    within = low >= limits.equal_from and low + n < limits.equal_to
    at = limits.equal_from if within else low
    mobility, gravity, coupling, force = chain.mobility, chain.gravity, chain.coupling, room.force
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
        if count_wrong(room.overlap, coupling, contacts.pivot, at, low, n, force, limits.tolerance):
            longest = update_contact_set(
                chain, contacts, low, n, room.overlap, room.factor, force, limits.tolerance
            )  # fmt: skip
            if longest < 0 or longest > limits.longest:
                return -abs(longest)
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
