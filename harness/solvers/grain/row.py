"""One grain on fixed spheres: its state, the system, and the force of a contact.

The spheres are an endless row, or one alone. On a row two are enough: a grain between the centres
of two neighbours is a diameter or more away from every other, along the row alone. The normal
contact has a linear or Hertz's spring with its dashpot; its attractive tail is kept or clipped.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.compiled import compiled
from harness.parameters.law import hertz
from harness.parameters.scene import ContactScene


@compiled
def normal_force(
    overlap: float, separation_speed: float, stiffness: float, damping: float, clipped: bool
) -> float:
    """Return k delta - eta * separation speed [N] of two spheres that touch; clipped: never < 0."""
    force = stiffness * overlap - damping * separation_speed
    if clipped and force < 0.0:
        return 0.0
    return force


@compiled
def hertz_force(
    overlap: float, separation_speed: float, coefficient: float, damping: float, clipped: bool
) -> float:
    """Return K delta^(3/2) - K A sqrt(delta) separation speed [N]; ``damping`` is K A.

    Nothing where there is no overlap.
    """
    root = math.sqrt(max(overlap, 0.0))
    force = root * (coefficient * overlap - damping * separation_speed)
    if clipped and force < 0.0:
        return 0.0
    return force


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
    ``hertz`` they are K [N/m^(3/2)] and K A. ``contact_time`` [s] is pi sqrt(m/k). ``single``
    says that there is one fixed sphere, at the origin, and no row.
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
    single: bool = False


def row_of(scene: ContactScene) -> Row:
    """Return the system of a scene that :func:`.statement.unstated` accepts.

    Raise RequestError for a Hertz spring without a speed that sets its scale.
    """
    mass, stiffness = scene.bodies[0].mass, scene.stiffness
    spring, dashpot = stiffness, scene.law.damping_coefficient or 0.0
    if scene.spring == "Hertz":
        law = hertz(scene.contact, stiffness, mass, scene.hertz_speed)
        spring, dashpot = law.coefficient, law.coefficient * law.relaxation
    return Row(
        diameter=float(scene.diameter[0]),
        mass=mass,
        stiffness=spring,
        damping=dashpot,
        clipped=scene.law.clipped,
        along=scene.gravity[0],
        normal=scene.gravity[1],
        hertz=scene.spring == "Hertz",
        contact_time=math.pi * math.sqrt(mass / stiffness),
        single=scene.period is None,
    )


@compiled
def acceleration(x: float, y: float, vx: float, vy: float, row: Row) -> tuple[float, float]:
    """Return the acceleration [m/s2] of a grain at (x, y) that moves with (vx, vy)."""
    if row.single:
        fx, fy = _push(x, y, vx, vy, row)
        return fx / row.mass + row.along, fy / row.mass + row.normal
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


# ---- the motion between two changes of contact: which spheres push is given, not looked up

State = NDArray[np.float64]
"""x from the sphere behind [m], y [m], vx, vy [m/s]."""


@compiled
def overlap(state: State, row: Row, sphere: int) -> float:
    """Return the overlap [m] with a sphere (0 behind, 1 ahead); negative is a gap."""
    return row.diameter - math.hypot(state[0] - sphere * row.diameter, state[1])


@compiled
def unclipped_force(state: State, row: Row, sphere: int) -> float:
    """Return the force [N] that a sphere would exert, not clipped."""
    dx, dy = state[0] - sphere * row.diameter, state[1]
    distance = math.hypot(dx, dy)
    speed = (state[2] * dx + state[3] * dy) / distance
    return contact_force(row.diameter - distance, speed, row, False)


@compiled
def rate_of_change(state: State, row: Row, behind: bool, ahead: bool) -> State:
    """Return the state's rate of change while the same spheres push."""
    rate = np.array([state[2], state[3], row.along, row.normal])
    for sphere in range(2):
        if (sphere == 0 and behind) or (sphere == 1 and ahead):
            dx, dy = state[0] - sphere * row.diameter, state[1]
            push = unclipped_force(state, row, sphere) / (row.mass * math.hypot(dx, dy))
            rate[2] += push * dx
            rate[3] += push * dy
    return rate


def energy(state: State, behind: int, row: Row) -> float:
    """Return the mechanical energy [J], zero at the centre of the first fixed sphere.

    The state's x counts from sphere ``behind`` of the row.
    """
    x = state[0] + behind * row.diameter
    power, share = (2.5, 0.4) if row.hertz else (2.0, 0.5)
    spheres = (0,) if row.single else (0, 1)
    springs = sum(max(overlap(state, row, sphere), 0.0) ** power for sphere in spheres)
    motion = 0.5 * row.mass * (state[2] * state[2] + state[3] * state[3])
    weight = row.mass * (row.along * x + row.normal * state[1])
    return float(motion - weight + share * row.stiffness * springs)
