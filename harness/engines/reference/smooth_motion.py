"""The motion between two changes of contact: which spheres push is given, not looked up."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from harness.compiled import compiled
from harness.engines.reference.row import Row, contact_force

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
