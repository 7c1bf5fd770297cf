"""The classic Runge-Kutta method of fourth order with a fixed step (Kutta 1901), in either law.

Forces depend on positions alone, so the four stages reduce to four force evaluations at
displacements ``u + c v + b a``, with a the acceleration of the stage before. Order 4 while the
contacts stay; at a change of contacts the force has a kink, and the error of the step that meets it
is of lower order. :func:`run` takes a tower of either law; the steps of the deformable law are in
:mod:`harness.solvers.chain.rk4_deformable`.
"""

from __future__ import annotations

import math

import numpy as np

from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Law, Tower
from harness.solvers.chain import rk4_deformable
from harness.solvers.chain.motion import (
    Advance,
    Chain,
    Counts,
    Floats,
    Plan,
    Progress,
    Record,
    as_run,
    assemble,
    blank_record,
    compiled,
    equal_run,
    in_slices,
    rk4_step_seconds,
    select_step,
    wanted_samples,
    with_room,
    write_sample,
)
from harness.solvers.chain.rk4_deformable import BLOCK

# ---- the overlap law of DEM codes: the force of a contact depends on its own overlap only
#
# The steps go block by block. A block takes four particles more on each side, one for each stage,
# and its stages stay in the cache: the cost of a particle does not depend on how many there are.


@compiled
def forces(overlap: Floats, diagonal: Floats, force: Floats) -> None:
    """Set ``force = max(overlap, 0) / diagonal`` (n,) [N] from the overlaps (n,) [m]."""
    for i in range(overlap.size):
        force[i] = max(overlap[i], 0.0) / diagonal[i]


_BLOCK = 512
_HALO = 4


def overlap_kernel(chain: Chain, plan: Plan) -> Advance:
    """Return what advances ``chain`` in place, from one step to another.

    Samples: every so many steps, at the end, and whenever the number of
    contacts in the grain's chain has changed.
    """
    overlap, force = np.empty((2, chain.diagonal.size))
    stiffness, counts = 1 / chain.diagonal, np.array([0, -1])

    def advance(record: Record, first: int, last: int) -> tuple[Record, int]:
        return _advance_overlap(
            chain, stiffness, overlap, force, counts, record, plan, first, last
        )  # fmt: skip

    return advance


@compiled
def _advance_overlap(  # noqa: PLR0913 - a compiled kernel takes arrays and numbers, no objects
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


_STEPS_AT_MOST = 10**12


def run(
    tower: Tower,
    duration: float,
    *,
    step: float | None = None,
    steps_per_contact: float | None = None,
    samples: int | None = None,
    profiles: bool = False,
    longest_chain: int | None = None,
    progress: Progress = lambda *_: None,
) -> TowerRun:
    """Run ``tower`` for ``duration`` [s] and return about ``samples`` samples.

    ``step`` [s] or ``steps_per_contact`` (steps in pi sqrt(m/k)); without them the step is that of
    :func:`harness.solvers.chain.motion.select_step`; it is made to divide the duration. By default
    1000 samples per t0, or every step. ``longest_chain`` bounds the number of contacts that touch
    in a row, which allows a larger step for long deformable chains; the run stops if more touch.
    ``progress`` is called with the steps done and all of them. Raise RequestError for a step or
    duration out of range.
    """
    if longest_chain is not None and longest_chain < 1:
        raise RequestError(f"longest_chain = {longest_chain}: must be at least 1")
    steps = step_count(duration, select_step(tower, step, steps_per_contact, longest_chain))
    wanted = wanted_samples(samples, duration / tower.contact_time)
    h = duration / steps
    every = max(1, steps // wanted)
    chain = assemble(tower)
    record = blank_record(steps // every + 2, tower.particles, profiles)
    limit = tower.height if longest_chain is None else longest_chain
    record, rows = integrate(chain, record, Plan(h, steps, every, limit), progress)
    if rows < 0:
        raise _stopped(-rows, limit, h)
    return as_run(tower, "rk4", h, record, rows, chain)


def step_count(duration: float, h: float) -> int:
    """Return how many steps of about ``h`` [s] :func:`run` takes; errors as there."""
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} s: must be finite and greater than 0")
    if not (h > 0 and duration / h <= _STEPS_AT_MOST):
        raise RequestError(f"duration = {duration} s: more than 1e12 steps of {h:.6g} s")
    return max(1, math.ceil(duration / h * (1 - 1e-12)))


def _stopped(touching: int, limit: int, step: float) -> RequestError:
    """Return the error of a chain beyond the limit, or of contacts without a solution."""
    if touching > limit:
        return RequestError(
            f"longest_chain = {limit}: {touching} contacts touch in a row, "
            f"for which a step of {step:.6g} s may be unstable"
        )
    return RequestError(f"step = {step:.6g} s: no contact set fits, the values overflow")


def integrate(
    chain: Chain, record: Record, plan: Plan, progress: Progress = lambda *_: None
) -> tuple[Record, int]:
    """Advance ``chain`` in place under its law; return the record and its rows.

    Negative rows say why the deformable law stopped
    (:func:`harness.solvers.chain.rk4_deformable.short_row_kernel`).
    """
    law: Law = "deformable" if chain.deformable else "overlap"
    kernel = overlap_kernel
    if chain.deformable:
        long = chain.mass.size >= 2 * BLOCK
        kernel = rk4_deformable.long_row_kernel if long else rk4_deformable.short_row_kernel
    seconds = rk4_step_seconds(law, chain.mass.size)
    return in_slices(kernel(chain, plan), record, plan, seconds, progress)
