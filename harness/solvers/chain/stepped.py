"""A chain in steps: the classic Runge-Kutta method (Kutta 1901), and velocity Verlet.

Forces depend on positions alone, so the four stages of Runge-Kutta reduce to four evaluations of
the force at ``u + c v + b a``, with a the acceleration of the stage before. The order is 4 while
contacts stay; a step in which one changes has a kink of the force in it, and a lower order.
Velocity Verlet takes the steps of DEM codes, for runs that are compared with theirs step by step.
The cost of a step is linear in the number of particles.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.compiled import compiled, shielded
from harness.errors import RequestError
from harness.solvers.chain.contacts import solve
from harness.solvers.chain.motion import Chain, ChainMotion, Flags, Floats, Progress, Scheme

MOST_STEPS = 10**12
SLICE = 3_000_000  # particles times steps between two looks for an interrupt
SLACK = 1e-14  # gaps as far below 0 are rounding [scale of displacements]


def run(
    chain: Chain,
    duration: float,
    step: float,
    *,
    samples: int,
    scheme: Scheme = "rk4",
    progress: Progress = lambda *_: None,
) -> ChainMotion:
    """Return the motion of a chain for ``duration`` [s], in steps of at most ``step`` [s].

    The step is made to divide the duration. There are about ``samples`` samples, and with
    Runge-Kutta one more at each change of the grain's contacts. Raise RequestError for more than
    1e12 steps, and where the values overflow: the caller keeps ``step`` below ``STABILITY`` /
    ``highest_frequency``.
    """
    if not duration / step <= MOST_STEPS:
        raise RequestError(f"duration = {duration} s: more than 1e12 steps of {step:.6g} s")
    steps = max(1, math.ceil(duration / step * (1 - 1e-12)))
    plan = Plan(duration / steps, steps, max(1, steps // samples), scheme == "rk4")
    state, n = _state(chain), chain.diagonal.size
    in_slice = min(max(1, SLICE // (n + 1)), steps + 1)
    widths = 1, n + 1, n + 1, n
    rows = tuple(np.empty((in_slice, width)) for width in widths)  # one a step at most
    parts = []
    for first in range(0, steps + 1, in_slice):
        last = min(first + in_slice, steps + 1)
        count = shielded(_advance, chain, state, plan, first, last, rows)
        if count < 0:
            raise RequestError(f"step = {plan.step:.6g} s: no contact set fits, values overflow")
        parts.append([row[:count].copy() for row in rows])
        progress(min(last, steps), steps)
    time, u, v, force = (np.concatenate(part) for part in zip(*parts, strict=True))
    return ChainMotion(
        chain=chain, time=time[:, 0], displacements=u, velocities=v, forces=force, step=plan.step
    )


class Plan(NamedTuple):
    """The steps of a run: size [s], number, and those between samples."""

    step: float
    steps: int
    every: int
    dense: bool  # Runge-Kutta, with a sample at each change of the grain's contacts


class State(NamedTuple):
    """The state of N particles between two steps."""

    u: Floats  # (N,) [m]
    v: Floats  # (N,) [m/s]
    a: Floats  # (N,) [m/s2] accelerations of four stages
    b: Floats
    c: Floats
    d: Floats
    overlap: Floats  # (n,) [m]
    force: Floats  # (n,) [N]
    closed: Flags  # (n,)
    factor: Floats  # (3, n)
    contacts: NDArray[np.int64]  # (1,) of the grain's chain at the last sample


def _state(chain: Chain) -> State:
    n = chain.diagonal.size
    a, b, c, d = (np.zeros(n + 1) for _ in range(4))
    u, v, (overlap, force) = chain.displacement.copy(), chain.velocity.copy(), np.zeros((2, n))
    closed, factor = np.zeros(n, np.bool_), np.zeros((3, n))
    return State(u, v, a, b, c, d, overlap, force, closed, factor, np.array([-1]))


# ---- steps
#
# Kernels take arrays one by one: to take one out of a tuple costs as much as a short row.


@compiled
def _advance(
    chain: Chain, state: State, plan: Plan, first: int, last: int, rows: tuple[Floats, ...]
) -> int:
    """Take the steps from ``first`` to before ``last``; ``rows`` take time, u, v and force.

    Return how many rows are written, -1 where no contact set fits.
    """
    u, v, a, b, c, d, overlap, force, closed, factor, contacts = state
    times, places, speeds, forces = rows
    _, mobility, diagonal, coupling, gravity, _, _, length, deformable = chain
    h, dense, half, row = plan.step, plan.dense, 0.5 * plan.step, 0
    tolerance = SLACK * length if deformable else -1.0
    for count in range(first, last):
        if dense or count == 0:
            _set_overlaps(u, v, a, 0.0, 0.0, overlap)
            if not _set_forces(overlap, diagonal, coupling, closed, factor, force, tolerance):
                return -1
            _accelerate(force, mobility, gravity, a)
        touching = _count_contacts(force)
        if (dense and touching != contacts[0]) or (count % plan.every == 0 or count == plan.steps):
            times[row] = count * h
            _copy(u, places[row])
            _copy(v, speeds[row])
            _copy(force, forces[row])
            row, contacts[0] = row + 1, touching
        if count == plan.steps:
            break
        if not dense:
            _kick(v, a, half)
            _drift(u, v, h)
        for stage in range(3 if dense else 1):
            before, now = (a, b) if stage == 0 else (a, c) if stage == 1 else (b, d)
            shift = (h if stage == 2 else half) if dense else 0.0
            lift = half * shift if stage else 0.0
            _set_overlaps(u, v, before, shift, lift, overlap)
            if not _set_forces(overlap, diagonal, coupling, closed, factor, force, tolerance):
                return -1
            _accelerate(force, mobility, gravity, now if dense else a)
        if dense:
            _combine(u, v, a, b, c, d, h)
        else:
            _kick(v, a, half)
    return row


@compiled
def _copy(values: Floats, target: Floats) -> None:
    """Copy in a loop: numba takes 2 s to compile an assignment of arrays."""
    for i in range(values.size):
        target[i] = values[i]


@compiled
def _set_overlaps(
    u: Floats, v: Floats, a: Floats, shift: float, lift: float, overlap: Floats
) -> None:
    """Set the overlaps (n,) [m] at ``u + shift v + lift a``."""
    for i in range(overlap.size):
        overlap[i] = (u[i] - u[i + 1]) + shift * (v[i] - v[i + 1]) + lift * (a[i] - a[i + 1])


@compiled
def _set_forces(
    overlap: Floats, diagonal: Floats, coupling: Floats,
    closed: Flags, factor: Floats, force: Floats, tolerance: float,
) -> bool:  # fmt: skip
    """Set ``force`` (n,) [N]; return whether a contact set was found.

    A negative ``tolerance`` stands for the overlap law, which needs no contact set.
    """
    if tolerance >= 0.0:
        return solve(overlap, diagonal, coupling, closed, factor, force, tolerance)
    for i in range(overlap.size):
        force[i] = max(overlap[i], 0.0) / diagonal[i]
    return True


@compiled
def _accelerate(force: Floats, mobility: Floats, gravity: Floats, a: Floats) -> None:
    """Set the accelerations (N,) [m/s2] from the forces (n,) [N]."""
    before = 0.0
    for i in range(force.size):
        a[i] = (before - force[i]) * mobility[i] + gravity[i]
        before = force[i]
    a[-1] = before * mobility[-1] + gravity[-1]


@compiled
def _count_contacts(force: Floats) -> int:
    """Return how many contacts from the grain on carry a force (n,) [N]."""
    contacts = 0
    while contacts < force.size and force[contacts] > 0:
        contacts += 1
    return contacts


@compiled
def _combine(u: Floats, v: Floats, a: Floats, b: Floats, c: Floats, d: Floats, h: float) -> None:
    """Take a step of Runge-Kutta from the accelerations of its four stages."""
    square, sixth = h * h / 6, h / 6
    for i in range(u.size):
        u[i] += h * v[i] + square * (a[i] + b[i] + c[i])
        v[i] += sixth * (a[i] + 2 * (b[i] + c[i]) + d[i])


@compiled
def _kick(v: Floats, a: Floats, seconds: float) -> None:
    for i in range(v.size):
        v[i] += seconds * a[i]


@compiled
def _drift(u: Floats, v: Floats, seconds: float) -> None:
    for i in range(u.size):
        u[i] += seconds * v[i]
