"""Smooth motion in contact: steps with error control, up to one in which a piece may end."""

from __future__ import annotations

import math

import numpy as np

from harness.pair.between import look
from harness.pair.extrapolation import ORDER, step
from harness.pair.records import Floats, Integers, System
from harness.pair.scales import state_scales
from harness.pair.vectors import compiled

GROWTH = 4.0
"""Of a step against the one before it, at most."""


@compiled
def proceed(
    y: Floats,
    span: tuple[float, float],
    control: tuple[float, float, float],
    system: System,
    modes: Integers,
) -> tuple[tuple[Floats, Floats], tuple[float, float, float], int]:
    """Take steps through a ``span`` of time, as long as nothing may end in one.

    ``control``: first step [s], shortest step [s], tolerance. Return the states at the begin and
    the end of the step in which something may end; the time of its begin, its length, and the next
    step [s]; and how many steps were taken before it. The length is 0 where nothing ends, and NaN
    where no step meets the tolerance.
    """
    time, end = span
    h, shortest, tolerance = control
    taken = 0
    after = y
    while time < end:
        scale = state_scales(y, system, modes)
        part, truncated = min(h, end - time), h > end - time
        while True:
            after, error = step(y, part, scale, system, modes)
            change = 0.8 * (tolerance / max(error, 1e-30)) ** (1.0 / ORDER)
            if error <= tolerance:
                break
            part, truncated = part * max(0.1, change), False
            if not part > shortest:
                return (y, after), (time, math.nan, h), taken
        # an error of round-off does not fall with the step and must not hold it
        change = max(change, 1.5) if error < 0.3 * tolerance else change
        following = h if truncated else part * min(GROWTH, change)
        last, near = look(y, after, part, system, modes)
        if np.any(last > 0.0) or np.any(near > 0.0):
            return (y, after), (time, part, following), taken
        time = end if part == end - time else time + part
        y, h = after, following
        taken += 1
    return (y, after), (time, 0.0, h), taken
