"""One grain over columns of particles that move along their axes, by velocity Verlet.

As LAMMPS has it: the dashpots see the velocities of the half step. The state of the columns is
arrays of shape (columns, height), the top first, of y [m], its velocity and acceleration; the last
particle of each is fixed.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.compiled import compiled
from harness.errors import EngineNaNError
from harness.parameters.scene import ContactScene
from harness.solvers.grain.row import ROUNDING, WATCH, Grain, Row, normal_force
from harness.solvers.grain.trajectory import InFixedSteps

Floats = NDArray[np.float64]


class Held(NamedTuple):
    """The columns: state, the damping of their own contacts [N s/m], the law, work space.

    ``closed`` (columns, height) are the contact sets that the deformable law begins its search
    from, contact 0 that with the grain; ``work`` (4, height) are overlaps, compressions, pivots
    and what substitution carries. Columns rest until the grain has touched them: ``awake``.
    """

    y: Floats
    v: Floats
    a: Floats
    damping: float
    deformable: bool
    closed: NDArray[np.bool_]
    work: Floats
    awake: NDArray[np.bool_]


@compiled
def accelerate(grain: Grain, vx: float, vy: float, row: Row, held: Held) -> tuple[float, float]:
    """Set the accelerations of the columns [m/s2] and return the grain's.

    ``vx``, ``vy`` are the grain's velocity [m/s] that dashpots see. Where the deformable law
    finds no contact set, the grain's is NaN.
    """
    count, n = held.y.shape
    d, period = row.diameter, count * row.diameter
    fx = fy = 0.0
    overlap, press = held.work[0], held.work[1]
    for i in range(count):
        y, v, a = held.y[i], held.v[i], held.a[i]
        dx = grain.x - i * d
        dx -= period * math.floor(dx / period + 0.5)
        dy = grain.y - y[0]
        distance = math.hypot(dx, dy)
        overlap[0] = d - distance if distance < d * (1.0 - ROUNDING) else 0.0
        held.awake[i] = held.awake[i] or overlap[0] > 0.0
        if not held.awake[i]:
            continue
        for j in range(1, n):
            overlap[j] = d - (y[j - 1] - y[j])
        if held.deformable:
            if not compress(overlap, held.closed[i], press, held.work):
                return math.nan, math.nan
        else:
            press[:] = np.maximum(overlap, 0.0)
        a[:] = row.normal
        if press[0] > 0.0:
            nx, ny = dx / distance, dy / distance
            parting = vx * nx + (vy - v[0]) * ny
            force = normal_force(press[0], parting, row.stiffness, row.damping, row.clipped)
            fx += force * nx
            fy += force * ny
            a[0] -= force * ny / row.mass
        for j in range(1, n):
            if press[j] > 0.0:
                parting = v[j - 1] - v[j]
                force = normal_force(press[j], parting, row.stiffness, held.damping, row.clipped)
                a[j - 1] += force / row.mass
                a[j] -= force / row.mass
        a[n - 1] = 0.0
    return fx / row.mass + row.along, fy / row.mass + row.normal


@compiled
def compress(overlap: Floats, closed: NDArray[np.bool_], press: Floats, work: Floats) -> bool:
    """Set the compressions ``press`` (n,) [m] of the deformable law; return whether they fit.

    T c - overlap >= 0, c >= 0, complementary, T = tridiag(1/2, 1, 1/2). Contacts of the wrong
    sign change one at a time, the first one first (Murty), which ends for a positive definite T.
    """
    n = overlap.size
    slack = 1e-14 * np.max(np.abs(overlap))
    for _ in range(100 * n):
        substitute(overlap, closed, press, work)
        wrong = -1
        for i in range(n):
            excess = press[i]
            if not closed[i]:
                excess = -overlap[i]
                if i > 0:
                    excess += 0.5 * press[i - 1]
                if i + 1 < n:
                    excess += 0.5 * press[i + 1]
            if excess < -slack:
                wrong = i
                break
        if wrong < 0:
            return True
        closed[wrong] = not closed[wrong]
    return False


@compiled
def substitute(overlap: Floats, closed: NDArray[np.bool_], press: Floats, work: Floats) -> None:
    """Set ``press`` to the solution of T c = overlap on the closed contacts, 0 on the open ones."""
    pivot, carried = work[2], work[3]
    n = overlap.size
    for i in range(n):
        if not closed[i]:
            carried[i] = pivot[i] = 0.0
            continue
        coupled = i > 0 and closed[i - 1]
        below = 0.5 / pivot[i - 1] if coupled else 0.0
        pivot[i] = 1.0 - 0.5 * below
        carried[i] = overlap[i] - (below * carried[i - 1] if coupled else 0.0)
    for i in range(n - 1, -1, -1):
        if not closed[i]:
            press[i] = 0.0
            continue
        beyond = press[i + 1] if i + 1 < n else 0.0
        press[i] = (carried[i] - 0.5 * beyond) / pivot[i]


@compiled
def kick(held: Held, half: float) -> None:
    """Add half a step's acceleration to the velocities of the columns."""
    for i in range(held.y.shape[0]):
        if held.awake[i]:
            for j in range(held.y.shape[1]):
                held.v[i, j] += half * held.a[i, j]


