"""A grain over columns of particles under the deformable law, in steps of velocity Verlet.

Along a column all contacts act on one another, the grain's among them: at closed contacts
c_(i-1)/2 + c_i + c_(i+1)/2 is the overlap, with the compressions c (Harper, Dufek and Breard 2024).
Dashpots act where the spring presses, by the velocities of the half step, as in DEM codes.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from harness.compiled import compiled, shielded
from harness.errors import EngineNaNError
from harness.model.conventions import Rules
from harness.model.scene import Scene
from harness.solvers.chain.contacts import solve
from harness.solvers.chain.motion import Flags, Floats
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

SLACK = 1e-14  # gaps as far below 0 are rounding [diameters]


def run(scene: Scene, height: int) -> Floats:
    """Return the start and the ends of stages of the first body, (K, 7) as of ``Motion.stages``.

    The others are columns of ``height`` particles, from the top down, a diameter apart along x,
    whose last one is fixed; ``scene.law`` is that of the grain, that of two types 1 within columns.
    Raise EngineNaNError where the motion overflows.
    """
    grain, rest = scene.bodies[0], np.array([body.position for body in scene.bodies[1:]])
    inside, mass, radius = scene.law_of(1, 1), grain.mass, grain.radius
    shape = rest.shape[0] // height, height
    columns = _Columns(
        y=np.ascontiguousarray(rest[:, 1].reshape(shape)),
        v=np.zeros(shape),
        a=np.zeros(shape),
        grain=np.array([[grain.position, grain.velocity, *np.zeros((3, 3))]]),
        diameter=2.0 * radius,
        mass=mass,
        stiffness=scene.law.normal_stiffness or 0.0,
        first=scene.law.dashpot(mass, radius, 0.0),
        inside=inside.dashpot(mass, radius, 0.0),
        clipped=scene.law.clipped,
        gravity=np.array(scene.gravity[:2]),
        closed=np.zeros(shape, np.bool_),
        factor=np.zeros((shape[0], 3, height)),
        work=np.zeros((2, height)),
    )
    stages = stages_of(scene, Rules())
    shielded(_advance, columns, stages)
    rows = stages.rows[: stages.progress[1]]
    if not np.isfinite(rows).all():
        raise EngineNaNError("columns: the motion is not finite (NaN)")
    return rows


class _Columns(NamedTuple):
    """Columns and grain: places and motion in SI units; ``grain`` has its acceleration as force."""

    y: Floats  # (columns, height)
    v: Floats
    a: Floats
    grain: Floats  # (1, 5, 3)
    diameter: float
    mass: float
    stiffness: float
    first: float  # [kg/s] dashpot of the grain's contacts
    inside: float  # [kg/s] of those within columns
    clipped: bool
    gravity: Floats  # (2,)
    closed: Flags  # (columns, height)
    factor: Floats  # (columns, 3, height)
    work: Floats  # (2, height) overlaps, compressions


@compiled
def _advance(columns: _Columns, stages: Stages) -> None:
    """Take steps until a look ends the run."""
    grain, step = columns.grain, stages.step
    keep(grain, stages, 0)
    _set_accelerations(columns)
    for number in range(1, stages.last + 1):
        _kick(columns, 0.5 * step)
        _add(columns.y, step, columns.v)
        grain[0, POSITION] += step * grain[0, VELOCITY]
        _set_accelerations(columns)
        _kick(columns, 0.5 * step)
        sequel = look(grain, stages, number)
        if sequel == OVER:
            return
        if sequel != GO_ON:  # a run of a code begins anew, by the velocities of the whole step
            _set_accelerations(columns)


@compiled
def _kick(columns: _Columns, seconds: float) -> None:
    columns.grain[0, VELOCITY] += seconds * columns.grain[0, FORCE]
    _add(columns.v, seconds, columns.a)


@compiled
def _add(sums: Floats, factor: float, terms: Floats) -> None:
    """Add in a loop: numba takes a second to compile an assignment to a slice."""
    for i in range(sums.shape[0]):
        for j in range(sums.shape[1]):
            sums[i, j] += factor * terms[i, j]


@compiled
def _set_accelerations(columns: _Columns) -> None:
    """Set the accelerations of all by the present velocities; NaN where no contact set fits."""
    count, n = columns.y.shape
    d, k, pull = columns.diameter, columns.stiffness, columns.grain[0, FORCE]
    at, speed = columns.grain[0, POSITION], columns.grain[0, VELOCITY]
    overlap, press = columns.work
    ones, halves = np.ones(n), np.full(n, 0.5)
    halves[n - 1] = 0.0
    pull[:2] = columns.gravity
    for i in range(count):
        y, v, a = columns.y[i], columns.v[i], columns.a[i]
        dx, dy = at[0] - i * d, at[1] - y[0]
        dx -= count * d * math.floor(dx / (count * d) + 0.5)
        distance = math.hypot(dx, dy)
        overlap[0] = max(d - distance, 0.0)
        for j in range(1, n):
            overlap[j] = d - (y[j - 1] - y[j])
        closed, factor = columns.closed[i], columns.factor[i]
        if not solve(overlap, ones, halves, closed, factor, press, SLACK * d):
            pull[0] = math.nan
        a[:] = columns.gravity[1]
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
