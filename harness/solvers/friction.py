"""Tangential forces, rolling and twisting torques of contacts, compiled: sliders under a limit.

Springs follow Luding, Granular Matter 10, 235 (2008): one is turned into the plane of the contact,
grows by the slip of the step, and is cut back at Coulomb's limit to what the limit leaves (section
4.2). Other sources are with the laws in :mod:`harness.model.law`. The letters are those of the law:
n normal, a contact radius, q spring, u slip velocity, h step; h = 0 in the setup of a run.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from harness.model.base import ZERO, Vector
from harness.model.conventions import Rules
from harness.model.law import Law
from harness.solvers.kernels import (
    Records,
    add,
    cross,
    dot,
    kernel,
    minus,
    project,
    scale,
    size,
    store,
    vector,
    words,
)

MARSHALL, CONSTANT = words(Law, "twisting")["marshall"], words(Law, "rolling")["constant"]
ROLLING: Any = np.int64(1)  # springs of a contact, beside the tangential one
TWISTING: Any = np.int64(2)
STICKING_ONLY = words(Rules, "damping_in_cap")["sticking_only"]
RADIUS, HEIGHT = (words(Rules, "wall_lever")[w] for w in ("radius", "height"))
ACROSS, PROJECTED_AXIS = (words(Rules, "rolling_axis")[w] for w in ("across", "projected"))
ELASTIC = words(Rules, "rolling_load")["elastic"]
SHORTENED = words(Rules, "rolling_lever")["shortened"]
LEVERED = words(Rules, "wall_spin")["levered"]
TURNED, PROJECTED, ROTATED, FINITE_ROTATION = words(Rules, "spring_frame").values()
STAYS_TURNED, ROTATED_TORSION, _ = words(Rules, "torsion_frame").values()
TURNED_ARMS = words(Rules, "slip_step")["turned_arms"]
BY_DISPLACEMENT = words(Rules, "rescaled_from")["displacement"]
AT_LIMIT = 1.0 + 1e-15  # a spring that was cut back may be off its limit by rounding


class Touch(NamedTuple):
    """Where two bodies are: normal towards the first, overlap [m], radius of the second [m].

    The radius is 0 for a plane, negative for a hollow wall and twice its own for a cylinder, which
    has its mean curvature. ``drift`` [m/s] is the velocity of a wall's surface.
    """

    normal: Vector
    overlap: float
    other: float
    drift: Vector


class Press(NamedTuple):
    """The normal part of a contact: R* and a [m], dashpot [kg/s] and forces [N]."""

    radius: float
    a: float
    eta: float
    force: float
    elastic: float
    load: float  # of friction


class Slip(NamedTuple):
    """How a contact slips in a step."""

    velocity: Vector  # [m/s] along the surface
    moved: Vector  # [m] in the step
    along: float  # [m] along the normal in the step
    spin: Vector  # [rad/s] of the first body against the second
    both: Vector  # [rad/s] of both together
    arm: float  # [m] R* by the share of the first radius that its lever has


@kernel
def lever(kind: int, overlap: float, radius: float) -> float:
    """Return the lever [m] of a body of a radius [m], by a convention."""
    if kind == RADIUS:
        return radius
    return radius - (overlap if kind == HEIGHT else 0.5 * overlap)


@kernel
def find_slip(
    rules: Records, pair: bool, touch: Touch, press: Press, radius: float,
    motion: tuple[Vector, Vector, Vector], h: float,
) -> Slip:  # fmt: skip
    """Return how a contact slips, by relative velocity [m/s] and both angular velocities."""
    n, (relative, spin, other) = touch.normal, motion
    kind = rules.velocity_lever if pair else rules.wall_lever
    first = lever(kind, touch.overlap, radius)
    second = lever(kind, touch.overlap, touch.other) if pair else 0.0
    arms = add(scale(first, spin), scale(second, other))
    u = minus(project(relative, n), cross(arms, n))
    moved, along = scale(h, u), h * dot(relative, n)
    if rules.slip_step == TURNED_ARMS and h > 0.0:
        sign = 1.0 if pair else -1.0  # at a wall the arm turns back
        by_first = scale(sign, _turned(rules, scale(-first, n), scale(sign * h, spin)))
        by_second = _turned(rules, scale(second, n), scale(h, other))
        moved = minus(add(scale(h, relative), by_first), by_second)
        along = dot(moved, n)
        moved = project(moved, n)
    felt = minus(spin, other)
    if not pair and rules.wall_spin == LEVERED:
        felt = scale((radius - 0.5 * touch.overlap) / (radius - touch.overlap), felt)
    return Slip(u, moved, along, felt, add(spin, other), press.radius * first / radius)


@kernel
def _turned(rules: Records, arm: Vector, angle: Vector) -> Vector:
    """Return how far an arm [m] turned by an angle [rad] about itself moves (Rodrigues)."""
    t = 0.5 * size(angle)
    if rules.small_angle_quaternion and t > 0.0 and t**4 / 24.0 < 2.220446049250313e-16:
        angle = scale(math.atan2(t * (1.0 - t * t / 6.0), 1.0 + 0.5 * t * t) / t, angle)
    turn = size(angle)
    if turn == 0.0:
        return ZERO
    axis, versine = scale(1.0 / turn, angle), 2.0 * math.sin(0.5 * turn) ** 2
    across = minus(scale(dot(axis, arm), axis), arm)
    return add(scale(versine, across), scale(math.sin(turn), cross(axis, arm)))


@kernel
def tangential_force(
    contact: Records, law: Records, rules: Records, touch: Touch, press: Press, slip: Slip, h: float
) -> Vector:
    """Return the tangential force [N] on the first body, and bring its spring on."""
    if law.friction <= 0.0:
        return ZERO
    n, a = touch.normal, press.a
    k = law.shear * (a if law.shear_by_radius and not law.keeps_force else 1.0)
    q, last, before = vector(contact.springs[0]), _last_normal(contact, rules, n), contact.radius
    if law.rescaled and h > 0.0:
        if rules.rescaled_from == BY_DISPLACEMENT:
            before = math.sqrt(press.radius * max(touch.overlap + slip.along, 0.0))
        q = scale(a / before, q) if a < before else q
    frame = PROJECTED if law.projected else rules.spring_frame
    q = _carry(q, frame, n, last, 0.5 * h * dot(slip.both, last))
    if law.shear > 0.0:
        q = add(q, scale(a if law.keeps_force else 1.0, slip.moved))
    q = project(q, n) if frame == PROJECTED and h > 0.0 else q
    eta, cap = law.tangential_damping * press.eta, law.friction * press.load
    force, spring, slides = _limit(rules, q, slip.velocity, k, eta, cap)
    if slides and k > 0.0:
        spring = scale(a, spring) if law.cut_by_radius else spring
        if size(q) == 0.0 and not rules.slides_in_setup:
            force, spring = ZERO, q
    if h > 0.0 or not rules.forgets_setup:
        store(contact.springs[0], spring)
    return force


@kernel
def keep_spring(contact: Records, law: Records, rules: Records, elastic: float) -> None:
    """Keep the spring of two spheres that part; Kratos keeps the normal force [N] with it."""
    if rules.spring_frame == FINITE_ROTATION and law.shear > 0.0:
        normal = scale(elastic / law.shear, vector(contact.normal))
        store(contact.springs[0], minus(vector(contact.springs[0]), normal))


@kernel
def rolling_torque(
    contact: Records, law: Records, rules: Records, n: Vector, press: Press, slip: Slip, h: float
) -> Vector:
    """Return the torque of rolling resistance [N m] on the first body, and bring its spring on."""
    if law.rolling_friction <= 0.0:
        return ZERO
    if law.rolling == CONSTANT:
        return _constant_torque(law, rules, n, press, slip)
    turned, r = rules.torsion_frame == STAYS_TURNED, press.radius
    u = scale(r, cross(slip.spin, n) if turned else project(slip.spin, n))
    slider = law.rolling_stiffness, law.rolling_damping, law.rolling_friction * press.load
    force = _torsion(contact, rules, n, slip, h, ROLLING, u, slider)
    return scale(r, cross(n, force) if turned else force)


@kernel
def _constant_torque(law: Records, rules: Records, n: Vector, press: Press, slip: Slip) -> Vector:
    """Return the torque [N m] on the first body: -mu_r R* |F_n| w / |w| of the rolling spin w.

    Model A of Ai and others (2011). A body at rest turns back and forth by the spin of a step.
    """
    across = project(slip.spin, n)
    axis = across if rules.rolling_axis in (ACROSS, PROJECTED_AXIS) else slip.spin
    rate = size(across if rules.rolling_axis == ACROSS else slip.spin)
    if rate == 0.0:
        return ZERO
    force = abs(press.elastic) if rules.rolling_load == ELASTIC else press.load
    arm = slip.arm if rules.rolling_lever == SHORTENED else press.radius
    torque = law.rolling_friction * arm * force
    return scale(-torque / (1.0 if rules.rolling_by_rate else rate), axis)


@kernel
def twisting_torque(
    contact: Records, law: Records, rules: Records, n: Vector, press: Press, slip: Slip, h: float
) -> Vector:
    """Return the torque of twisting [N m] on the first body, and bring its spring on."""
    a, k, eta, mu = press.a, law.twisting_stiffness, law.twisting_damping, law.twisting_friction
    if law.twisting == MARSHALL:
        k = 0.5 * law.shear * (a if law.marshall_by_radius else 1.0) * a * a
        eta, mu = 0.5 * law.tangential_damping * press.eta * a * a, 2.0 / 3.0 * a * law.friction
    if mu <= 0.0:
        return ZERO
    u = scale(dot(slip.spin, n), n)
    return _torsion(contact, rules, n, slip, h, TWISTING, u, (k, eta, mu * press.load))


# ---- springs and dashpots under a limit


@kernel
def _torsion(
    contact: Records, rules: Records, n: Vector, slip: Slip, h: float, kind: int, u: Vector,
    slider: tuple[float, float, float],
) -> Vector:  # fmt: skip
    """Return the force of a slider of a kind, by its stiffness, dashpot and limit."""
    (k, eta, cap), frame = slider, rules.torsion_frame
    q, last = vector(contact.springs[kind]), _last_normal(contact, rules, n)
    if frame == STAYS_TURNED and kind == TWISTING:
        q = scale(math.copysign(size(q), dot(q, n)), n)
    elif frame == STAYS_TURNED:
        q = _carry(q, TURNED, n, last, 0.0)
    elif frame == ROTATED_TORSION:
        q = _carry(q, ROTATED, n, last, 0.5 * h * dot(slip.both, last))
    forgets = rules.forgets_setup and h == 0.0
    q = add(q, scale(rules.step if forgets else h, u))
    force, spring, slides = _limit(rules, q, u, k, eta, cap)
    if slides and kind == ROLLING and k > 0.0 and size(q) == 0.0 and not rules.slides_in_setup:
        force, spring = ZERO, q
    if slides and kind == TWISTING and rules.twisting_limit_by_rate:
        turning = dot(u, n)
        force = scale(-cap * ((turning > 0.0) - (turning < 0.0)), n)
        spring = scale(-1.0 / k, add(force, scale(eta, u)))
    if not forgets:
        store(contact.springs[kind], spring)
    return force


@kernel
def _limit(
    rules: Records, q: Vector, u: Vector, k: float, eta: float, cap: float
) -> tuple[Vector, Vector, bool]:
    """Return force and spring of a slider with velocity u, at most ``cap``; whether it slides."""
    spring, drag = scale(-k, q), scale(-eta, u)
    total = add(spring, drag)
    sticking_only = rules.damping_in_cap == STICKING_ONLY and k > 0.0
    limited = spring if sticking_only else total
    length = size(limited)
    if length <= cap * AT_LIMIT:
        return total, q, False
    force = scale(cap / length, limited)
    if k > 0.0:
        remaining = scale(-1.0, force) if sticking_only else minus(drag, force)
        q = scale(1.0 / k, remaining)
    return force, q, True


@kernel
def _carry(q: Vector, frame: int, n: Vector, last: Vector, twist: float) -> Vector:
    """Return a spring of the step before, with the normal ``last``, in the contact now."""
    if frame == TURNED:
        across = project(q, n)
        length = size(across)
        return scale(size(q) / length, across) if length > 0.0 else across
    if frame == ROTATED:  # by small angles one after the other
        q = minus(q, cross(q, cross(last, n)))
        return add(q, scale(twist, cross(last, q)))
    if frame == FINITE_ROTATION:  # Rodrigues, of the angle between the normals
        axis, cosine = cross(last, n), dot(last, n)
        along = scale(dot(axis, q) / (1.0 + cosine), axis)
        return project(add(add(scale(cosine, q), cross(axis, q)), along), n)
    return q


@kernel
def _last_normal(contact: Records, rules: Records, n: Vector) -> Vector:
    last = vector(contact.normal)
    kept = rules.parted_springs_kept and dot(last, last) > 0.0
    return last if kept or contact.radius > 0.0 else n
