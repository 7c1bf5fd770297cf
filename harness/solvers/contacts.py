"""Forces of contacts and steps of bodies, compiled; :mod:`harness.solvers.reference` runs them.

Sources are with the laws in :mod:`harness.model.law`; :mod:`harness.solvers.friction` has what acts
along the surface. Written from the literature and manuals. The letters are those of the law: n
normal, a contact radius, d overlap, h step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.model.base import ZERO, Vector
from harness.model.conventions import Rules
from harness.model.law import Law
from harness.model.scene import Floats, Wall
from harness.solvers import friction, mdr
from harness.solvers.friction import Press, Touch, lever
from harness.solvers.kernels import (
    FIRST,
    FORCE,
    GO_ON,
    OVER,
    PARTS,
    POSITION,
    SECOND,
    SPIN,
    TORQUE,
    VELOCITY,
    Records,
    Stages,
    add,
    cross,
    dot,
    inlined,
    kernel,
    look,
    minus,
    project,
    scale,
    size,
    store,
    vector,
    words,
)  # fmt: skip

Integers = NDArray[np.int64]

HOOKE, _, DMT, JKR, MDR = words(Law, "normal").values()
VERLET, _, BASHFORTH = words(Rules, "scheme").values()
PLANE, CYLINDER, _ = words(Wall, "shape").values()
MAGNIFIED = words(Rules, "mdr_wall_force")["magnified"]
WITHIN_RADIUS = words(Law, "heat")["radius"]


class System(NamedTuple):
    """A scene as records: what is given, and what moves.

    ``state`` (N, 5, 3) are position, velocity, angular velocity, force and torque; ``before``
    (N, 2, 3) forces and torques of the step before; ``heat`` (N, 2) temperature and heat flow. The
    second body of a contact at wall k is -1 - k. A contact has its radius of the step before, 0
    where it is open, and a tangential, a rolling and a twisting spring. ``movers`` are the bodies
    that are not at rest for ever.
    """

    rules: Records
    laws: Records
    bodies: Records
    walls: Records
    contacts: Records
    state: Floats
    before: Floats
    heat: Floats
    mdr_bodies: Records
    sides: Records
    movers: Integers


# ---- steps


@kernel
def take_steps(
    system: System, stages: Stages, number: int, steps: int, every: int, samples: Floats,
    temperatures: Floats,
) -> int:  # fmt: skip
    """Take steps from step ``number`` on; return how many were taken: less where a look ends it.

    At the start of a run, with 0 steps and where a look requests it, forces are set up: no spring
    moves.
    """
    rules, bodies, state, movers = system.rules, system.bodies, system.state, system.movers
    scheme, h, k, sets_up = rules.scheme, rules.step, number, steps == 0
    while k < number + steps or sets_up:
        if not sets_up:
            k += 1
            if scheme == BASHFORTH:  # v+ = v + h/2 (3 a - a_before), x+ = x + h/2 (v + v+)
                _move(state, movers, 0.5 * h)
                _extrapolate(state, system.before)
            _kick(state, bodies, movers, 0.5 * h if scheme == VERLET else h)
            _move(state, movers, 0.5 * h if scheme == BASHFORTH else h)
        _set_forces(system, 0.0 if sets_up else h, k * h)
        if sets_up:
            sets_up = False
            continue
        if scheme == VERLET:
            _kick(state, bodies, movers, 0.5 * h)
        if rules.heats:
            _warm(system)
        if k % every == 0:
            _sample(system, samples[k // every], temperatures[k // every])
        sequel = look(state, stages, k)
        if sequel == OVER:
            return k - number
        sets_up = sequel != GO_ON
    return steps


@inlined
def _set_forces(system: System, h: float, time: float) -> None:
    state, rules = system.state, system.rules
    for b in range(len(state)):
        for k in range(3):
            state[b, FORCE, k] = state[b, TORQUE, k] = 0.0
        if rules.heats:
            system.heat[b, 1] = 0.0
    if rules.grows and h > 0.0:
        _grow(system, time)
    for c in range(len(system.contacts)):
        if not _is_far(state, system.bodies, system.contacts[c], rules):
            _touch(system, c, h, time)
    if rules.drag > 0.0:
        _add_drag(system)


@inlined
def _kick(state: Floats, bodies: Records, movers: Integers, time: float) -> None:
    for m in range(len(movers)):
        b = movers[m]
        body = bodies[b]
        for k in range(3):
            pull = state[b, FORCE, k] * body.inverse_mass[k] + body.gravity[k]
            state[b, VELOCITY, k] += time * pull
            state[b, SPIN, k] += time * (state[b, TORQUE, k] * body.inverse_inertia)


@inlined
def _move(state: Floats, movers: Integers, time: float) -> None:
    for m in range(len(movers)):
        b = movers[m]
        for k in range(3):
            state[b, POSITION, k] += time * state[b, VELOCITY, k]


@kernel
def _sample(system: System, sample: Floats, temperatures: Floats) -> None:
    for b in range(len(system.state)):
        temperatures[b] = system.heat[b, 0]
        for part in range(PARTS):
            for k in range(3):
                sample[b, part, k] = system.state[b, part, k]


@kernel
def _extrapolate(state: Floats, before: Floats) -> None:
    """Put 3/2 F - 1/2 F_before in the place of forces and torques, and keep them for the next."""
    for b in range(len(state)):
        for part in range(2):
            for k in range(3):
                now = state[b, FORCE + part, k]
                state[b, FORCE + part, k] = 1.5 * now - 0.5 * before[b, part, k]
                before[b, part, k] = now


@kernel
def _add_drag(system: System) -> None:
    for b in system.movers:
        drag = system.rules.drag * system.bodies[b].dragged
        for k in range(3):
            system.state[b, FORCE, k] -= drag * system.state[b, VELOCITY, k]


@kernel
def _warm(system: System) -> None:
    for b in range(len(system.heat)):
        heat = system.rules.step * system.heat[b, 1]
        system.heat[b, 0] += heat / system.bodies[b].heat_capacity


@inlined
def _is_far(state: Floats, bodies: Records, contact: Records, rules: Records) -> bool:
    """Return whether two bodies are too far to touch, as most are."""
    if contact.second < 0 or contact.radius > 0.0 or rules.parted_springs_kept:
        return False
    i, j, square = contact.first, contact.second, 0.0
    reach = 1.000001 * (bodies[i].radius + bodies[j].radius)
    for k in range(3):
        gap = _nearest(state[i, POSITION, k] - state[j, POSITION, k], rules.period[k])
        if abs(gap) > reach:
            return True
        square += gap * gap
    return bool(square > reach * reach)


@inlined
def _touch(system: System, c: int, h: float, time: float) -> None:
    contact, touch = system.contacts[c], _find_touch(system, c, time)
    first, other = system.bodies[contact.first].radius, touch.other
    radius = first / (1.0 + system.rules.wall_curvature)
    if other != 0.0:
        radius = first * other / (first + other)
    if not _is_apart(system, c, touch, radius):
        _add_contact(system, c, touch, radius, h)
    elif contact.radius > 0.0:
        if contact.second >= 0 and system.rules.parted_springs_kept:
            law = system.laws[contact.law]
            elastic, _, _ = _elastic(law, radius, contact.radius**2 / radius)  # of the last step
            friction.keep_spring(contact, law, system.rules, elastic)
        else:
            for k in range(3):
                store(contact.springs[k], ZERO)
        contact.radius = contact.largest = contact.slope = 0.0
        for k in range(2):
            mdr.clear(system.sides[c, k])
    elif system.rules.parted_springs_kept:
        store(contact.normal, touch.normal)


@kernel
def _grow(system: System, time: float) -> None:
    """Let bodies of mdr grow, and sum up the mean displacements of their surfaces."""
    for b in range(len(system.bodies)):
        body = system.bodies[b]
        before = body.radius
        body.radius = mdr.grow(system.laws[0], system.rules, system.mdr_bodies[b])
        body.inverse_inertia *= (before / body.radius) ** 2
    for c in range(len(system.contacts)):
        contact, touch = system.contacts[c], _find_touch(system, c, time)
        if touch.overlap > 0.0:
            largest = max(contact.largest, touch.overlap)
            for k in range(2 if contact.second >= 0 else 1):
                depth = _flat_depth(system, c, touch, k, largest)
                body = system.mdr_bodies[contact.first if k == 0 else contact.second]
                mdr.add_displacement(body, system.sides[c, k], depth)


# ---- where bodies touch


@inlined
def _find_touch(system: System, c: int, time: float) -> Touch:
    contact, state = system.contacts[c], system.state
    i, j = contact.first, contact.second
    radius, x = system.bodies[i].radius, vector(state[i, POSITION])
    if j < 0:
        return _touch_wall(system.walls[-1 - j], system.rules, x, radius, time)
    length, y = system.rules.period, vector(state[j, POSITION])
    separation = (
        _nearest(x[0] - y[0], length[0]), _nearest(x[1] - y[1], length[1]),
        _nearest(x[2] - y[2], length[2]),
    )  # fmt: skip
    distance, other = size(separation), system.bodies[j].radius
    return Touch(scale(1.0 / distance, separation), radius + other - distance, other, ZERO)


@kernel
def _nearest(distance: float, period: float) -> float:
    """Return the distance [m] to the nearest periodic image along an axis."""
    if period == 0.0:
        return distance
    return distance - period * math.floor(distance / period + 0.5)


@kernel
def _touch_wall(wall: Records, rules: Records, x: Vector, radius: float, time: float) -> Touch:
    velocity, swing, phase = vector(wall.velocity), vector(wall.amplitude), wall.frequency * time
    moved = add(scale(time, velocity), scale(1.0 - math.cos(phase), swing))
    drift = add(velocity, scale(wall.frequency * math.sin(phase), swing))
    drift = add(drift, vector(wall.surface_velocity))
    separation, axis = minus(x, vector(wall.point)), wall.direction
    separation, axis = minus(separation, moved), (axis[0], axis[1], axis[2])
    if wall.shape == PLANE:
        return Touch(axis, radius - dot(separation, axis), 0.0, drift)
    other = wall.radius
    if wall.shape == CYLINDER:
        separation, other = project(separation, axis), 2.0 * wall.radius
        drift = add(drift, vector(rules.cylinder_shear))
    distance = math.copysign(size(separation), wall.radius)
    normal = scale(1.0 / distance, separation)
    drift = add(drift, scale(wall.radius, cross(vector(wall.spin), normal)))
    return Touch(normal, radius + wall.radius - distance, other, drift)


@inlined
def _is_apart(system: System, c: int, touch: Touch, radius: float) -> bool:
    contact, rules, least = system.contacts[c], system.rules, 0.0
    law, sides = system.laws[contact.law], system.sides[c]
    if contact.radius > 0.0 and law.normal == JKR:
        least = max(_end_of_jkr(law, radius), -rules.longest_neck)
    elif contact.radius > 0.0 and law.normal == MDR and not rules.mdr_parts_at_zero:
        if sides[0].stuck > 0.0 or sides[1].stuck > 0.0:
            return False
    elif rules.least_overlap > 0.0:
        first = system.bodies[contact.first].radius
        least = rules.least_overlap * (first + max(touch.other, 0.0))
    at_zero = rules.wall_touches_at_zero if contact.second < 0 else rules.bodies_touch_at_zero
    if touch.overlap == least and at_zero:
        return False
    return bool(touch.overlap <= least)


@kernel
def _end_of_jkr(law: Records, radius: float) -> float:
    """Return the overlap [m] of JKR's largest tension, a^3 = 9 pi gamma R*^2 / (4 E*)."""
    cube = 9.0 * math.pi * law.surface_energy * radius * radius / (4.0 * law.stiffness)
    return float(-(cube ** (2.0 / 3.0)) / (3.0 * radius))


