"""A chain in steps: the classic Runge-Kutta method (Kutta 1901), and velocity Verlet.

Forces depend on positions alone, so the four stages of Runge-Kutta reduce to four evaluations of
the force at ``u + c v + b a``, with a the acceleration of the stage before. The order is 4 while
contacts stay; a step in which one changes has a kink of the force in it, and a lower order.
Velocity Verlet takes the steps of DEM codes, for runs that are compared with theirs step by step.
The cost of a step is linear in the number of particles.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.compiled import shielded
from harness.errors import RequestError
from harness.solvers.chain.contacts import longest_run, update_forces
from harness.solvers.chain.kernels import compiled
from harness.solvers.chain.samples import count_contacts, write_row
from harness.solvers.chain.series import COLUMNS, ChainSamples, Profiles, samples_of_rows
from harness.solvers.chain.setup import Chain, Flags, Floats, highest_frequency

Scheme = Literal["rk4", "velocity_verlet"]
STABILITY: dict[Scheme, float] = {"rk4": 2.0 * math.sqrt(2.0), "velocity_verlet": 2.0}  # h omega
MOST_STEPS = 10**12
SLICE = 3_000_000  # particles times steps between two looks for an interrupt
SLACK = 1e-14  # gaps as far below 0 are rounding [scale of displacements]

Progress = Callable[[int, int], None]


def run(
    chain: Chain,
    duration: float,
    step: float,
    *,
    samples: int,
    scheme: Scheme = "rk4",
    profiles: bool = False,
    longest: int | None = None,
    progress: Progress = lambda *_: None,
) -> ChainSamples:
    """Return the motion of a chain for ``duration`` [s], in steps of at most ``step`` [s].

    The step is made to divide the duration. There are about ``samples`` samples, and with
    Runge-Kutta one more at each change of the grain's contacts. ``longest`` bounds the contacts
    that touch in a row under the deformable law, which allows a larger step; the run stops if more
    touch. Raise RequestError for a step or a duration out of range, and where the values overflow.
    """
    if longest is not None and longest < 1:
        raise RequestError(f"longest_chain = {longest}: must be at least 1")
    steps = step_count(duration, step)
    bound = STABILITY[scheme] / highest_frequency(chain, longest)
    if not step < bound:
        raise RequestError(f"step = {step} s: must be less than {bound:.6g} s, else unstable")
    every = max(1, steps // samples)
    plan = Plan(duration / steps, steps, every, longest or chain.diagonal.size, scheme == "rk4")
    state = _state(chain)
    record = _Record(chain, steps // every + 2, profiles)
    counts, in_slice = state.counts, max(1, SLICE // chain.mass.size)
    while counts[NEXT] <= steps:
        last = min(int(counts[NEXT]) + in_slice, steps + 1)
        record.make_room(int(counts[ROWS]))
        if failed := shielded(_advance, chain, state, plan, last, *record.arrays):
            raise _stopped(failed, plan)
        progress(min(int(counts[NEXT]), steps), steps)
    return record.samples(state, plan.step)


def step_count(duration: float, step: float) -> int:
    """Return how many steps of at most ``step`` [s] a run of ``duration`` [s] takes."""
    if not (math.isfinite(duration) and duration > 0):
        raise RequestError(f"duration = {duration} s: must be finite and greater than 0")
    if not (step > 0 and duration / step <= MOST_STEPS):
        raise RequestError(f"duration = {duration} s: more than 1e12 steps of {step:.6g} s")
    return max(1, math.ceil(duration / step * (1 - 1e-12)))


class Plan(NamedTuple):
    """The steps of a run: size [s], number, those between samples, and limits."""

    step: float
    steps: int
    every: int
    longest: int  # contacts that may touch in a row
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
    counts: NDArray[np.int64]  # by ROWS, CONTACTS, NEXT


ROWS, CONTACTS, NEXT = range(3)  # rows written, contacts of the grain's chain, next step


def _state(chain: Chain) -> State:
    n = chain.diagonal.size
    a, b, c, d = (np.zeros(n + 1) for _ in range(4))
    u, v, (overlap, force) = chain.displacement.copy(), chain.velocity.copy(), np.zeros((2, n))
    closed, factor = np.zeros(n, np.bool_), np.zeros((3, n))
    return State(u, v, a, b, c, d, overlap, force, closed, factor, np.array([0, -1, 0]))


class _Record:
    """Rows of samples, which grow, and profiles on request."""

    def __init__(self, chain: Chain, rows: int, profiles: bool) -> None:
        n, self._profiles = chain.diagonal.size, profiles
        widths = (len(COLUMNS), *((n + 1, n + 1, n) if profiles else (0, 0, 0)))
        self.arrays = [np.empty((rows, width)) for width in widths]

    def make_room(self, written: int) -> None:
        """Double the rows where all are written."""
        if written == len(self.arrays[0]):
            self.arrays = [np.concatenate((array, np.empty_like(array))) for array in self.arrays]

    def samples(self, state: State, step: float) -> ChainSamples:
        """Return the samples that are written."""
        rows, *parts = (array[: state.counts[0]] for array in self.arrays)
        profiles = Profiles(*parts) if self._profiles else None
        return samples_of_rows(rows, (state.u, state.v), step=step, profiles=profiles)


def _stopped(touching: int, plan: Plan) -> RequestError:
    if touching > plan.longest:
        return RequestError(
            f"longest_chain = {plan.longest}: {touching} contacts touch in a row, "
            f"for which a step of {plan.step:.6g} s may be unstable"
        )
    return RequestError(f"step = {plan.step:.6g} s: no contact set fits, the values overflow")


# ---- steps
#
# Kernels take arrays one by one: to take one out of a tuple costs as much as a short row.


@compiled
def _advance(
    chain: Chain, state: State, plan: Plan, last: int,
    rows: Floats, places: Floats, speeds: Floats, forces: Floats,
) -> int:  # fmt: skip
    """Take the steps to before ``last``, or until all rows are written; return 0.

    Where more contacts touch in a row than allowed, return how many; 1 where no set fits.
    """
    u, v, a, b, c, d, overlap, force, closed, factor, counts = state
    _, mobility, diagonal, coupling, gravity, _, _, length, deformable = chain
    h, dense, half = plan.step, plan.dense, 0.5 * plan.step
    tolerance = SLACK * length if deformable else -1.0
    longest = plan.longest if deformable else overlap.size
    for count in range(counts[NEXT], last):
        counts[NEXT] = count
        if dense or count == 0:
            _set_overlaps(u, v, a, 0.0, 0.0, overlap)
            if not update_forces(overlap, diagonal, coupling, closed, factor, force, tolerance):
                return 1
            _accelerate(force, mobility, gravity, a)
        touching, row = count_contacts(force), counts[ROWS]
        if (dense and touching != counts[CONTACTS]) or (
            count % plan.every == 0 or count == plan.steps
        ):
            if row == rows.shape[0]:
                return 0
            write_row(chain, count * h, u, v, force, rows[row])
            if places.shape[1]:
                places[row], speeds[row], forces[row] = u, v, force
            counts[ROWS], counts[CONTACTS] = row + 1, touching
        if count == plan.steps:
            break
        if not dense:
            _kick_and_drift(u, v, a, h)
        for stage in range(3 if dense else 1):
            before, now = (a, b) if stage == 0 else (a, c) if stage == 1 else (b, d)
            shift = (h if stage == 2 else half) if dense else 0.0
            lift = half * shift if stage else 0.0
            _set_overlaps(u, v, before, shift, lift, overlap)
            if not update_forces(overlap, diagonal, coupling, closed, factor, force, tolerance):
                return 1
            if longest < overlap.size:
                touching = longest_run(closed)
                if touching > longest:
                    return touching
            _accelerate(force, mobility, gravity, now if dense else a)
        if dense:
            _combine(u, v, a, b, c, d, h)
        else:
            _kick(v, a, h)
    counts[NEXT] = last
    return 0


@compiled
def _set_overlaps(
    u: Floats, v: Floats, a: Floats, shift: float, lift: float, overlap: Floats
) -> None:
    """Set the overlaps (n,) [m] at ``u + shift v + lift a``."""
    for i in range(overlap.size):
        overlap[i] = (u[i] - u[i + 1]) + shift * (v[i] - v[i + 1]) + lift * (a[i] - a[i + 1])


@compiled
def _accelerate(force: Floats, mobility: Floats, gravity: Floats, a: Floats) -> None:
    """Set the accelerations (N,) [m/s2] from the forces (n,) [N]."""
    before = 0.0
    for i in range(force.size):
        a[i] = (before - force[i]) * mobility[i] + gravity[i]
        before = force[i]
    a[-1] = before * mobility[-1] + gravity[-1]


@compiled
def _combine(u: Floats, v: Floats, a: Floats, b: Floats, c: Floats, d: Floats, h: float) -> None:
    """Take a step of Runge-Kutta from the accelerations of its four stages."""
    square, sixth = h * h / 6, h / 6
    for i in range(u.size):
        u[i] += h * v[i] + square * (a[i] + b[i] + c[i])
        v[i] += sixth * (a[i] + 2 * (b[i] + c[i]) + d[i])


@compiled
def _kick_and_drift(u: Floats, v: Floats, a: Floats, h: float) -> None:
    """Kick by half a step, and move by a whole one."""
    for i in range(u.size):
        v[i] += 0.5 * h * a[i]
        u[i] += h * v[i]


@compiled
def _kick(v: Floats, a: Floats, h: float) -> None:
    """Kick by half a step."""
    for i in range(v.size):
        v[i] += 0.5 * h * a[i]
