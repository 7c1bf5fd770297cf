"""The classic Runge-Kutta method of fourth order with a fixed step (Kutta 1901), in either law.

Forces depend on positions alone, so the four stages reduce to four force evaluations at
displacements ``u + c v + b a``, with a the acceleration of the stage before. Order 4 while the
contacts stay; at a change of contacts the force has a kink, and the error of the step that meets it
is of lower order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from harness.errors import RequestError
from harness.observables.tower import TowerRun
from harness.parameters.tower import Law, Tower
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
    Progress,
    Record,
    as_run,
    assemble,
    blank_record,
    chain_of_grain,
    compiled,
    in_slices,
    rk4_step_seconds,
    select_step,
    wanted_samples,
    with_room,
    write_sample,
)

# ---- steps of both laws
#
# Forces and accelerations are arrays of the row; forces stand between two zeros, that of contact i
# at i + 1. The overlap law of DEM codes presses each contact by its own overlap. The deformable law
# acts all along a touching chain at once: each stage solves the contact set of the stage before,
# factorised once and kept, and checks it; only when it is wrong the contact set is looked for anew.


class ContactSet(NamedTuple):
    """The contact set of a row of n contacts, and its factors from both ends."""

    closed: Flags  # (n,)
    pivot: Floats  # (n,)
    carry: Floats  # (n,)


def kernel(chain: Chain, plan: Plan) -> Advance:
    """Return what advances ``chain`` in place under its law, from one step to another.

    Samples: every so many steps, at the end, and whenever the number of contacts in the grain's
    chain has changed. Instead of the rows of the record, it returns minus the length of a chain of
    touching contacts longer than ``plan.longest`` under the deformable law, or -1 where no contact
    set fits.
    """
    n = chain.diagonal.size
    contacts = ContactSet(np.zeros(n, np.bool_), np.zeros(n), np.zeros(n))
    # all open: the first stage finds the set, and holds a preloaded row to its longest chain
    factorise_from_both_ends(contacts.closed, chain.diagonal, chain.coupling, *contacts[1:])
    counts = np.array([0, -1])

    def advance(record: Record, first: int, last: int) -> tuple[Record, int]:
        return _advance(chain, contacts, counts, record, plan, first, last)

    return advance


@compiled
def _advance(
    chain: Chain, contact_set: ContactSet, counts: Counts, record: Record, plan: Plan,
    first: int, last: int,
) -> tuple[Record, int]:  # fmt: skip
    """Do the steps from ``first`` to before ``last``.

    ``counts`` are the rows of the record and the contacts in the grain's chain so far.
    """
    u, v, n, step = chain.displacement, chain.velocity, chain.diagonal.size, plan.step
    a, b, c, d = np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1), np.zeros(n + 1)
    overlap, force, factor = np.zeros(n), np.zeros(n + 2), np.zeros((3, n))
    stiffness, coupling, deformable = 1 / chain.diagonal, chain.coupling, chain.deformable
    mobility, gravity, tolerance = chain.mobility, chain.gravity, 1e-14 * chain.length
    pivot, carry = contact_set.pivot, contact_set.carry
    rows, contacts = counts
    for count in range(first, last):
        for stage in range(4):
            shift = 0.0 if stage == 0 else 0.5 * step if stage < 3 else step
            lift = 0.0 if stage < 2 else 0.5 * step * shift
            _set_overlaps(u, v, a if stage < 3 else b, shift, lift, overlap)
            if not deformable:
                _press(overlap, stiffness, force)
            else:
                substitute_from_both_ends(overlap, pivot, carry, force)
                if _wrong(overlap, coupling, pivot, force, tolerance):
                    most = _solve(chain, contact_set, overlap, factor, force, tolerance)
                    if most < 0 or most > plan.longest:
                        return record, -abs(most)
            if stage == 0:
                touching = chain_of_grain(force[1:-1])
                if touching != contacts or count % plan.every == 0 or count == plan.steps:
                    contacts = touching
                    record = with_room(record, rows)
                    sampled = force[1:-1] if deformable else _forces(overlap, chain.diagonal)
                    write_sample(record, rows, count * step, chain, u, v, overlap, sampled)
                    rows += 1
                if count == plan.steps:
                    return record, rows
            to = a if stage == 0 else b if stage == 1 else c if stage == 2 else d
            _accelerate(force, mobility, gravity, to)
        square, sixth = step**2 / 6, step / 6
        for i in range(n + 1):
            u[i] = u[i] + step * v[i] + square * (a[i] + b[i] + c[i])
            v[i] = v[i] + sixth * (a[i] + 2 * (b[i] + c[i]) + d[i])
    counts[0], counts[1] = rows, contacts
    return record, rows


@compiled
def _set_overlaps(
    u: Floats, v: Floats, a: Floats, shift: float, lift: float, overlap: Floats
) -> None:
    """Set the overlaps (n,) [m] at ``u + shift v + lift a``."""
    for i in range(overlap.size):
        overlap[i] = (u[i] - u[i + 1]) + shift * (v[i] - v[i + 1]) + lift * (a[i] - a[i + 1])


@compiled
def _press(overlap: Floats, stiffness: Floats, force: Floats) -> None:
    for i in range(overlap.size):
        force[i + 1] = max(overlap[i], 0.0) * stiffness[i]


@compiled
def _forces(overlap: Floats, diagonal: Floats) -> Floats:
    """Return ``max(overlap, 0) / diagonal`` (n,) [N]: the force of a sample, of the overlap law."""
    force = np.empty(overlap.size)
    for i in range(overlap.size):
        force[i] = max(overlap[i], 0.0) / diagonal[i]
    return force


@compiled
def _wrong(
    overlap: Floats, coupling: Floats, pivot: Floats, force: Floats, tolerance: float
) -> int:
    """Return how many contacts pull, or are open and overlap, by more than ``tolerance`` [m]."""
    # the first is apart: without a condition in the loop several are taken at a time
    first = (coupling[0] * force[2] - overlap[0]) if pivot[0] == 0 else force[1]
    wrong = int(first < -tolerance * (1.0 if pivot[0] == 0 else pivot[0]))
    for i in range(1, overlap.size):
        gap = coupling[i - 1] * force[i] + coupling[i] * force[i + 2] - overlap[i]
        wrong += (gap if pivot[i] == 0 else force[i + 1]) < -tolerance * (
            1.0 if pivot[i] == 0 else pivot[i]
        )
    return wrong


@compiled
def _solve(
    chain: Chain, contacts: ContactSet, overlap: Floats, factor: Floats, force: Floats,
    tolerance: float,
) -> int:  # fmt: skip
    """Find the contact set from the last one, its forces and factors; return as ``solve`` does."""
    longest = solve(
        overlap, chain.diagonal, chain.coupling, contacts.closed, factor, force[1:-1], tolerance
    )
    factorise_from_both_ends(
        contacts.closed, chain.diagonal, chain.coupling, contacts.pivot, contacts.carry
    )
    return longest


@compiled
def _accelerate(force: Floats, mobility: Floats, gravity: Floats, acceleration: Floats) -> None:
    """Set the accelerations (N,) [m/s2] from the forces (N + 1,) [N]."""
    for i in range(acceleration.size):
        acceleration[i] = (force[i] - force[i + 1]) * mobility[i] + gravity[i]


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

    Negative rows say why the deformable law stopped, as of :func:`kernel`.
    """
    law: Law = "deformable" if chain.deformable else "overlap"
    seconds = rk4_step_seconds(law, chain.mass.size)
    return in_slices(kernel(chain, plan), record, plan, seconds, progress)
