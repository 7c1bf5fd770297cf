"""Interpolate the motion of the grain between samples."""

from __future__ import annotations

import numpy as np

from harness.observables.tower import Floats, TowerRun


def hermite(time: Floats, value: Floats, rate: Floats, at: float) -> float:
    """Return the cubic through values and rates (M,) on both sides of ``at`` [s].

    Its error is of fourth order in the distance of the samples.
    """
    i = int(np.clip(np.searchsorted(time, at, side="right") - 1, 0, time.size - 2))
    width = float(time[i + 1] - time[i])
    if width == 0:
        return float(value[i])
    s = (at - float(time[i])) / width
    start, end = float(value[i]), float(value[i + 1])
    left, right = width * float(rate[i]), width * float(rate[i + 1])
    cubic = 2 * (start - end) + left + right
    return start + s * (left + s * (3 * (end - start) - 2 * left - right + s * cubic))


def grain_acceleration(run: TowerRun) -> Floats:
    """Return the acceleration of the grain (M,) [m/s2]."""
    return run.tower.gravity - run.grain_force / run.tower.each("mass")[0]


def grain_velocity_at(run: TowerRun, time: float) -> float:
    """Return the velocity of the grain [m/s] at ``time`` [s]."""
    return hermite(run.time, run.grain_velocity, grain_acceleration(run), time)