# ---- the forces of a contact


@inlined
def _add_contact(system: System, c: int, touch: Touch, radius: float, h: float) -> None:
    """Add the forces of a contact to those of its bodies; h = 0 moves no spring."""
    contact, rules, n, state = system.contacts[c], system.rules, touch.normal, system.state
    i, j, law = contact.first, contact.second, system.laws[contact.law]
    pair, first = j >= 0, system.bodies[i].radius
    relative = vector(state[i, VELOCITY])
    if pair:
        relative = minus(relative, vector(state[j, VELOCITY]))
    elif h > 0.0 or not rules.wall_at_rest_in_setup:
        relative = minus(relative, touch.drift)
    press = find_press(system, c, touch, radius, dot(relative, n), h > 0.0)
    along = couple = ZERO
    if law.rubs:
        motion = relative, vector(state[i, SPIN]), vector(state[j, SPIN]) if pair else ZERO
        slip = friction.find_slip(rules, pair, touch, press, first, motion, h)
        along = friction.tangential_force(contact, law, rules, touch, press, slip, h)
        couple = friction.rolling_torque(contact, law, rules, n, press, slip, h)
        couple = add(couple, friction.twisting_torque(contact, law, rules, n, press, slip, h))
    contact.radius = max(press.a, 1e-300)
    store(contact.normal, n)
    force, moment = add(scale(press.force, n), along), cross(n, along)
    kind = rules.torque_lever if pair else rules.wall_lever
    arm = lever(kind, touch.overlap, first)
    _act(state[i], force, minus(couple, scale(arm, moment)), 1.0)
    if pair:
        arm = lever(kind, touch.overlap, touch.other)
        _act(state[j], force, add(couple, scale(arm, moment)), -1.0)
    if law.heat > 0:
        _conduct(system, c, press.a)


