"""Integrators of the grain's trajectory in fixed steps: their interface, stability, stretches.

The motion between two changes of contact: which spheres push is given, not looked up.

The interface of the integrators of the grain's trajectory: fixed steps, or adaptive.

Integrate a stretch of steps in compiled code, until the grain passes a place or turns back.

As in the LAMMPS script, it is looked at every 50 steps whether the grain has passed
a place or turned back.

Motion in fixed steps, by any of the compiled integrators.

How large a step of each integrator may be: linear stability in the well.

In the well the two contacts stand 60 deg apart. Motion normal to the row feels
3/2 of one contact's spring and dashpot, x'' + 3 zeta omega x' + 3/2 omega^2 x = 0, with
omega = sqrt(k/m) and zeta = eta / (2 sqrt(k m)); along the row it feels 1/2, and on one
sphere it feels 1. Each integrator states its ``growth``, the largest factor by which this
motion grows in one step; it is stable until the growth exceeds 1.
"""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from harness.compiled import compiled
from harness.errors import EngineMemoryError, EngineNaNError, EngineTimeoutError
from harness.observables.reference import Trajectory
from harness.solvers.grain import mfix_adams_bashforth, mfix_euler, rk4, velocity_verlet
from harness.solvers.grain.row import Grain, Row, acceleration, contact_force

State = NDArray[np.float64]
"""x from the sphere behind [m], y [m], vx, vy [m/s]."""


@compiled
def overlap(state: State, row: Row, sphere: int) -> float:
    """Return the overlap [m] with a sphere (0 behind, 1 ahead); negative is a gap."""
    return row.diameter - math.hypot(state[0] - sphere * row.diameter, state[1])


@compiled
def unclipped_force(state: State, row: Row, sphere: int) -> float:
    """Return the force [N] that a sphere would exert, not clipped."""
    dx, dy = state[0] - sphere * row.diameter, state[1]
    distance = math.hypot(dx, dy)
    speed = (state[2] * dx + state[3] * dy) / distance
    return contact_force(row.diameter - distance, speed, row, False)


@compiled
def rate_of_change(state: State, row: Row, behind: bool, ahead: bool) -> State:
    """Return the state's rate of change while the same spheres push."""
    rate = np.array([state[2], state[3], row.along, row.normal])
    for sphere in range(2):
        if (sphere == 0 and behind) or (sphere == 1 and ahead):
            dx, dy = state[0] - sphere * row.diameter, state[1]
            push = unclipped_force(state, row, sphere) / (row.mass * math.hypot(dx, dy))
            rate[2] += push * dx
            rate[3] += push * dy
    return rate


def energy(state: State, behind: int, row: Row) -> float:
    """Return the mechanical energy [J], zero at the centre of the first fixed sphere.

    The state's x counts from sphere ``behind`` of the row.
    """
    x = state[0] + behind * row.diameter
    power, share = (2.5, 0.4) if row.hertz else (2.0, 0.5)
    spheres = (0,) if row.single else (0, 1)
    springs = sum(max(overlap(state, row, sphere), 0.0) ** power for sphere in spheres)
    motion = 0.5 * row.mass * (state[2] * state[2] + state[3] * state[3])
    weight = row.mass * (row.along * x + row.normal * state[1])
    return float(motion - weight + share * row.stiffness * springs)


MOST_SAMPLES = 10_000_000


