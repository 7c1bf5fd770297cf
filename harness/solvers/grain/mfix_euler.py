"""MFiX-DEM's default, ``EULER``: semi-implicit, the velocity first.

    v+ = v + h a(x, v)        x+ = x + h v+

(MFiX 21.3.2, ``model/des/cfnewvalues.f``.) First order.
"""

from __future__ import annotations

import numpy as np

from harness.compiled import compiled
from harness.solvers.grain.row import Grain, Row, acceleration

ORDER = 1


@compiled
def advance(grain: Grain, row: Row, step: float) -> Grain:
    """Return the grain one step [s] later."""
    ax, ay = acceleration(grain.x, grain.y, grain.vx, grain.vy, row)
    vx, vy = grain.vx + step * ax, grain.vy + step * ay
    return Grain(grain.x + step * vx, grain.y + step * vy, vx, vy, ax, ay)


def growth(step: float, zeta: float) -> float:
    """Return the growth per step in the well (:mod:`.stability`), step in 1/omega.

    With p = 3 zeta h and q = 3/2 h^2: z^2 - (2 - p - q) z + (1 - p) = 0.
    """
    p, q = 3.0 * zeta * step, 1.5 * step * step
    return float(np.abs(np.roots([1.0, p + q - 2.0, 1.0 - p])).max())
