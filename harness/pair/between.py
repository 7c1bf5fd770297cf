"""What may end a piece of the motion within a step and no longer does at its end.

An ending is looked at where the cubic that has the states and rates of both ends of the step
leads: it is off by h^4 / 384 of the fourth derivative at most, enough to tell where to look closer.
"""

from __future__ import annotations

import numpy as np

from harness.pair.rates import KINDS, endings, rates
from harness.pair.records import Floats, Integers, System
from harness.pair.vectors import compiled

PLACES = 4
"""Parts of a step at whose ends endings are looked at."""

BAND = 0.1
"""[range of an ending in a step] below 0 where its peak may be positive: the cubic is nearer."""


@compiled
def look(
    before: Floats, after: Floats, h: float, system: System, modes: Integers
) -> tuple[Floats, Floats]:
    """Return endings at the end of a step, and when [s] within it they may be positive, else 0.

    Both (contacts, 6). ``before`` and ``after`` are the states at both ends of ``h`` seconds.
    """
    size = len(before)
    first, last = np.empty(size), np.empty(size)
    rates(before, system, modes, first)
    rates(after, system, modes, last)
    seen = np.empty((PLACES + 1, len(system.contacts), KINDS))
    moved = after - before
    for place in range(PLACES + 1):
        s = place / PLACES
        y = before + s * moved
        y += s * (1.0 - s) * ((1.0 - s) * (h * first - moved) - s * (h * last - moved))
        seen[place] = endings(y, system, modes)
    near = np.zeros((len(system.contacts), KINDS))
    for c in range(len(system.contacts)):
        for kind in range(KINDS):
            near[c, kind] = h / PLACES * _peak(seen[:, c, kind])
    return seen[PLACES], near


@compiled
def _peak(values: Floats) -> float:
    """Return where the parabola through three neighbours is highest and near 0; else 0."""
    band = BAND * (values.max() - values.min())
    for middle in range(1, PLACES):
        left, here, right = values[middle - 1], values[middle], values[middle + 1]
        bend, slope = left - 2.0 * here + right, 0.5 * (right - left)
        if not bend < 0.0:
            continue
        # beside its own half of the neighbours, the outermost parabolas tell up to the ends
        low = -1.0 if middle == 1 else -0.5
        high = 1.0 if middle == PLACES - 1 else 0.5
        if low < -slope / bend < high and here - 0.5 * slope * slope / bend > -band:
            return float(middle - slope / bend)
    return 0.0