class TrajectoryIntegrator(ABC):
    """A grain in motion: ``grain``, ``steps`` taken, ``time`` [s], and its samples."""

    grain: Grain
    steps: int = 0

    def __init__(self, grain: Grain, seconds: float) -> None:
        self.grain = grain
        self._deadline = time.monotonic() + seconds
        self._seconds = seconds
        self._samples: list[NDArray[np.float64]] = []
        self._count = 0

    @property
    @abstractmethod
    def time(self) -> float:
        """Return the time [s] since the start."""

    @property
    @abstractmethod
    def over(self) -> bool:
        """Return whether the time limit is reached."""

    @property
    def touching(self) -> bool | None:
        """Return whether the grain is in contact; None where its place tells."""
        return None

    @np.errstate(over="ignore", invalid="ignore")  # NaN is the method's to name
    def energy(self, row: Row) -> float:
        """Return the mechanical energy [J] that decides whether a grain that moves back is lost."""
        x, y, vx, vy = self.grain[:4]
        behind = 0 if row.single or not math.isfinite(x) else math.floor(x / row.diameter)
        return energy(np.array([x - behind * row.diameter, y, vx, vy]), behind, row)

    @abstractmethod
    def watch(self, place: float, floor: float) -> None:
        """Move until x > ``place`` [m], the grain turns back, or the time limit.

        A grain that moves back is given up when its energy falls below ``floor``
        [J]: a method without steps needs to be told. Raise EngineNaNError when
        the state overflows, EngineTimeoutError when it takes too long.
        """

    @abstractmethod
    def finish(self) -> None:
        """Move to the time limit, whatever the grain does. Errors as for ``watch``."""

    def trajectory(self) -> Trajectory:
        """Return the samples taken."""
        return Trajectory(*np.concatenate(self._samples).T)

    def _keep(self, rows: NDArray[np.float64]) -> None:
        """Keep samples, shape (rows, 5)."""
        self._count += len(rows)
        if self._count > MOST_SAMPLES:
            raise EngineMemoryError(f"reference: more than {MOST_SAMPLES:g} samples of one run")
        self._samples.append(rows)

    def _look_at_clock(self) -> None:
        if time.monotonic() > self._deadline:
            raise EngineTimeoutError(
                f"reference: not finished after {self._seconds:g} s of wall time, "
                f"at step {self.steps}"
            )


class InFixedSteps(TrajectoryIntegrator):
    """The grain in steps of ``step`` [s], at most ``longest`` of them, sampled every so many."""

    def __init__(
        self, grain: Grain, step: float, longest: int, every: int | None, seconds: float
    ) -> None:
        super().__init__(grain, seconds)
        self._step, self._longest, self._every = step, longest, every or 0
        if every:
            self._keep(np.array([[0.0, *grain[:4]]]))

    @property
    def time(self) -> float:
        """Return the time [s] since the start."""
        return self.steps * self._step

    @property
    def over(self) -> bool:
        """Return whether the time limit is reached."""
        return self.steps >= self._longest

    def finish(self) -> None:
        """Move to the time limit."""
        self._go(math.inf, watched=False)

    @abstractmethod
    def _go(self, place: float, *, watched: bool = True) -> None:
        """Move to the time limit, or where ``watch`` ends if it is watched."""


VELOCITY_VERLET, MFIX_EULER, MFIX_ADAMS_BASHFORTH, RK4 = range(4)

WATCH = 50
"""Steps between two looks, counted from the start of the motion."""


class End(IntEnum):
    """Why a stretch ended."""

    LAST_STEP = 0
    DECISION = 1
    FULL = 2
    NOT_A_NUMBER = 3


_LAST_STEP, _DECISION, _FULL, _NOT_A_NUMBER = (int(end) for end in End)


@compiled
def begin(method: int, grain: Grain, row: Row) -> Grain:
    """Return the grain with what the method has to remember: the acceleration of its start."""
    if method in (VELOCITY_VERLET, MFIX_ADAMS_BASHFORTH):
        ax, ay = acceleration(grain.x, grain.y, grain.vx, grain.vy, row)
        return Grain(grain.x, grain.y, grain.vx, grain.vy, ax, ay)
    return grain


@compiled
def advance(method: int, grain: Grain, row: Row, step: float, steps: int) -> Grain:
    """Return the grain after so many steps of ``step`` [s]."""
    if method == VELOCITY_VERLET:
        for _ in range(steps):
            grain = velocity_verlet.advance(grain, row, step)
    elif method == MFIX_EULER:
        for _ in range(steps):
            grain = mfix_euler.advance(grain, row, step)
    elif method == MFIX_ADAMS_BASHFORTH:
        for _ in range(steps):
            grain = mfix_adams_bashforth.advance(grain, row, step)
    else:
        for _ in range(steps):
            grain = rk4.advance(grain, row, step)
    return grain


class Scheme(NamedTuple):
    """A method, the row that it moves a grain over, and its step [s]."""

    method: int
    row: Row
    step: float


