"""MFiX-DEM's ``ADAMS_BASHFORTH``: Adams-Bashforth for the velocity, trapezoid for the position.

    v+ = v + h/2 (3 a - a_before)        x+ = x + h/2 (v + v+)

(MFiX 21.3.2, ``model/des/cfnewvalues.f``.) In the first step a_before = a. Second order.
"""

from __future__ import annotations

import numpy as np

from harness.compiled import compiled
from harness.solvers.grain.row import Grain, Row, acceleration

ORDER = 2


@compiled
def advance(grain: Grain, row: Row, step: float) -> Grain:
    """Return the grain one step [s] later."""
    half = 0.5 * step
    ax, ay = acceleration(grain.x, grain.y, grain.vx, grain.vy, row)
    vx = grain.vx + half * (3.0 * ax - grain.ax)
    vy = grain.vy + half * (3.0 * ay - grain.ay)
    x, y = grain.x + half * (grain.vx + vx), grain.y + half * (grain.vy + vy)
    return Grain(x, y, vx, vy, ax, ay)


def growth(step: float, zeta: float) -> float:
    """Return the growth per step in the well (:mod:`.stability`), step in 1/omega.

    With b = 3/8 h^2 and c = 3/2 zeta h:
    z (z - 1)^2 + (3 z - 1) (b (z + 1) + c (z - 1)) = 0. Without damping some
    root lies outside the unit circle at every step.
    """
    b, c = 0.375 * step * step, 1.5 * zeta * step
    roots = np.roots([1.0, 3.0 * (b + c) - 2.0, 1.0 + 2.0 * b - 4.0 * c, c - b])
    return float(np.abs(roots).max())
