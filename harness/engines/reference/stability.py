"""How large a step of each integrator may be: linear stability in the well.

In the well the two contacts stand 60 deg apart. Motion normal to the row feels
3/2 of one contact's spring and dashpot, x'' + 3 zeta omega x' + 3/2 omega^2 x = 0, with
omega = sqrt(k/m) and zeta = eta / (2 sqrt(k m)); along the row it feels 1/2, and on one
sphere it feels 1. Each integrator states its ``growth``, the largest factor by which this
motion grows in one step; it is stable until the growth exceeds 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from scipy.optimize import brentq

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
