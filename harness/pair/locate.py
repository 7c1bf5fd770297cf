"""When a step first ends a smooth piece of the motion, by taking the same step shorter."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from harness.pair.between import PLACES, look
from harness.pair.extrapolation import step
from harness.pair.rates import endings
from harness.pair.records import Floats, Integers, System

Ending = tuple[int, int]
"""Contact and column of what ends a piece."""

ROUND_OFF = 1e-10
"""[size of an ending in a step] up to which it is not positive between the ends of the step."""


def first_ending(
    states: tuple[Floats, Floats], h: float, system: System, modes: Integers, least: float
) -> tuple[float, Ending] | None:
    """Return when a step of ``h`` first ends a piece, and what ends it; None for a whole step.

    ``states`` are those at both ends of the step; times are in s, located to ``least``. Also an
    ending that is positive only between both ends is found.
    """
    start, end = states
    known = {0.0: start, h: end}

    @cache
    def after(part: float) -> Floats:
        return endings(taken(part), system, modes)

    def taken(part: float) -> Floats:
        if part in known:
            return known[part]
        return step(start, part, np.ones_like(start), system, modes)[0]

    def of(where: Ending) -> Callable[[float], float]:
        return lambda part: float(after(part)[where])

    last, near = look(start, end, h, system, modes)
    found = [(_located(of(where), h, least), where) for where in _positive(last)]
    if found:
        h = min(found)[0]
        _, near = look(start, taken(h), h, system, modes)
    for where in _positive(near):
        highest = _highest(of(where), h, float(near[where]))
        if highest > 0.0:
            found.append((_located(of(where), highest, least), where))
    return min(found, default=None)


def _positive(values: Floats) -> list[Ending]:
    return [(int(c), int(kind)) for c, kind in np.argwhere(values > 0.0)]


def _highest(ending: Callable[[float], float], h: float, near: float) -> float:
    """Return when an ending is highest about a time within a step, 0 if not positive there."""
    found = minimize_scalar(
        lambda part: -ending(part),
        bounds=(max(0.0, near - h / PLACES), min(h, near + h / PLACES)),
        options={"xatol": 1e-5 * h},
    )
    least = ROUND_OFF * max(abs(ending(0.0)), abs(ending(h)))
    return float(found.x) if -found.fun > least else 0.0


def _located(ending: Callable[[float], float], h: float, least: float) -> float:
    """Return the time until an ending turns positive, at most h."""
    # an ending that has just been passed stands at 0, give or take round-off
    for early in (0.0, 1e-6 * h, 1e-3 * h, 0.1 * h):
        if ending(early) < 0.0:
            return float(brentq(ending, early, h, xtol=least, rtol=1e-15))
    return 0.0
