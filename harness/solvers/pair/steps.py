"""Steps of smooth motion with error control, and the time in a step at which a piece ends.

A step is Gragg's modified midpoint rule, extrapolated (Bulirsch and Stoer; Hairer, Norsett and
Wanner, Solving Ordinary Differential Equations I, section II.9). Increments are extrapolated
instead of states, so that small overlaps of bodies far from the origin do not drown in round-off.
Six columns give order 12; the last two of them estimate the error.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from harness.solvers.pair.friction import STICK
from harness.solvers.pair.rates import KINDS, SLIDERS, endings, rates, slider_spring, state_scales
from harness.solvers.pair.records import Floats, Integers, System, compiled, length

COLUMNS = 6
ORDER = 2 * COLUMNS

ROUND_OFF_OF_TABLE = 10.0
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
        size_k = scale[k] + ROUND_OFF_OF_TABLE * abs(table[COLUMNS - 1, k])
        difference = abs(table[COLUMNS - 1, k] - last[k]) / size_k
        if not difference <= error:  # a number that is none counts as an error
            error = difference
    return y + table[COLUMNS - 1], error


# ---- where to look for an ending
#
# What may end a piece within a step and no longer does at its end is looked for where the cubic
# leads that has the states and rates of both ends of the step: it is off by h^4 / 384 of the
# fourth derivative at most, enough to tell where to look closer.

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
        before, here, after = values[middle - 1], values[middle], values[middle + 1]
        bend, slope = before - 2.0 * here + after, 0.5 * (after - before)
        if not bend < 0.0:
            continue
        # beside its own half of the neighbours, the outermost parabolas tell up to the ends
        low = -1.0 if middle == 1 else -0.5
        high = 1.0 if middle == PLACES - 1 else 0.5
        if low < -slope / bend < high and here - 0.5 * slope * slope / bend > -band:
            return float(middle - slope / bend)
    return 0.0


Ending = tuple[int, int]
"""Contact and column of what ends a piece."""

# ---- when a step first ends a piece, by taking the same step shorter

ROUND_OFF_OF_EVENT = 1e-10
"""[size of an ending in a step] up to which it is not positive between the ends of the step."""

AT_LIMIT = 1e-14
"""[spring of a slider that sticks] at which it stands at Coulomb's limit: it begins to stick there,
give or take the round-off of a difference, and in a short step leaves it by less than that."""


def first_ending(
    states: tuple[Floats, Floats], h: float, system: System, modes: Integers, least: float
) -> tuple[float, Ending] | None:
    """Return when a step of ``h`` first ends a piece, and what ends it; None for a whole step.

    ``states`` are those at both ends of the step; times are in s, located to ``least``. Also an
    ending that is positive only between both ends is found.
    """
    start, end = states
    states_at = {0.0: start, h: end}

    @cache
    def after(part: float) -> Floats:
        return endings(taken(part), system, modes)

    def taken(part: float) -> Floats:
        if part in states_at:
            return states_at[part]
        return step(start, part, np.ones_like(start), system, modes)[0]

    def of(where: Ending) -> Callable[[float], float]:
        return lambda part: float(after(part)[where])

    def zero(where: Ending) -> float:
        return AT_LIMIT * _held(start, where, system, modes)

    def located(where: Ending, h: float) -> tuple[float, Ending]:
        return _located(of(where), h, least, zero(where)), where

    last, near = look(start, end, h, system, modes)
    endings_in_step = [located(where, h) for where in _positive(last)]
    if endings_in_step:
        h = min(endings_in_step)[0]
        _, near = look(start, taken(h), h, system, modes)
    for where in _positive(near):
        highest = _highest(of(where), h, float(near[where]), zero(where))
        if highest > 0.0:
            endings_in_step.append(located(where, highest))
    return min(endings_in_step, default=None)


def _positive(values: Floats) -> list[Ending]:
    return [(int(c), int(kind)) for c, kind in np.argwhere(values > 0.0)]


def _held(y: Floats, where: Ending, system: System, modes: Integers) -> float:
    """Return the spring [N] of a slider that sticks and may end so; 0 for what else may end."""
    c, column = where
    if not SLIDERS <= column < SLIDERS + 3 or modes[c, column] != STICK:
        return 0.0
    return float(length(slider_spring(y, system, modes, c, column - SLIDERS)))


def _highest(ending: Callable[[float], float], h: float, near: float, zero: float) -> float:
    """Return when an ending is highest about a time in a step, 0 if not above ``zero`` there."""
    minimum = minimize_scalar(
        lambda part: -ending(part),
        bounds=(max(0.0, near - h / PLACES), min(h, near + h / PLACES)),
        options={"xatol": 1e-5 * h},
    )
    least = max(zero, ROUND_OFF_OF_EVENT * max(abs(ending(0.0)), abs(ending(h))))
    return float(minimum.x) if -minimum.fun > least else 0.0


def _located(ending: Callable[[float], float], h: float, least: float, zero: float) -> float:
    """Return the time until an ending turns positive, at most h; up to ``-zero`` it stands at 0."""
    # an ending that has just been passed stands at 0, give or take round-off
    for early in (0.0, 1e-6 * h, 1e-3 * h, 0.1 * h):
        if ending(early) < -zero:
            return float(brentq(ending, early, h, xtol=least, rtol=1e-15))
    return 0.0


# ---- steps with error control, up to one in which a piece may end

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
