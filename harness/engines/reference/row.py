"""One grain on an endless row of fixed spheres, tilted: state, system, acceleration.

Two spheres are enough: a grain between the centres of two neighbours is a
diameter or more away from every other, along the row alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from harness.engines.reference.compiled import compiled
from harness.engines.reference.contact import damping, normal_force
from harness.parameters.drop import Drop
from harness.parameters.incline import Incline

ROUNDING = 1e-15
"""Overlaps [d] up to this are no contact, as in MFiX: a start that just touches shall not be
held back by an attractive tail because of its last digit."""


class Grain(NamedTuple):
    """Position [m] and velocity [m/s], and an acceleration [m/s2] that some methods remember.

    x runs along the row from the centre of a fixed sphere, y normal to it from
    the line of centres.
    """

    x: float
    y: float
    vx: float
    vy: float
    ax: float = 0.0
    ay: float = 0.0


class Row(NamedTuple):
    """The system in SI units: spheres, contact, and the two components of gravity [m/s2]."""

    diameter: float
    mass: float
    stiffness: float
    damping: float
    clipped: bool
    along: float
    normal: float


def row_of(case: Incline) -> Row:
    """Return the row of a case."""
    tilt = math.radians(case.angle)
    return Row(
        diameter=case.diameter,
        mass=case.mass,
        stiffness=case.stiffness,
        damping=damping(case.contact, case.stiffness, case.mass),
        clipped=case.contact.tail == "clipped",
        along=case.gravity * math.sin(tilt),
        normal=-case.gravity * math.cos(tilt),
    )


def row_below(case: Drop) -> Row:
    """Return the row, level, under a grain that drops on its first sphere."""
    return Row(
        diameter=case.diameter,
        mass=case.mass,
        stiffness=case.stiffness,
        damping=damping(case.contact, case.stiffness, case.mass),
        clipped=case.contact.tail == "clipped",
        along=0.0,
        normal=-case.gravity,
    )


@compiled
def acceleration(x: float, y: float, vx: float, vy: float, row: Row) -> tuple[float, float]:
    """Return the acceleration [m/s2] of a grain at (x, y) that moves with (vx, vy)."""
    behind = row.diameter * math.floor(x / row.diameter)
    fx, fy = _push(x - behind, y, vx, vy, row)
    gx, gy = _push(x - behind - row.diameter, y, vx, vy, row)
    return (fx + gx) / row.mass + row.along, (fy + gy) / row.mass + row.normal


@compiled
def _push(dx: float, dy: float, vx: float, vy: float, row: Row) -> tuple[float, float]:
    """Return the force [N] of a fixed sphere on the grain that stands (dx, dy) from it."""
    square = dx * dx + dy * dy
    reach = row.diameter * (1.0 - ROUNDING)
    if square >= reach * reach:
        return 0.0, 0.0
    distance = math.sqrt(square)
    nx, ny = dx / distance, dy / distance
    force = normal_force(
        row.diameter - distance, vx * nx + vy * ny, row.stiffness, row.damping, row.clipped
    )
    return force * nx, force * ny