@compiled
def advance(grain: Grain, row: Row, held: Held, step: float) -> Grain:
    """Return the grain one step [s] later, and move the columns."""
    half = 0.5 * step
    vx, vy = grain.vx + half * grain.ax, grain.vy + half * grain.ay
    kick(held, half)
    for i in range(held.y.shape[0]):
        if held.awake[i]:
            for j in range(held.y.shape[1]):
                held.y[i, j] += step * held.v[i, j]
    moved = Grain(grain.x + step * vx, grain.y + step * vy, vx, vy, 0.0, 0.0)
    ax, ay = accelerate(moved, vx, vy, row, held)
    kick(held, half)
    return Grain(moved.x, moved.y, vx + half * ax, vy + half * ay, ax, ay)


@compiled
def advance_by(grain: Grain, row: Row, held: Held, step: float, steps: int) -> Grain:
    """Return the grain after so many steps of ``step`` [s], and move the columns."""
    for _ in range(steps):
        grain = advance(grain, row, held, step)
    return grain


@compiled
def begin(grain: Grain, row: Row, held: Held) -> Grain:
    """Return the grain with the acceleration of its place and velocity, and set the columns'."""
    ax, ay = accelerate(grain, grain.vx, grain.vy, row, held)
    return Grain(grain.x, grain.y, grain.vx, grain.vy, ax, ay)


CLOCK = 10_000
"""Steps between two looks at the clock."""


def held_of(scene: ContactScene, row: Row) -> Held:
    """Return the columns of a scene as the kernels take them."""
    assert scene.columns is not None
    n = scene.columns.height
    y = scene.position[1:, 1].reshape(-1, n).copy()
    return Held(
        y=y,
        v=np.zeros_like(y),
        a=np.zeros_like(y),
        damping=row.damping if scene.columns.damped else 0.0,
        deformable=scene.columns.law == "deformable",
        closed=np.ones(y.shape, dtype=np.bool_),
        work=np.zeros((4, n)),
        awake=np.zeros(len(y), dtype=np.bool_),
    )


class OverColumns(InFixedSteps):
    """The grain over columns in steps of a scene, looked at and sampled as over a row."""

    def __init__(self, grain: Grain, row: Row, scene: ContactScene, seconds: float) -> None:
        self._row, self._held = row, held_of(scene, row)
        grain = begin(grain, row, self._held)
        super().__init__(grain, scene.step, scene.steps, scene.every, seconds)

    @property
    def touching(self) -> bool:
        """Return whether the grain overlaps a top."""
        d, (count, _) = self._row.diameter, self._held.y.shape
        first = math.floor(self.grain.x / d)
        tops = [(i * d, self._held.y[i % count, 0]) for i in (first, first + 1)]
        return any(math.hypot(self.grain.x - x, self.grain.y - y) < d for x, y in tops)

    def energy(self, row: Row) -> float:
        """Return the energy [J] of the motion and the height of the grain."""
        x, y, vx, vy = self.grain[:4]
        return 0.5 * row.mass * (vx * vx + vy * vy) - row.mass * (row.along * x + row.normal * y)

    def watch(self, place: float, floor: float) -> None:  # noqa: ARG002 - looked at every 50 steps
        """Move until x > ``place`` [m], the grain moves back, or the time limit."""
        self.grain = begin(self.grain, self._row, self._held)  # LAMMPS's run takes forces anew
        self._go(place)

    def _go(self, place: float, *, watched: bool = True) -> None:
        while not self.over:
            steps = min(WATCH - self.steps % WATCH, self._longest - self.steps)
            if self._every:
                steps = min(steps, self._every - self.steps % self._every)
            self.grain = advance_by(self.grain, self._row, self._held, self._step, steps)
            self.steps += steps
            if not math.isfinite(sum(self.grain[:4])):
                raise EngineNaNError(
                    f"reference: the grain's state is not a number (NaN) by step {self.steps}"
                )
            if self._every and self.steps % self._every == 0:
                self._keep(np.array([[self.time, *self.grain[:4]]]))
            look = self.steps % WATCH == 0 or self.over
            if watched and look and (self.grain.x > place or self.grain.vx < 0.0):
                return
            if self.steps % CLOCK == 0:
                self._look_at_clock()
