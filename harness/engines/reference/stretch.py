"""Integrate a stretch of steps in compiled code, until the grain passes a place or turns back.

As in the LAMMPS script, it is looked at every 50 steps whether the grain has passed
a place or turned back.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.compiled import compiled
from harness.engines.reference import mfix_adams_bashforth, mfix_euler, rk4, velocity_verlet
from harness.engines.reference.row import Grain, Row, acceleration

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
