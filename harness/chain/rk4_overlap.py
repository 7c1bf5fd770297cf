"""RK4 under the overlap law, block by block: a force acts on neighbours only.

A block takes four particles more on each side, one for each stage, and its
stages stay in the cache: the cost of a particle does not depend on how many
there are.
"""

from __future__ import annotations

import numpy as np

from harness.chain.arrays import Chain, Floats, equal_run
from harness.chain.compiled import compiled
from harness.chain.overlap import forces
from harness.chain.record import Counts, Record, with_room, write_sample
from harness.chain.slices import Advance, Plan

_BLOCK = 512
_HALO = 4


def begin(chain: Chain, plan: Plan) -> Advance:
    """Return what advances ``chain`` in place, from one step to another.

    Samples: every so many steps, at the end, and whenever the number of
    contacts in the grain's chain has changed.
    """
    overlap, force = np.empty((2, chain.diagonal.size))
    stiffness, counts = 1 / chain.diagonal, np.array([0, -1])

    def advance(record: Record, first: int, last: int) -> tuple[Record, int]:
        return _advance(
            chain, stiffness, overlap, force, counts, record, plan, first, last
        )  # fmt: skip

    return advance


@compiled
def _advance(
    chain: Chain, stiffness: Floats, overlap: Floats, force: Floats, counts: Counts,
    record: Record, plan: Plan, first: int, last: int,
) -> tuple[Record, int]:  # fmt: skip
    """Do the steps from ``first`` to before ``last``; ``stiffness`` (n,) is that of contacts.

    ``counts`` are the rows of the record and the contacts in the grain's chain so far.
    """
    u, v, n = chain.displacement, chain.velocity, stiffness.size
    block = np.zeros((7, min(n + 1, _BLOCK + 2 * _HALO)))
    halo = np.zeros((2, _HALO))
    equal = equal_run(chain)
    rows, contacts = counts
    for count in range(first, last):
        touching = 0
        while touching < n and u[touching] > u[touching + 1]:
            touching += 1
        if touching != contacts or count % plan.every == 0 or count == plan.steps:
            contacts = touching
            for i in range(n):
                overlap[i] = u[i] - u[i + 1]
            forces(overlap, chain.diagonal, force)
            record = with_room(record, rows)
            write_sample(record, rows, count * plan.step, chain, u, v, overlap, force)
            rows += 1
        if count < plan.steps:
            _step(chain, stiffness, plan.step, block, halo, equal)
    counts[0], counts[1] = rows, contacts
    return record, rows


@compiled
def _step(
    chain: Chain, stiffness: Floats, step: float, block: Floats, halo: Floats,
    equal: tuple[int, int],
) -> None:  # fmt: skip
    """Advance displacements and velocities (N,) by one step."""
    u, v, particles, (first, end) = chain.displacement, chain.velocity, chain.mass.size, equal
    x, w, a, b, c, d = block[0], block[1], block[2], block[3], block[4], block[5]
    force = block[6]
    for start in range(0, particles, _BLOCK):
        stop = min(start + _BLOCK, particles)
        low, high = max(start - _HALO, 0), min(stop + _HALO, particles)
        before, size = start - low, high - low
        at = first if low >= first and high <= end else low
        k, mobility = stiffness[at : at + size - 1], chain.mobility[at : at + size]
        gravity = chain.gravity[at : at + size]
        for i in range(before):  # the block before has overwritten these
            x[i], w[i] = halo[0, i], halo[1, i]
        for i in range(before, size):
            x[i], w[i] = u[low + i], v[low + i]
        if stop < particles:
            for i in range(_HALO):
                halo[0, i], halo[1, i] = u[stop - _HALO + i], v[stop - _HALO + i]
        _press(x, w, a, 0.0, 0.0, k, force)
        _accelerate(force, mobility, gravity, a)
        _press(x, w, a, 0.5 * step, 0.0, k, force)
        _accelerate(force, mobility, gravity, b)
        _press(x, w, a, 0.5 * step, 0.25 * step**2, k, force)
        _accelerate(force, mobility, gravity, c)
        _press(x, w, b, step, 0.5 * step**2, k, force)
        _accelerate(force, mobility, gravity, d)
        for i in range(before, before + stop - start):
            u[low + i] = x[i] + step * w[i] + step**2 / 6 * (a[i] + b[i] + c[i])
            v[low + i] = w[i] + step / 6 * (a[i] + 2 * (b[i] + c[i]) + d[i])


@compiled
def _press(
    x: Floats, w: Floats, a: Floats, shift: float, lift: float, stiffness: Floats, force: Floats
) -> None:
    """Set the forces in a block [N] at ``x + shift w + lift a``."""
    for i in range(stiffness.size):
        overlap = (x[i] - x[i + 1]) + shift * (w[i] - w[i + 1]) + lift * (a[i] - a[i + 1])
        force[i] = max(overlap, 0.0) * stiffness[i]


@compiled
def _accelerate(force: Floats, mobility: Floats, gravity: Floats, a: Floats) -> None:
    """Set the accelerations in a block [m/s2]; those at an inner edge miss a force."""
    m, g, size = mobility, gravity, mobility.size
    a[0] = g[0] - force[0] * m[0]
    for i in range(1, size - 1):
        a[i] = (force[i - 1] - force[i]) * m[i] + g[i]
    a[size - 1] = force[size - 2] * m[size - 1] + g[size - 1]
