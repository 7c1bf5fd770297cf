"""Velocity Verlet in LAMMPS's order: the dashpot sees the velocity of the half step.

    v' = v + h/2 a        x+ = x + h v'        a+ = a(x+, v')        v+ = v' + h/2 a+

(``fix nve/sphere``.) Where LAMMPS begins a ``run`` it takes the forces anew, with the
whole step's velocity.
"""

from __future__ import annotations

from harness.compiled import compiled
from harness.solvers.grain import mfix_euler
from harness.solvers.grain.row import Grain, Row, acceleration

ORDER = 2


@compiled
def advance(grain: Grain, row: Row, step: float) -> Grain:
    """Return the grain one step [s] later."""
    half = 0.5 * step
    vx, vy = grain.vx + half * grain.ax, grain.vy + half * grain.ay
    x, y = grain.x + step * vx, grain.y + step * vy
    ax, ay = acceleration(x, y, vx, vy, row)
    return Grain(x, y, vx + half * ax, vy + half * ay, ax, ay)


def growth(step: float, zeta: float) -> float:
    """Return the growth per step in the well (:mod:`.stability`), step in 1/omega.

    In the velocities of the half steps, v+ = v + h a(x, v) and x+ = x + h v+:
    the recurrence is that of MFiX's Euler.
    """
    return mfix_euler.growth(step, zeta)
