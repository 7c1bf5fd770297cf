"""Whether samples of a motion belong together: positions, velocities, accelerations.

Over an interval h a value y changes by h/2 (y'_1 + y'_2), to within h^3/12 y'''. What is left is
held against second differences of the rate, h |D2 y'|, and against third differences of the value
itself, |D3 y|, of the intervals around: each bounds it, also where a rate jumps (by J within the
interval: at most h J/2 is left, the differences are h J, and h J/2 at least). A wrong sample opens
its own bound and not the other's, so the smaller of the two is what a motion must keep.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]

ROOM = 3.0
"""Times the bound: codes in velocity Verlet leave 0.25 to 0.3 of it, whatever the step."""

AROUND = 3
"""Intervals on either side whose differences count."""

FEWEST = 5
"""Samples that differences need."""


def contradiction(
    values: Floats, rates: Floats, interval: float, rounding: float, late: float = 0.0
) -> tuple[int, int] | None:
    """Return row and column of the first sample where values do not move with their rates.

    ``values`` and ``rates`` are (M, N), M samples ``interval`` [s] apart; ``rounding`` is that of
    a value; ``late`` [s] is how far the rates may be from the time of the values. None where all
    belong together, or where there are too few to tell.
    """
    if len(values) < FEWEST:
        return None
    left = np.abs(np.diff(values, axis=0) - 0.5 * interval * (rates[1:] + rates[:-1]))
    by_rates = interval * _around(np.diff(rates, 2, axis=0), len(left))
    by_values = _around(np.diff(values, 3, axis=0), len(left))
    if late > 0.0:
        by_rates += late * _around(np.diff(rates, axis=0), len(left))
        by_values += late / interval * _around(np.diff(values, 2, axis=0), len(left))
    allowed = ROOM * np.minimum(by_rates, by_values)
    allowed += rounding + interval * float(np.finfo(float).eps) * np.abs(rates).max(initial=0.0)
    wrong = np.argwhere(left > allowed)
    return None if wrong.size == 0 else (int(wrong[0, 0]) + 1, int(wrong[0, 1]))


def _around(differences: Floats, intervals: int) -> Floats:
    """Return the largest size of differences around each interval, shape (intervals, N)."""
    sizes = np.abs(differences)
    most = np.zeros((intervals, *sizes.shape[1:]))
    for shift in range(-AROUND, AROUND):
        first, last = max(0, -shift), min(intervals, len(sizes) - shift)
        np.maximum(most[first:last], sizes[first + shift : last + shift], out=most[first:last])
    return most
