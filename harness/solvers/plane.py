"""Steps of spheres in the plane of x and y, compiled: the linear law, with or without friction.

In the plane a tangential spring is one number, whose frame turns with the contact, and a spin is
about z. With a list of the contacts that are near, a step costs a few tens of nanoseconds a moving
body. It is the same motion as that of :mod:`harness.solvers.contacts`, which runs all else.

Symbols: n normal towards the first body, t = z x n, q spring along t, u slip velocity along t.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from harness.model.conventions import Faults, Rules
from harness.model.law import DAMPING, Law
from harness.model.motion import Floats
from harness.model.scene import Scene
from harness.solvers.contacts import AT_LIMIT, EULER, VERLET, Integers, Records, System
from harness.solvers.kernels import (
    FORCE,
    PARTS,
    POSITION,
    SPIN,
    TORQUE,
    VELOCITY,
    inlined,
    kernel,
)
from harness.solvers.stages import GO_ON, OVER, Stages, look

SKIN = 0.2  # [radius of the smallest body] beyond contact, of the list of near contacts
PAIR = np.dtype([
    ("first", "i8"), ("second", "i8"), ("reach", "f8"), ("first_arm", "f8"), ("second_arm", "f8"),
    ("stiffness", "f8"), ("dashpot", "f8"), ("shear", "f8"), ("drag", "f8"), ("friction", "f8"),
    ("clipped", "?"), ("touches", "?"), ("spring", "f8"), ("shift", "f8"),
])  # fmt: skip
# conventions of contacts with friction that are those of a spring along t
OF_FRICTION = {"spring_frame": "turned", "slip_step": "velocity", "slides_in_setup": False}


class Plane(NamedTuple):
    """Contacts in the plane, and the list of near ones: ``near`` (C,), ``listed`` (1,) of them.

    ``origin`` (N, 2) are the positions for which the list was made; it holds while no body has
    moved by half of ``skin`` [m]. ``least`` [-] is the overlap that is no contact, over ``reach``.
    """

    pairs: Records
    near: Integers
    listed: Integers
    origin: Floats
    skin: float
    period: float
    least: float
    at_zero: bool
    sticking_only: bool
    arm_of_force: float  # [overlap] by which an arm is shorter than the radius
    arm_of_slip: float


# ---- which scenes


def is_planar(scene: Scene, rules: Rules, faults: Faults) -> bool:
    """Return whether a scene under conventions is one of this module."""
    if faults != Faults() or scene.walls or scene.segments or scene.drag:
        return False
    rubs = any(law.tangential != "none" and law.friction for law in scene.all_laws)
    if rubs and any(getattr(rules, name) != value for name, value in OF_FRICTION.items()):
        return False
    across = [scene.gravity[2]]
    for body in scene.bodies:
        across += [body.position[2], body.velocity[2], *body.angular_velocity[:2]]
    bounded = any(length is not None for length in scene.period[1:])
    return not any(across) and not bounded and all(map(_is_linear, scene.all_laws))


def _is_linear(law: Law) -> bool:
    linear = law.normal == "hooke" and DAMPING[law.damping].powers[1] == 0 and law.heat == "none"
    sliding = law.tangential in ("none", "linear_nohistory", "linear_history")
    return linear and sliding and law.rolling == law.twisting == "none"


def plane_of(scene: Scene, rules: Rules, contacts: Sequence[tuple[int, int, float]]) -> Plane:
    """Return the plane of a scene; ``contacts`` are pairs of bodies with m* [kg]."""
    pairs = np.zeros(len(contacts), dtype=PAIR)
    for pair, (i, j, mass) in zip(pairs, contacts, strict=True):
        first, second = scene.bodies[i], scene.bodies[j]
        law = scene.law_of(first.type, second.type)
        eta = law.dashpot(mass, 1.0, 0.0)
        pair["first"], pair["second"], pair["clipped"] = i, j, law.clipped
        pair["first_arm"], pair["second_arm"] = first.radius, second.radius
        pair["reach"] = first.radius + second.radius
        pair["stiffness"], pair["dashpot"] = law.normal_stiffness or 0.0, eta
        if law.tangential != "none":
            pair["friction"] = law.friction or 0.0
            pair["drag"] = (law.tangential_damping or 0.0) * eta
            pair["shear"] = law.tangential_stiffness or 0.0
    shorter = {"radius": 0.0, "contact_point": 0.5}
    return Plane(
        pairs=pairs,
        near=np.zeros(len(pairs), dtype=np.int64),
        listed=np.full(1, -1),
        origin=np.zeros((len(scene.bodies), 2)),
        skin=SKIN * min(body.radius for body in scene.bodies),
        period=scene.period[0] or 0.0,
        least=rules.least_overlap,
        at_zero=rules.bodies_touch_at_zero,
        sticking_only=rules.damping_in_cap == "sticking_only",
        arm_of_force=shorter[rules.torque_lever],
        arm_of_slip=shorter[rules.velocity_lever],
    )


# ---- steps


@kernel
def take_steps(
    system: System, plane: Plane, stages: Stages, number: int, steps: int, every: int,
    samples: Floats, kept: int,
) -> int:  # fmt: skip
    """Take steps from step ``number`` on; return how many were taken.

    Less where a look ends the run. ``kept`` samples are older than the first row of ``samples``.
    """
    state, bodies, movers, rules = system.state, system.bodies, system.movers, system.rules
    scheme, h = rules.scheme, rules.step
    for k in range(number + 1, number + steps + 1):
        if scheme == VERLET:
            _kick(state, bodies, movers, 0.5 * h)
            _move(state, movers, h)
        elif scheme == EULER:
            _kick(state, bodies, movers, h)
            _move(state, movers, h)
        else:  # Adams and Bashforth: v+ = v + h/2 (3 a - a_before), x+ = x + h/2 (v + v+)
            _move(state, movers, 0.5 * h)
            _extrapolate(state, system.before, movers)
            _kick(state, bodies, movers, h)
            _move(state, movers, 0.5 * h)
        _push_all(state, plane, movers, h)
        if scheme == VERLET:
            _kick(state, bodies, movers, 0.5 * h)
        if k % every == 0:
            _sample(state, samples[k // every - kept])
        sequel = look(state, stages, k)
        if sequel == OVER:
            return k - number
        if sequel != GO_ON:
            _push_all(state, plane, movers, 0.0)
    return steps


@kernel
def set_up(state: Floats, plane: Plane, movers: Integers) -> None:
    """Set forces and torques, and move no spring, as in the setup of a run."""
    _push_all(state, plane, movers, 0.0)


@inlined
def _kick(state: Floats, bodies: Records, movers: Integers, time: float) -> None:
    for m in range(len(movers)):
        b = movers[m]
        body = bodies[b]
        for k in range(2):
            pull = state[b, FORCE, k] * body.inverse_mass[k] + body.gravity[k]
            state[b, VELOCITY, k] += time * pull
        state[b, SPIN, 2] += time * (state[b, TORQUE, 2] * body.inverse_inertia)


@inlined
def _move(state: Floats, movers: Integers, time: float) -> None:
    for m in range(len(movers)):
        b = movers[m]
        for k in range(2):
            state[b, POSITION, k] += time * state[b, VELOCITY, k]


@kernel
def _extrapolate(state: Floats, before: Floats, movers: Integers) -> None:
    """Put 3/2 F - 1/2 F_before in the place of forces and torques, and keep them for the next."""
    for m in range(len(movers)):
        b = movers[m]
        for part in range(2):
            for k in range(3):
                now = state[b, FORCE + part, k]
                state[b, FORCE + part, k] = 1.5 * now - 0.5 * before[b, part, k]
                before[b, part, k] = now


@kernel
def _sample(state: Floats, sample: Floats) -> None:
    for b in range(len(state)):
        for part in range(PARTS):
            for k in range(3):
                sample[b, part, k] = state[b, part, k]


# ---- contacts


@inlined
def _push_all(state: Floats, plane: Plane, movers: Integers, h: float) -> None:
    if _list_is_old(state, plane, movers):
        _list_near(state, plane)
    for m in range(len(movers)):
        state[movers[m], FORCE, 0] = state[movers[m], FORCE, 1] = state[movers[m], TORQUE, 2] = 0.0
    for c in range(plane.listed[0]):
        for b in (plane.pairs[plane.near[c]].first, plane.pairs[plane.near[c]].second):
            state[b, FORCE, 0] = state[b, FORCE, 1] = state[b, TORQUE, 2] = 0.0
    for c in range(plane.listed[0]):
        _push(state, plane, plane.pairs[plane.near[c]], h)


@inlined
def _list_is_old(state: Floats, plane: Plane, movers: Integers) -> bool:
    old = plane.listed[0] < 0
    for m in range(len(movers)):
        b = movers[m]
        dx = state[b, POSITION, 0] - plane.origin[b, 0]
        dy = state[b, POSITION, 1] - plane.origin[b, 1]
        old |= not dx * dx + dy * dy <= 0.25 * plane.skin * plane.skin
    return bool(old)


@kernel
def _list_near(state: Floats, plane: Plane) -> None:
    """List the contacts that may close before a body has moved by half of the skin."""
    plane.listed[0] = 0
    for b in range(len(state)):
        plane.origin[b, 0], plane.origin[b, 1] = state[b, POSITION, 0], state[b, POSITION, 1]
        state[b, FORCE, 0] = state[b, FORCE, 1] = state[b, TORQUE, 2] = 0.0
    for c in range(len(plane.pairs)):
        pair = plane.pairs[c]
        i, j, shift = pair.first, pair.second, 0.0
        dx = state[i, POSITION, 0] - state[j, POSITION, 0]
        dy = state[i, POSITION, 1] - state[j, POSITION, 1]
        if plane.period > 0.0:
            shift = plane.period * math.floor(dx / plane.period + 0.5)
        reach = pair.reach + plane.skin
        if pair.touches or (dx - shift) * (dx - shift) + dy * dy <= reach * reach:
            pair.shift = shift
            plane.near[plane.listed[0]] = c
            plane.listed[0] += 1


@inlined
def _push(state: Floats, plane: Plane, pair: Records, h: float) -> None:
    """Add the forces of a contact to those of its bodies; h = 0 moves no spring."""
    i, j, reach = pair.first, pair.second, pair.reach
    dx = state[i, POSITION, 0] - state[j, POSITION, 0] - pair.shift
    dy = state[i, POSITION, 1] - state[j, POSITION, 1]
    square = dx * dx + dy * dy
    if square <= reach * reach * AT_LIMIT:  # a square root less where there is a gap
        distance = math.sqrt(square)
        overlap, least = reach - distance, plane.least * reach
        if overlap > least or (overlap == least and plane.at_zero):
            pair.touches = True
            _add_forces(state, plane, pair, dx / distance, dy / distance, overlap, h)
            return
    if pair.touches:
        pair.touches, pair.spring = False, 0.0


@inlined
def _add_forces(
    state: Floats, plane: Plane, pair: Records, nx: float, ny: float, overlap: float, h: float
) -> None:
    i, j = pair.first, pair.second
    vx = state[i, VELOCITY, 0] - state[j, VELOCITY, 0]
    vy = state[i, VELOCITY, 1] - state[j, VELOCITY, 1]
    force = pair.stiffness * overlap - pair.dashpot * (vx * nx + vy * ny)
    if pair.clipped and force < 0.0:
        force = 0.0
    along = 0.0
    if pair.friction > 0.0:
        shorter = plane.arm_of_slip * overlap
        turning = (pair.first_arm - shorter) * state[i, SPIN, 2]
        turning += (pair.second_arm - shorter) * state[j, SPIN, 2]
        along = _friction(plane, pair, vy * nx - vx * ny - turning, abs(force), h)
        shorter = plane.arm_of_force * overlap
        state[i, TORQUE, 2] -= (pair.first_arm - shorter) * along
        state[j, TORQUE, 2] -= (pair.second_arm - shorter) * along
    fx, fy = force * nx - along * ny, force * ny + along * nx
    state[i, FORCE, 0] += fx
    state[i, FORCE, 1] += fy
    state[j, FORCE, 0] -= fx
    state[j, FORCE, 1] -= fy


@kernel
def _friction(plane: Plane, pair: Records, u: float, load: float, h: float) -> float:
    """Return the force [N] along t on the first body, and bring its spring on."""
    k, q, cap = pair.shear, pair.spring, pair.friction * load
    if k > 0.0:
        q += h * u
    drag = -pair.drag * u
    sticking_only = plane.sticking_only and k > 0.0
    limited = -k * q if sticking_only else drag - k * q
    force = drag - k * q
    if abs(limited) > cap * AT_LIMIT:
        force = math.copysign(cap, limited)
        if k > 0.0 and q == 0.0:  # in a setup: a dashpot beyond the limit, without a spring
            force = 0.0
        elif k > 0.0:
            q = -force / k if sticking_only else (drag - force) / k
    pair.spring = q
    return float(force)