@compiled
def stretch(
    scheme: Scheme, grain: Grain, count: int, last: int, watched: bool,
    place: float, every: int, samples: NDArray[np.float64],
) -> tuple[Grain, int, int, int]:  # fmt: skip
    """Advance from step ``count`` to ``last`` at most; return grain, count, End and samples taken.

    ``watched``: stop at a look when x > ``place`` [m] or vx < 0. Every so many
    steps (0: never) time, position and velocity go to a row of ``samples``,
    shape (rows, 5); it stops when they are full.
    """
    taken = 0
    while count < last:
        steps = min(WATCH - count % WATCH, last - count)
        if every > 0:
            steps = min(steps, every - count % every)
        grain = advance(scheme.method, grain, scheme.row, scheme.step, steps)
        count += steps
        if every > 0 and count % every == 0:
            samples[taken, 0] = count * scheme.step
            samples[taken, 1], samples[taken, 2] = grain.x, grain.y
            samples[taken, 3], samples[taken, 4] = grain.vx, grain.vy
            taken += 1
        if count % WATCH == 0 or count == last:
            if not math.isfinite(grain.x + grain.y + grain.vx + grain.vy):
                return grain, count, taken, _NOT_A_NUMBER
            if watched and (grain.x > place or grain.vx < 0.0):
                return grain, count, taken, _DECISION
        if taken == len(samples) and every > 0:
            return grain, count, taken, _FULL
    return grain, count, taken, _LAST_STEP


AT_ONCE = 20_000_000
"""Steps between two looks at the clock."""

ROWS = 65_536
"""Samples kept at once."""


class FixedStep(InFixedSteps):
    """The grain over a row, in fixed steps of a method."""

    def __init__(
        self, method: int, grain: Grain, row: Row, step: float, longest: int,
        every: int | None, seconds: float,
    ) -> None:  # fmt: skip
        super().__init__(begin(method, grain, row), step, longest, every, seconds)
        self._method, self._row = method, row
        self._buffer = np.empty((ROWS if every else 1, 5))

    def watch(self, place: float, floor: float) -> None:  # noqa: ARG002 - looked at every 50 steps
        """Move until x > ``place`` [m], the grain moves back, or the time limit."""
        if self._method == VELOCITY_VERLET:  # LAMMPS's ``run`` takes the forces anew
            self.grain = begin(self._method, self.grain, self._row)
        self._go(place)

    def _go(self, place: float, *, watched: bool = True) -> None:
        end, scheme = End.FULL, Scheme(self._method, self._row, self._step)
        while end is End.FULL or (end is End.LAST_STEP and not self.over):
            self._look_at_clock()
            last = min(self._longest, self.steps + AT_ONCE)
            self.grain, self.steps, taken, code = stretch(
                scheme, self.grain, self.steps, last, watched, place, self._every, self._buffer
            )
            end = End(code)
            if taken:
                self._keep(self._buffer[:taken].copy())
        if end is End.NOT_A_NUMBER:
            raise EngineNaNError(
                f"reference: the grain's state overflowed (NaN) by step {self.steps}"
            )


Growth = Callable[[float, float], float]
"""Of a step [1/omega] and a damping ratio zeta (with the grain's whole mass)."""

ROUNDING = 1e-12
"""A growth this far above 1 is rounding of the roots: that of an undamped oscillator is 1."""

SMALLEST, FINENESS = 0.01, 1.02
"""The first step tried, over 1 + 3 zeta, and the factor from one to the next."""


def fewest_steps_per_contact(growth: Growth, zeta: float) -> float:
    """Return the steps per contact time pi sqrt(m/k) below which an integrator is unstable.

    Infinite when it is unstable at every step. The step is widened by 2 % until the growth
    passes 1, and the crossing located.
    """

    def excess(step: float) -> float:
        return growth(step, zeta) - 1.0 - ROUNDING

    step = SMALLEST / (1.0 + 3.0 * zeta)
    if excess(step) > 0.0:
        return math.inf
    while excess(step) <= 0.0:
        step *= FINENESS
    largest: float = brentq(excess, step / FINENESS, step, xtol=1e-12)
    return math.pi / largest