@kernel
def _act(body: Floats, force: Vector, torque: Vector, sign: float) -> None:
    for k in range(3):
        body[FORCE, k] += sign * force[k]
        body[TORQUE, k] += sign * torque[k]


@inlined
def find_press(
    system: System, c: int, touch: Touch, radius: float, parting: float, moves: bool
) -> Press:
    """Return the normal part of a contact with R* [m] that parts at a speed [m/s]."""
    contact, law = system.contacts[c], system.laws[system.contacts[c].law]
    if law.normal == MDR:
        elastic, edge = _elastic_mdr(system, c, touch, moves)
        a, pull = math.sqrt(max(radius * touch.overlap, 0.0)), 0.0
    else:
        elastic, a, pull = _elastic(law, radius, touch.overlap)
        edge = a
    eta = _dashpot(contact, law, system.rules, elastic, edge, touch.overlap, moves)
    force = elastic - eta * parting
    if law.clipped:
        force = max(force, 0.0)
    load = abs(force)
    if pull > 0.0:
        load = abs(elastic + (2.0 * pull if law.pull_loads else 0.0))
    return Press(radius, a, eta, force, elastic, load)


@kernel
def _elastic(law: Records, radius: float, overlap: float) -> tuple[float, float, float]:
    """Return elastic force [N], contact radius [m] and pull-off force [N]."""
    gamma, modulus = law.surface_energy, law.stiffness
    if law.normal == JKR and gamma > 0.0:
        a = jkr_radius(modulus, gamma, radius, overlap)
        tension = 4.0 * math.sqrt(math.pi * gamma * modulus * a**3)
        return 4.0 / 3.0 * modulus * a**3 / radius - tension, a, 3.0 * math.pi * gamma * radius
    a = math.sqrt(max(radius * overlap, 0.0))
    if law.normal == HOOKE:
        return modulus * overlap, a, 0.0
    pull = 4.0 * math.pi * gamma * radius if law.normal == DMT else 0.0
    return 4.0 / 3.0 * modulus * a * overlap - pull, a, pull


