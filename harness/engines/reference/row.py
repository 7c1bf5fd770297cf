"""One grain on an endless row of fixed spheres, tilted: state, system, acceleration.

Two spheres are enough: a grain between the centres of two neighbours is a
diameter or more away from every other, along the row alone.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.cases.incline.springs import SpringLaw
from harness.engines.reference.compiled import compiled
from harness.engines.reference.contact import damping, hertz_force, normal_force
from harness.parameters.hertz import Hertz, hertz_of_drop, hertz_of_incline

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
    """The system in SI units: spheres, contact, and the two components of gravity [m/s2].

    ``stiffness`` and ``damping`` are k [N/m] and eta [N s/m] of the linear spring; with
    ``hertz`` they are K [N/m^(3/2)] and K A. ``contact_time`` [s] is pi sqrt(m/k).
    """

    diameter: float
    mass: float
    stiffness: float
    damping: float
    clipped: bool
    along: float
    normal: float
    hertz: bool
    contact_time: float


def row_of(case: Incline, law: SpringLaw = "linear") -> Row:
    """Return the row of a case."""
    tilt = math.radians(case.angle)
    along, normal = case.gravity * math.sin(tilt), -case.gravity * math.cos(tilt)
    return _row(
        case,
        along,
        normal,
        hertz(case.contact, case.stiffness, case.mass, case.hertz_speed)
        if law == "Hertz"
        else None,
    )


def row_below(case: Drop, law: SpringLaw = "linear") -> Row:
    """Return the row, level, under a grain that drops on its first sphere."""
    return _row(
        case,
        0.0,
        -case.gravity,
        hertz(case.contact, case.stiffness, case.mass, case.hertz_speed)
        if law == "Hertz"
        else None,
    )


def _row(case: Incline | Drop, along: float, normal: float, hertz: Hertz | None) -> Row:
    dashpot = damping(case.contact, case.stiffness, case.mass)
    return Row(
        diameter=case.diameter,
        mass=case.mass,
        stiffness=hertz.coefficient if hertz else case.stiffness,
        damping=hertz.coefficient * hertz.relaxation if hertz else dashpot,
        clipped=case.contact.tail == "clipped",
        along=along,
        normal=normal,
        hertz=hertz is not None,
        contact_time=math.pi * math.sqrt(case.mass / case.stiffness),
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
    force = contact_force(row.diameter - distance, vx * nx + vy * ny, row, row.clipped)
    return force * nx, force * ny


@compiled
def contact_force(overlap: float, separation_speed: float, row: Row, clipped: bool) -> float:
    """Return the force [N] of a contact, by the row's law."""
    if row.hertz:
        return hertz_force(overlap, separation_speed, row.stiffness, row.damping, clipped)
    return normal_force(overlap, separation_speed, row.stiffness, row.damping, clipped)
