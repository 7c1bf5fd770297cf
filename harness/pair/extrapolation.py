"""One step of high order: Gragg's modified midpoint rule, extrapolated (Bulirsch and Stoer).

Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.9. Increments
are extrapolated instead of states, so that small overlaps of bodies far from the origin do not
drown in round-off. Six columns give order 12; the last two of them estimate the error.
"""

from __future__ import annotations

import numpy as np

from harness.pair.rates import rates
from harness.pair.records import Floats, Integers, System
from harness.pair.vectors import compiled

COLUMNS = 6
ORDER = 2 * COLUMNS

ROUND_OFF = 10.0
"""[1/increment] in the scale of an increment, for its own round-off cannot be got below."""


@compiled
def step(
    y: Floats, h: float, scale: Floats, system: System, modes: Integers
) -> tuple[Floats, float]:
    """Return the state after ``h`` and the largest estimated error over ``scale``."""
    size = len(y)
    first, slope, moved = np.empty(size), np.empty(size), np.empty(size)
    before, now, last = np.empty(size), np.empty(size), np.zeros(size)
    table = np.zeros((COLUMNS, size))
    rates(y, system, modes, first)
    for row in range(COLUMNS):
        parts = 2 * (row + 1)
        part = h / parts
        for k in range(size):
            before[k], now[k] = 0.0, part * first[k]
            moved[k] = y[k] + now[k]
        for _ in range(parts - 1):
            rates(moved, system, modes, slope)
            for k in range(size):
                before[k], now[k] = now[k], before[k] + 2.0 * part * slope[k]
                moved[k] = y[k] + now[k]
        rates(moved, system, modes, slope)
        for k in range(size):
            smooth = 0.5 * (now[k] + before[k] + part * slope[k])
            # Aitken and Neville in h^2: each row overwrites the one before, from the left
            for column in range(row):
                ratio = ((row + 1.0) / (row - column)) ** 2
                held = smooth + (smooth - table[column, k]) / (ratio - 1.0)
                table[column, k] = smooth
                if column == row - 1:
                    last[k] = smooth
                smooth = held
            table[row, k] = smooth
    error = 0.0
    for k in range(size):
        size_k = scale[k] + ROUND_OFF * abs(table[COLUMNS - 1, k])
        difference = abs(table[COLUMNS - 1, k] - last[k]) / size_k
        if not difference <= error:  # a number that is none counts as an error
            error = difference
    return y + table[COLUMNS - 1], error