@kernel
def jkr_radius(modulus: float, gamma: float, radius: float, overlap: float) -> float:
    """Return a [m] of d = a^2/R - 2 sqrt(pi gamma a/E*) on the stable branch, by Newton in sqrt(a).

    At overlaps below the end of that branch it is the radius there.
    """
    c = math.sqrt(math.pi * gamma / modulus)
    fold = (0.5 * c * radius) ** (1.0 / 3.0)
    if fold**4 / radius - 2.0 * c * fold >= overlap:
        return float(fold * fold)
    root = (2.0 * c * radius) ** (1.0 / 3.0) + max(overlap * radius, 0.0) ** 0.25  # from above
    for _ in range(60):
        excess = root**4 / radius - 2.0 * c * root - overlap
        change = excess / (4.0 * root**3 / radius - 2.0 * c)
        root -= change
        if change <= 4e-16 * root:
            break
    return float(root * root)


@kernel
def _flat_depth(system: System, c: int, touch: Touch, k: int, largest: float) -> float:
    r, sides = system.bodies[system.contacts[c].first].radius, system.sides[c]
    if k == 0:
        return float(mdr.flat_depth(sides, FIRST, touch.overlap, largest, r, touch.other))
    return float(mdr.flat_depth(sides, SECOND, touch.overlap, largest, touch.other, r))


