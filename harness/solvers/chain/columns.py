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
from harness.model.scene import LOOK, Scene
from harness.solvers.chain.contacts import solve
from harness.solvers.chain.setup import Flags, Floats

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
        grain=np.array([*grain.position[:2], *grain.velocity[:2], 0.0, 0.0]),
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
    places = np.array([stage.place for stage in scene.stages])
    floors = np.array([stage.floor for stage in scene.stages])
    rows = np.zeros((len(places) + 2, 7))
    count = shielded(_advance, columns, scene.step, scene.steps, places, floors, rows)
    if not np.isfinite(rows[:count]).all():
        raise EngineNaNError("columns: the motion is not finite (NaN)")
    return rows[:count]


class _Columns(NamedTuple):
    """Columns and grain: places and motion in SI units; ``grain`` is x, y, vx, vy, ax, ay."""

    y: Floats  # (columns, height)
    v: Floats
    a: Floats
    grain: Floats  # (6,)
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
def _advance(
    columns: _Columns, step: float, steps: int, places: Floats, floors: Floats, rows: Floats
) -> int:
    """Take steps until a look ends the run; return how many rows are kept."""
    stage, kept, g = 0, 1, columns.grain
    _keep(g, 0, step, rows[0])
    _set_accelerations(columns)
    for number in range(1, steps + 1):
        _kick(columns, 0.5 * step)
        columns.y[:] += step * columns.v
        g[:2] += step * g[2:4]
        _set_accelerations(columns)
        _kick(columns, 0.5 * step)
        if number % LOOK and number < steps:
            continue
        beyond = g[0] > places[stage]
        if not (beyond or g[2] < 0.0 or number == steps or math.isnan(g[2])):
            continue
        fall = columns.gravity[0] * g[0] + columns.gravity[1] * g[1]
        energy = columns.mass * (0.5 * (g[2] * g[2] + g[3] * g[3]) - fall)
        over = number == steps or not energy >= floors[stage] or math.isnan(g[2])
        if beyond:
            stage += 1
            over = stage == places.size or number == steps
        if beyond or over:
            _keep(g, number, step, rows[kept])
            kept += 1
        if over:
            return kept
        # a run of a code begins anew, by the velocities of the whole step
        _set_accelerations(columns)
    return kept


@compiled
def _keep(grain: Floats, number: int, step: float, row: Floats) -> None:
    row[0], row[1] = number, number * step
    row[2:6] = grain[:4]


@compiled
def _kick(columns: _Columns, seconds: float) -> None:
    columns.grain[2:4] += seconds * columns.grain[4:]
    columns.v[:] += seconds * columns.a


@compiled
def _set_accelerations(columns: _Columns) -> None:
    """Set the accelerations of all by the present velocities; NaN where no contact set fits."""
    count, n = columns.y.shape
    g, d, k = columns.grain, columns.diameter, columns.stiffness
    overlap, press = columns.work
    ones, halves = np.ones(n), np.full(n, 0.5)
    halves[n - 1] = 0.0
    g[4:] = columns.gravity
    for i in range(count):
        y, v, a = columns.y[i], columns.v[i], columns.a[i]
        dx, dy = g[0] - i * d, g[1] - y[0]
        dx -= count * d * math.floor(dx / (count * d) + 0.5)
        distance = math.hypot(dx, dy)
        overlap[0] = max(d - distance, 0.0)
        for j in range(1, n):
            overlap[j] = d - (y[j - 1] - y[j])
        closed, factor = columns.closed[i], columns.factor[i]
        if not solve(overlap, ones, halves, closed, factor, press, SLACK * d):
            g[4] = math.nan
        a[:] = columns.gravity[1]
        parting = ((g[2] * dx) + (g[3] - v[0]) * dy) / distance
        force = _force(columns, k * press[0], parting, columns.first)
        g[4] += force * dx / distance / columns.mass
        g[5] += force * dy / distance / columns.mass
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
