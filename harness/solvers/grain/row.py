"""One grain on fixed spheres: its state, the system, the force of a contact, and fixed steps.

The spheres are an endless row, or one alone. On a row two are enough: a grain between the centres
of two neighbours is a diameter or more away from every other, along the row alone. The normal
contact is a linear spring with a dashpot; its attractive tail is kept or clipped.

``FIXED_STEP`` names the schemes. A scheme is a kernel for one step, and its *growth*, the largest
factor by which motion in a well of the row grows in one step; it is stable until that exceeds 1. In
the well the two contacts stand 60 deg apart. Motion normal to the row feels 3/2 of one contact's
spring and dashpot, x'' + 3 zeta omega x' + 3/2 omega^2 x = 0, with omega = sqrt(k/m) and
zeta = eta / (2 sqrt(k m)); along the row it feels 1/2, and on one sphere it feels 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from harness.compiled import compiled
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

    ``stiffness`` and ``damping`` are k [N/m] and eta [N s/m]. ``contact_time`` [s] is
    pi sqrt(m/k). ``single``: there is one fixed sphere, at the origin, and no row.
    """

    diameter: float
    mass: float
    stiffness: float
    damping: float
    clipped: bool
    along: float
    normal: float
    contact_time: float
    single: bool = False


def row_of(scene: ContactScene) -> Row:
    """Return the system of a scene that :func:`harness.engines.reference.unstated` accepts."""
    mass = scene.bodies[0].mass
    return Row(
        diameter=float(scene.diameter[0]),
        mass=mass,
        stiffness=scene.stiffness,
        damping=scene.law.damping_coefficient or 0.0,
        clipped=scene.law.clipped,
        along=scene.gravity[0],
        normal=scene.gravity[1],
        contact_time=math.pi * math.sqrt(mass / scene.stiffness),
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
    speed = vx * nx + vy * ny
    force = normal_force(row.diameter - distance, speed, row.stiffness, row.damping, row.clipped)
    return force * nx, force * ny


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
    return normal_force(row.diameter - distance, speed, row.stiffness, row.damping, False)


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
    spheres = (0,) if row.single else (0, 1)
    springs = sum(max(overlap(state, row, sphere), 0.0) ** 2.0 for sphere in spheres)
    motion = 0.5 * row.mass * (state[2] * state[2] + state[3] * state[3])
    weight = row.mass * (row.along * x + row.normal * state[1])
    return float(motion - weight + 0.5 * row.stiffness * springs)


Growth = Callable[[float, float], float]
"""Of a step [1/omega] and a damping ratio zeta (with the grain's whole mass)."""

ROUNDING_OF_ROOTS = 1e-12
"""A growth this far above 1 is rounding of the roots: that of an undamped oscillator is 1."""

SMALLEST, FINENESS = 0.01, 1.02
"""The first step tried, over 1 + 3 zeta, and the factor from one to the next."""


def fewest_steps_per_contact(growth: Growth, zeta: float) -> float:
    """Return the steps per contact time pi sqrt(m/k) below which an integrator is unstable.

    Infinite when it is unstable at every step. The step is widened by 2 % until the growth
    passes 1, and the crossing located.
    """

    def excess(step: float) -> float:
        return growth(step, zeta) - 1.0 - ROUNDING_OF_ROOTS

    step = SMALLEST / (1.0 + 3.0 * zeta)
    if excess(step) > 0.0:
        return math.inf
    while excess(step) <= 0.0:
        step *= FINENESS
    largest: float = brentq(excess, step / FINENESS, step, xtol=1e-12)
    return math.pi / largest


VELOCITY_VERLET, MFIX_EULER, MFIX_ADAMS_BASHFORTH, RK4 = range(4)

WATCH = 50
"""Steps between two looks, counted from the start of the motion."""


class End(IntEnum):
    """Why a stretch ended."""

    LAST_STEP = 0
    DECISION = 1
    FULL = 2
    NOT_A_NUMBER = 3


_LAST_STEP, _DECISION, _FULL, _NOT_A_NUMBER = (int(end) for end in End)


@compiled
def begin(method: int, grain: Grain, row: Row) -> Grain:
    """Return the grain with what the method has to remember: the acceleration of its start."""
    if method in (VELOCITY_VERLET, MFIX_ADAMS_BASHFORTH):
        ax, ay = acceleration(grain.x, grain.y, grain.vx, grain.vy, row)
        return Grain(grain.x, grain.y, grain.vx, grain.vy, ax, ay)
    return grain


@compiled
def advance(method: int, grain: Grain, row: Row, step: float, steps: int) -> Grain:
    """Return the grain after so many steps of ``step`` [s]."""
    if method == VELOCITY_VERLET:
        for _ in range(steps):
            grain = _velocity_verlet(grain, row, step)
    elif method == MFIX_EULER:
        for _ in range(steps):
            grain = _mfix_euler(grain, row, step)
    elif method == MFIX_ADAMS_BASHFORTH:
        for _ in range(steps):
            grain = _mfix_adams_bashforth(grain, row, step)
    else:
        for _ in range(steps):
            grain = _rk4(grain, row, step)
    return grain


class Scheme(NamedTuple):
    """A method, the row that it moves a grain over, and its step [s]."""

    method: int
    row: Row
    step: float


@compiled
def stretch(
    scheme: Scheme, grain: Grain, count: int, last: int, watched: bool,
    place: float, every: int, samples: NDArray[np.float64],
) -> tuple[Grain, int, int, int]:  # fmt: skip
    """Advance from step ``count`` to ``last`` at most; return grain, count, End and samples taken.

    ``watched``: stop at a look when x > ``place`` [m] or vx < 0. Every so many
    steps (0: never) time, position and velocity go to a row of ``samples``,
    shape (rows, 5); it stops when they are full.
    """
    taken = 0
    while count < last:
        steps = min(WATCH - count % WATCH, last - count)
        if every > 0:
            steps = min(steps, every - count % every)
        grain = advance(scheme.method, grain, scheme.row, scheme.step, steps)
        count += steps
        if every > 0 and count % every == 0:
            samples[taken, 0] = count * scheme.step
            samples[taken, 1], samples[taken, 2] = grain.x, grain.y
            samples[taken, 3], samples[taken, 4] = grain.vx, grain.vy
            taken += 1
        if count % WATCH == 0 or count == last:
            if not math.isfinite(grain.x + grain.y + grain.vx + grain.vy):
                return grain, count, taken, _NOT_A_NUMBER
            if watched and (grain.x > place or grain.vx < 0.0):
                return grain, count, taken, _DECISION
        if taken == len(samples) and every > 0:
            return grain, count, taken, _FULL
    return grain, count, taken, _LAST_STEP


# ---- one step of each scheme, and its growth per step in the well; step in 1/omega


@compiled
def _velocity_verlet(grain: Grain, row: Row, step: float) -> Grain:
    """Return the grain one step [s] later, in LAMMPS's order. Second order.

    The dashpot sees the velocity of the half step:

        v' = v + h/2 a        x+ = x + h v'        a+ = a(x+, v')        v+ = v' + h/2 a+

    (``fix nve/sphere``.) Where LAMMPS begins a ``run`` it takes the forces anew, with the
    whole step's velocity.
    """
    half = 0.5 * step
    vx, vy = grain.vx + half * grain.ax, grain.vy + half * grain.ay
    x, y = grain.x + step * vx, grain.y + step * vy
    ax, ay = acceleration(x, y, vx, vy, row)
    return Grain(x, y, vx + half * ax, vy + half * ay, ax, ay)


@compiled
def _mfix_euler(grain: Grain, row: Row, step: float) -> Grain:
    """Return the grain one step [s] later by MFiX-DEM's default, ``EULER``. First order.

    Semi-implicit, the velocity first: v+ = v + h a(x, v), x+ = x + h v+ (MFiX 21.3.2,
    ``model/des/cfnewvalues.f``).
    """
    ax, ay = acceleration(grain.x, grain.y, grain.vx, grain.vy, row)
    vx, vy = grain.vx + step * ax, grain.vy + step * ay
    return Grain(grain.x + step * vx, grain.y + step * vy, vx, vy, ax, ay)


def _mfix_euler_growth(step: float, zeta: float) -> float:
    """Return the growth: with p = 3 zeta h, q = 3/2 h^2, z^2 - (2 - p - q) z + (1 - p) = 0."""
    p, q = 3.0 * zeta * step, 1.5 * step * step
    return float(np.abs(np.roots([1.0, p + q - 2.0, 1.0 - p])).max())


@compiled
def _mfix_adams_bashforth(grain: Grain, row: Row, step: float) -> Grain:
    """Return the grain one step [s] later by MFiX-DEM's ``ADAMS_BASHFORTH``. Second order.

    Adams-Bashforth for the velocity, trapezoid for the position: v+ = v + h/2 (3 a - a_before),
    x+ = x + h/2 (v + v+) (MFiX 21.3.2, ``model/des/cfnewvalues.f``). In the first step a_before
    is a.
    """
    half = 0.5 * step
    ax, ay = acceleration(grain.x, grain.y, grain.vx, grain.vy, row)
    vx = grain.vx + half * (3.0 * ax - grain.ax)
    vy = grain.vy + half * (3.0 * ay - grain.ay)
    x, y = grain.x + half * (grain.vx + vx), grain.y + half * (grain.vy + vy)
    return Grain(x, y, vx, vy, ax, ay)


def _mfix_adams_bashforth_growth(step: float, zeta: float) -> float:
    """Return the growth: that of z (z - 1)^2 + (3 z - 1) (b (z + 1) + c (z - 1)) = 0.

    b = 3/8 h^2 and c = 3/2 zeta h. Without damping some root lies outside the unit circle at
    every step.
    """
    b, c = 0.375 * step * step, 1.5 * zeta * step
    roots = np.roots([1.0, 3.0 * (b + c) - 2.0, 1.0 + 2.0 * b - 4.0 * c, c - b])
    return float(np.abs(roots).max())


@compiled
def _rk4(grain: Grain, row: Row, step: float) -> Grain:
    """Return the grain one step [s] later by the classic Runge-Kutta method (Kutta 1901)."""
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


def _rk4_growth(step: float, zeta: float) -> float:
    """Return the growth, the larger of two amplifications.

    1 + z + z^2/2 + z^3/6 + z^4/24 at both z of z^2 + 3 zeta h z + 3/2 h^2 = 0.
    """
    rates = np.roots([1.0, 3.0 * zeta * step, 1.5 * step * step])
    return float(np.abs(np.polyval([1 / 24, 1 / 6, 1 / 2, 1.0, 1.0], rates)).max())


class Method(NamedTuple):
    """An integrator in fixed steps: its number in the kernels, and its growth in the well."""

    number: int
    growth: Growth


FIXED_STEP = {
    # in the velocities of the half steps, v+ = v + h a(x, v) and x+ = x + h v+: as MFiX's Euler
    "velocity-verlet": Method(VELOCITY_VERLET, _mfix_euler_growth),
    "mfix-euler": Method(MFIX_EULER, _mfix_euler_growth),
    "mfix-adams-bashforth": Method(MFIX_ADAMS_BASHFORTH, _mfix_adams_bashforth_growth),
    "rk4": Method(RK4, _rk4_growth),
}
"""By the names that users choose them by."""