@kernel
def _elastic_mdr(system: System, c: int, touch: Touch, moves: bool) -> tuple[float, float]:
    """Return elastic force [N] and contact radius [m] of mdr: those of a wall, or both means."""
    contact, rules = system.contacts[c], system.rules
    law, wall = system.laws[contact.law], contact.second < 0
    contact.largest = max(contact.largest, touch.overlap)
    second = 0.0 if wall else _flat_depth(system, c, touch, SECOND, contact.largest)
    first = _flat_depth(system, c, touch, FIRST, contact.largest)
    body = system.mdr_bodies[contact.first]
    force, a = mdr.side_force(law, rules, body, system.sides[c, 0], first, moves)
    if not wall:
        other = system.mdr_bodies[contact.second]
        its_force, its_a = mdr.side_force(law, rules, other, system.sides[c, 1], second, moves)
        return 0.5 * (force + its_force), 0.5 * (a + its_a)
    if rules.mdr_wall_force == MAGNIFIED:
        force *= 1.0 + math.exp(10.7 * system.sides[c, 0].depth_in_first / body.first_radius - 10.0)
    return force, a


@kernel
def _dashpot(
    contact: Records, law: Records, rules: Records, elastic: float, a: float, overlap: float,
    moves: bool,
) -> float:  # fmt: skip
    """Return eta [kg/s] of an elastic force [N], a contact radius [m] and an overlap [m]."""
    eta = law.dashpot
    if law.normal == MDR and a <= 0.0:  # a dent that does not touch
        return 0.0
    if law.normal == MDR:
        if moves:
            wall = contact.second < 0
            factor = (0.5 if wall else 2.0) if rules.mdr_damping_interchanged else 1.0
            slope = 2.0 * (2.0 if wall else 1.0) * law.stiffness * a
            contact.slope = factor * math.sqrt(contact.mass * slope)
        if law.by_slope or contact.slope == 0.0:  # none in the first setup, whatever the dashpot
            return float(eta * contact.slope)
    if law.by_secant:
        root = max(contact.mass * elastic / overlap, 0.0) if overlap != 0.0 else 0.0
        if law.normal == HOOKE:  # also where two bodies just touch
            root = contact.mass * law.stiffness
        return float(eta * math.sqrt(root))
    for _ in range(law.mass_power):
        eta = eta * contact.mass
    for _ in range(law.radius_power):
        eta = eta * a
    return float(eta)


@kernel
def _conduct(system: System, c: int, a: float) -> None:
    """Add the heat [W] that flows through a contact: 2 k a, or h pi a^2, times K."""
    contact, heat = system.contacts[c], system.heat
    i, j, law = contact.first, contact.second, system.laws[contact.law]
    other = heat[j, 0] if j >= 0 else system.walls[-1 - j].temperature
    area = 2.0 * a if law.heat == WITHIN_RADIUS else math.pi * a * a
    flow = law.conductance * area * (other - heat[i, 0])
    heat[i, 1] += flow
    if j >= 0:
        heat[j, 1] -= flow
