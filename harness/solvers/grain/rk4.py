"""The classic Runge-Kutta method of fourth order (Kutta 1901), with a fixed step."""

from __future__ import annotations

import numpy as np

from harness.compiled import compiled
from harness.solvers.grain.row import Grain, Row, acceleration

ORDER = 4


@compiled
def advance(grain: Grain, row: Row, step: float) -> Grain:
    """Return the grain one step [s] later."""
    x, y, ux, uy = grain.x, grain.y, grain.vx, grain.vy
    half = 0.5 * step
    ax, ay = acceleration(x, y, ux, uy, row)
    vx, vy = ux + half * ax, uy + half * ay
    bx, by = acceleration(x + half * ux, y + half * uy, vx, vy, row)
    wx, wy = ux + half * bx, uy + half * by
    cx, cy = acceleration(x + half * vx, y + half * vy, wx, wy, row)
    zx, zy = ux + step * cx, uy + step * cy
    dx, dy = acceleration(x + step * wx, y + step * wy, zx, zy, row)
    sixth = step / 6.0
    return Grain(
        x + sixth * (ux + 2.0 * (vx + wx) + zx),
        y + sixth * (uy + 2.0 * (vy + wy) + zy),
        ux + sixth * (ax + 2.0 * (bx + cx) + dx),
        uy + sixth * (ay + 2.0 * (by + cy) + dy),
        ax,
        ay,
    )


def growth(step: float, zeta: float) -> float:
    """Return the growth per step in the well (:mod:`.stability`), step in 1/omega.

    1 + z + z^2/2 + z^3/6 + z^4/24 at both z of z^2 + 3 zeta h z + 3/2 h^2 = 0.
    """
    rates = np.roots([1.0, 3.0 * zeta * step, 1.5 * step * step])
    return float(np.abs(np.polyval([1 / 24, 1 / 6, 1 / 2, 1.0, 1.0], rates)).max())
