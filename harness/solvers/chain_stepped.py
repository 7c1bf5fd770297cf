"""Rows in steps: the classic Runge-Kutta method (Kutta 1901), and velocity Verlet.

Forces of a chain depend on positions alone, so the four stages of Runge-Kutta reduce to four
evaluations of the force at ``u + c v + b a``, with a the acceleration of the stage before. The
order is 4 while contacts stay; a step in which one changes has a kink of the force in it, and a
lower order. Velocity Verlet takes the steps of DEM codes, for runs that are compared with theirs
step by step. The cost of a step is linear in the number of particles.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from harness.compiled import compiled, shielded
from harness.errors import EngineNaNError, RequestError
from harness.model.conventions import Rules
from harness.model.scene import Floats, Scene
from harness.solvers.chain import Chain, ChainMotion, Flags, Progress, Scheme, compliance, solve
from harness.solvers.kernels import (
    FORCE,
    GO_ON,
    OVER,
    POSITION,
    VELOCITY,
    Stages,
    keep,
    look,
    stages_of,
)  # fmt: skip

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
    steps, particles = max(1, math.ceil(duration / step * (1 - 1e-12))), chain.mass.size
    plan = _Plan(duration / steps, steps, max(1, steps // samples), scheme == "rk4")
    state, parts = _start(chain), []
    in_slice = min(max(1, SLICE // particles), steps + 1)
    rows = np.empty((in_slice, 3 * particles))  # one a step at most: time, u, v and force
    for first in range(0, steps + 1, in_slice):
        last = min(first + in_slice, steps + 1)
        count = shielded(_advance, chain, state, plan, first, last, rows)
        if count < 0:
            raise RequestError(f"step = {plan.step:.6g} s: no contact set fits, values overflow")
        parts.append(rows[:count].copy())
        progress(min(last, steps), steps)
    table = np.concatenate(parts)
    time, u, v, force = np.split(table, (1, particles + 1, 2 * particles + 1), axis=1)
    return ChainMotion(
        chain=chain, time=time[:, 0], displacements=u, velocities=v, forces=force, step=plan.step
    )


def _start(chain: Chain) -> tuple[Any, ...]:
    """Return u, v, accelerations of four stages, overlap, force, contact set; grain's contacts."""
    n = chain.diagonal.size
    accelerations, (overlap, force) = np.zeros((4, n + 1)), np.zeros((2, n))
    closed, factor, contacts = np.zeros(n, np.bool_), np.zeros((3, n)), np.array([-1])
    u, v = chain.displacement.copy(), chain.velocity.copy()
    return u, v, *accelerations, overlap, force, closed, factor, contacts


class _Plan(NamedTuple):
    """The steps of a run: size [s], number, and those between samples."""

    step: float
    steps: int
    every: int
    dense: bool  # Runge-Kutta, with a sample at each change of the grain's contacts


# Kernels take arrays one by one: to take one out of a tuple costs as much as a short row.


@compiled
def _advance(
    chain: Chain, state: tuple[Any, ...], plan: _Plan, first: int, last: int, rows: Floats
) -> int:
    """Take the steps from ``first`` to before ``last``.

    Return how many rows are written, -1 where no contact set fits.
    """
    u, v, a, b, c, d, overlap, force, closed, factor, contacts = state
    _, _, mobility, diagonal, coupling, gravity, _, _, length, deformable = chain
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
            _write(rows[row], count * h, u, v, force)
            row, contacts[0] = row + 1, touching
        if count == plan.steps:
            break
        if not dense:
            _add(v, half, a)
            _add(u, h, v)
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
            _add(v, half, a)
    return row


@compiled
def _write(row: Floats, time: float, u: Floats, v: Floats, force: Floats) -> None:
    """Write a sample in loops: numba takes 2 s to compile an assignment of arrays."""
    row[0] = time
    for i in range(u.size):
        row[1 + i], row[1 + u.size + i] = u[i], v[i]
    for i in range(force.size):
        row[1 + 2 * u.size + i] = force[i]


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

    A negative ``tolerance`` selects the overlap law, which needs no contact set.
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
def _add(sums: Floats, factor: float, terms: Floats) -> None:
    for i in range(sums.size):
        sums[i] += factor * terms[i]


# ---- a grain over columns, by velocity Verlet
#
# Along a column all contacts act on one another, the grain's among them: at closed contacts
# c_(i-1)/2 + c_i + c_(i+1)/2 is the overlap, with the compressions c (Harper, Dufek and Breard
# 2024). Dashpots act where the spring presses, by the velocities of the half step, as in DEM codes.


