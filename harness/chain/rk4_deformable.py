"""RK4 of the deformable law. A force is felt all along a chain of touching particles at once.

A step is done block by block, so that its stages stay in the cache and a change
of contacts is looked for among few. Blocks meet at contacts that are open: what
touches on one side is not felt on the other. When such a contact closes in a
stage after all, the step is done again with the whole row as one block.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.chain.arrays import Chain, Floats
from harness.chain.compiled import compiled, uncounted
from harness.chain.complementarity import Flags
from harness.chain.record import Record, with_room, write_sample
from harness.chain.stages import STAGES, Limits, advance, stage_shift
from harness.chain.twisted import factorise_from_both_ends

Ends = NDArray[np.int64]

_BLOCK = 256  # particles, or more: up to where a contact is safely open


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
    limits = Limits(step, 1e-14 * chain.length, longest)
    u, v, mobility, gravity = chain.displacement, chain.velocity, chain.mobility, chain.gravity
    diagonal, beside, mass = chain.diagonal, chain.beside, chain.mass
    n = diagonal.size
    new_u, new_v = np.empty(n + 1), np.empty(n + 1)
    closed, pivot, carry = np.zeros(n, np.bool_), np.zeros(n), np.zeros(n)
    overlap, force, ends = np.zeros(n), np.zeros(n + 2), np.zeros(n + 1, np.int64)
    a, b, c = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    factor, edges = np.zeros((3, n)), np.zeros((3, STAGES))
    rows, contacts = 0, -1
    for count in range(steps + 1):
        touching = contacts
        if count < steps:
            touching = _by_blocks(
                u, v, new_u, new_v, mobility, gravity, diagonal, beside, closed, pivot, carry,
                overlap, force, a, b, c, factor, edges, ends, limits, STAGES,
            )  # fmt: skip
        if touching != contacts or count % every == 0 or count == steps:
            if touching >= 0 or count == steps:
                touching = _by_blocks(
                    u, v, new_u, new_v, mobility, gravity, diagonal, beside, closed, pivot, carry,
                    overlap, force, a, b, c, factor, edges, ends, limits, 1,
                )  # fmt: skip
            if touching < 0:
                return record, touching
            contacts = touching
            record = with_room(record, rows)
            write_sample(record, rows, count * step, u, v, overlap, force[1:-1], mass, gravity)
            rows += 1
        if count < steps:
            u, new_u, v, new_v = new_u, u, new_v, v
    chain.displacement[:] = u
    chain.velocity[:] = v
    return record, rows


@uncounted
def _by_blocks(
    u: Floats, v: Floats, new_u: Floats, new_v: Floats, mobility: Floats, gravity: Floats,
    diagonal: Floats, beside: Floats, closed: Flags, pivot: Floats, carry: Floats,
    overlap: Floats, force: Floats, a: Floats, b: Floats, c: Floats, factor: Floats, edges: Floats,
    ends: Ends, limits: Limits, stages: int,
) -> int:  # fmt: skip
    """Do the stages of :func:`harness.chain.stages.advance` in the whole row.

    One stage alone leaves the ``overlap`` (n,) [m] and the ``force`` (n + 2,) [N],
    between two zeros, of all contacts; for a step they are room for one block.
    """
    particles = u.size
    low, high, touching, whole = 0, 0, 0, False
    while high < particles and not whole:
        low = high
        high = _end_of_block(
            u, v, diagonal, beside, closed, pivot, carry, ends, low, limits.step
        )  # fmt: skip
        if low == 0 and high == particles:
            whole = True
            break
        last = high - 1
        at = low if stages == 1 else 0
        found = advance(
            u[low:high], v[low:high], new_u[low:high], new_v[low:high],
            mobility[low:high], gravity[low:high], diagonal[low:last], beside[low:last],
            closed[low:last], pivot[low:last], carry[low:last],
            overlap[at : at + last - low], force[at : at + high - low + 1], a, b, c, factor, edges,
            limits, stages,
        )  # fmt: skip
        if found < 0:
            return found
        if low == 0:
            touching = found
        else:
            if stages == 1:
                overlap[low - 1] = u[low - 1] - u[low]
            if not _stays_open(u, v, mobility, gravity, beside, edges, low - 1, limits, stages):
                factorise_from_both_ends(closed, diagonal, beside, pivot, carry)
                ends[:] = 0
                whole = True
        for stage in range(stages):
            edges[2, stage] = edges[1, stage]
    if whole:
        touching = advance(
            u, v, new_u, new_v, mobility, gravity, diagonal, beside, closed, pivot, carry,
            overlap, force, a, b, c, factor, edges, limits, stages,
        )  # fmt: skip
    return touching


@uncounted
def _end_of_block(
    u: Floats, v: Floats, diagonal: Floats, beside: Floats, closed: Flags, pivot: Floats,
    carry: Floats, ends: Ends, low: int, step: float,
) -> int:  # fmt: skip
    """Return one more than the last particle of the block from ``low`` on, factorised.

    ``ends`` (N,) holds it at the first particle of each block, 0 elsewhere. The
    end of the step before is kept while the contact there is safe, unless the
    block is long; then it may have become possible to part it.
    """
    particles, end = u.size, int(ends[low])
    safe = end == particles or (end > 0 and _safe(u, v, closed, end - 1, step))
    if safe and end - low <= 2 * _BLOCK:
        return end
    chosen = particles
    for contact in range(low + _BLOCK - 1, particles - _BLOCK // 2):
        if _safe(u, v, closed, contact, step):
            chosen = contact + 1
            break
    if chosen != end:
        ends[low:chosen] = 0
        ends[low] = chosen
        part = slice(low, chosen - 1)
        factorise_from_both_ends(
            closed[part], diagonal[part], beside[part], pivot[part], carry[part]
        )
    return chosen


@uncounted
def _safe(u: Floats, v: Floats, closed: Flags, contact: int, step: float) -> bool:
    """Return whether ``contact`` and its neighbours are open, and it should be after a step."""
    if closed[contact - 1] or closed[contact] or closed[contact + 1]:
        return False
    overlap = u[contact] - u[contact + 1]
    return bool(overlap <= 0 and overlap + step * (v[contact] - v[contact + 1]) <= 0)


@uncounted
def _stays_open(
    u: Floats, v: Floats, mobility: Floats, gravity: Floats, beside: Floats, edges: Floats,
    contact: int, limits: Limits, stages: int,
) -> bool:  # fmt: skip
    """Return whether ``contact`` is open in all stages.

    Beside it are the first contact of a block and the last of the block before,
    whose forces are in ``edges``, rows 0 and 2 (STAGES,) [N].
    """
    i, j = contact, contact + 1
    a = b = 0.0
    for stage in range(stages):
        shift, lift = stage_shift(stage, limits.step)
        before, after = edges[2, stage], edges[0, stage]
        overlap = (u[i] - u[j]) + shift * (v[i] - v[j])
        overlap += lift * (a if stage < STAGES - 1 else b)
        if beside[i - 1] * before + beside[i] * after - overlap < -limits.tolerance:
            return False
        relative = before * mobility[i] + gravity[i] - (gravity[j] - after * mobility[j])
        if stage == 0:
            a = relative
        elif stage == 1:
            b = relative
    return True