def run_columns(scene: Scene, height: int) -> Floats:
    """Return the start and the ends of stages of the first body, (K, 7) as of ``Motion.stages``.

    The others are columns of ``height`` particles, from the top down, a diameter apart along x,
    whose last one is fixed; ``scene.law`` is that of the grain, that of two types 1 within columns.
    Raise EngineNaNError where the motion overflows.
    """
    grain, rest = scene.bodies[0], np.array([body.position for body in scene.bodies[1:]])
    shape = rest.shape[0] // height, height
    diagonal, coupling = compliance(np.ones(height + 1), True)
    columns = _Columns(
        y=rest[:, 1].copy(),
        v=np.zeros(len(rest)),
        a=np.zeros(len(rest)),
        grain=np.array([[grain.position, grain.velocity, *np.zeros((3, 3))]]),
        diameter=2.0 * grain.radius,
        mass=grain.mass,
        stiffness=scene.law.normal_stiffness or 0.0,
        first=scene.law.dashpot(grain.mass, grain.radius, 0.0),
        inside=scene.law_of(1, 1).dashpot(grain.mass, grain.radius, 0.0),
        clipped=scene.law.clipped,
        gravity=np.array(scene.gravity),
        diagonal=diagonal,
        coupling=coupling,
        closed=np.zeros(shape, np.bool_),
        factor=np.zeros((shape[0], 3, height)),
        work=np.zeros((2, height)),
    )
    stages = stages_of(scene, Rules())
    shielded(_advance_columns, columns, stages)
    rows = stages.rows[: stages.progress[1]]
    if not np.isfinite(rows).all():
        raise EngineNaNError("columns: the motion is not finite (NaN)")
    return rows


class _Columns(NamedTuple):
    """Columns and grain in SI units; ``grain`` has its acceleration in the place of a force."""

    y: Floats  # (columns * height,)
    v: Floats
    a: Floats
    grain: Floats  # (1, 5, 3)
    diameter: float
    mass: float
    stiffness: float
    first: float  # [kg/s] dashpot of the grain's contacts
    inside: float  # [kg/s] of those within columns
    clipped: bool
    gravity: Floats  # (3,)
    diagonal: Floats  # (height,) [1] of particles of unit stiffness
    coupling: Floats
    closed: Flags  # (columns, height)
    factor: Floats  # (columns, 3, height)
    work: Floats  # (2, height) overlaps, compressions


@compiled
def _advance_columns(columns: _Columns, stages: Stages) -> None:
    """Take steps until a look ends the run."""
    grain, step = columns.grain, stages.step
    at, speed, pull = grain[0, POSITION], grain[0, VELOCITY], grain[0, FORCE]
    keep(grain, stages, 0)
    _set_accelerations(columns)
    for number in range(1, stages.last + 1):
        _add(speed, 0.5 * step, pull)
        _add(columns.v, 0.5 * step, columns.a)
        _add(columns.y, step, columns.v)
        _add(at, step, speed)
        _set_accelerations(columns)
        _add(speed, 0.5 * step, pull)
        _add(columns.v, 0.5 * step, columns.a)
        sequel = look(grain, stages, number)
        if sequel == OVER:
            return
        if sequel != GO_ON:  # a run of a code begins anew, by the velocities of the whole step
            _set_accelerations(columns)


@compiled
def _set_accelerations(columns: _Columns) -> None:
    """Set the accelerations of all by the present velocities; NaN where no contact set fits."""
    count, n = columns.closed.shape
    d, k, pull = columns.diameter, columns.stiffness, columns.grain[0, FORCE]
    at, speed = columns.grain[0, POSITION], columns.grain[0, VELOCITY]
    overlap, press = columns.work
    pull[0], pull[1] = columns.gravity[0], columns.gravity[1]
    for i in range(count):
        column = slice(i * n, (i + 1) * n)
        y, v, a = columns.y[column], columns.v[column], columns.a[column]
        dx, dy = at[0] - i * d, at[1] - y[0]
        dx -= count * d * math.floor(dx / (count * d) + 0.5)
        distance = math.hypot(dx, dy)
        overlap[0] = max(d - distance, 0.0)
        for j in range(1, n):
            overlap[j] = d - (y[j - 1] - y[j])
        closed, factor = columns.closed[i], columns.factor[i]
        diagonal, coupling = columns.diagonal, columns.coupling
        if not solve(overlap, diagonal, coupling, closed, factor, press, SLACK * d):
            pull[0] = math.nan
        for j in range(n):
            a[j] = columns.gravity[1]
        parting = ((speed[0] * dx) + (speed[1] - v[0]) * dy) / distance
        force = _force(columns, k * press[0], parting, columns.first)
        pull[0] += force * dx / distance / columns.mass
        pull[1] += force * dy / distance / columns.mass
        a[0] -= force * dy / distance / columns.mass
        for j in range(1, n):
            force = _force(columns, k * press[j], v[j - 1] - v[j], columns.inside)
            a[j - 1] += force / columns.mass
            a[j] -= force / columns.mass
        a[n - 1] = 0.0


@compiled
def _force(columns: _Columns, spring: float, parting: float, dashpot: float) -> float:
    """Return the force [N] of a spring that presses, with its dashpot."""
    if spring <= 0.0:
        return 0.0
    force = spring - dashpot * parting
    return max(force, 0.0) if columns.clipped else force
