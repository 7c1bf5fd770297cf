"""Forces of contacts and steps of bodies, compiled; :mod:`harness.solvers.reference` runs them.

Springs follow Luding, Granular Matter 10, 235 (2008): one is turned into the plane of the contact,
grows by the slip of the step, and is cut back at Coulomb's limit to what the limit leaves (section
4.2). Other sources are with the laws in :mod:`harness.model.law`. Written from the literature and
manuals. The letters are those of the law: n normal, a contact radius, q spring, u slip velocity.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Any, NamedTuple, get_args

import numpy as np
from numpy.typing import NDArray

from harness.model.base import Parameters
from harness.model.conventions import Rules
from harness.model.law import Law
from harness.model.motion import Floats
from harness.model.scene import Wall
from harness.solvers import mdr
from harness.solvers.kernels import (
    FORCE,
    GO_ON,
    OVER,
    PARTS,
    POSITION,
    SPIN,
    TORQUE,
    VELOCITY,
    Stages,
    inlined,
    kernel,
    look,
)  # fmt: skip

Records = Any  # a record, or an array of records, of the types in harness.solvers.reference
Triple = tuple[float, float, float]
Integers = NDArray[np.int64]


@cache
def words(kind: type[Parameters], name: str) -> dict[str, int]:
    """Return the words that a field takes, with their numbers in records."""
    allowed = get_args(kind.model_fields[name].annotation)
    return {word: number for number, word in enumerate(allowed) if isinstance(word, str)}


HOOKE, DMT, JKR, MDR = (words(Law, "normal")[w] for w in ("hooke", "dmt", "jkr", "mdr"))
MARSHALL, WITHIN_RADIUS = words(Law, "twisting")["marshall"], words(Law, "heat")["radius"]
CONSTANT = words(Law, "rolling")["constant"]
VERLET, EULER = (words(Rules, "scheme")[w] for w in ("velocity_verlet", "mfix_euler"))
STICKING_ONLY = words(Rules, "damping_in_cap")["sticking_only"]
RADIUS, HEIGHT = (words(Rules, "wall_lever")[w] for w in ("radius", "height"))
ACROSS, PROJECTED_AXIS = (words(Rules, "rolling_axis")[w] for w in ("across", "projected"))
ELASTIC = words(Rules, "rolling_load")["elastic"]
SHORTENED = words(Rules, "rolling_lever")["shortened"]
LEVERED = words(Rules, "wall_spin")["levered"]
TURNED, PROJECTED, ROTATED, FINITE_ROTATION = (
    words(Rules, "spring_frame")[w] for w in ("turned", "projected", "rotated", "finite_rotation")
)
STAYS_TURNED = words(Rules, "torsion_frame")["turned"]
ROTATED_TORSION = words(Rules, "torsion_frame")["rotated"]
TURNED_ARMS = words(Rules, "slip_step")["turned_arms"]
BY_DISPLACEMENT = words(Rules, "rescaled_from")["displacement"]
MAGNIFIED = words(Rules, "mdr_wall_force")["magnified"]
PLANE, CYLINDER = (words(Wall, "shape")[w] for w in ("plane", "cylinder"))
AT_LIMIT = 1.0 + 1e-15  # a spring that was cut back may be off its limit by rounding
NONE: Triple = (0.0, 0.0, 0.0)


class System(NamedTuple):
    """A scene as records: what is given, and what moves.

    ``state`` (N, 5, 3) are position, velocity, angular velocity, force and torque; ``before``
    (N, 2, 3) forces and torques of the step before; ``heat`` (N, 2) temperature and heat flow. The
    second body of a contact at wall k is -1 - k; its radius is the contact radius of the step
    before, 0 apart; its springs are the tangential, rolling and twisting one. ``movers`` are the
    bodies that are not at rest for ever.
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


class Touch(NamedTuple):
    """Where two bodies are: normal towards the first, overlap [m], radius of the second [m].

    The radius is 0 for a plane, negative for a hollow wall and twice its own for a cylinder, which
    has its mean curvature. ``drift`` [m/s] is the velocity of a wall's surface.
    """

    normal: Triple
    overlap: float
    other: float
    drift: Triple


class Slip(NamedTuple):
    """A contact in a step: R*, a [m], eta [kg/s], forces [N], d [m], and how it slips."""

    radius: float
    a: float
    eta: float
    load: float  # of friction
    elastic: float
    overlap: float
    velocity: Triple  # [m/s] along the surface
    moved: Triple  # [m] in the step
    along: float  # [m] along the normal in the step
    spin: Triple  # [rad/s] of the first body against the second
    both: Triple  # [rad/s] of both together
    arm: float  # [m] R* by the share of the first radius that its lever has


# ---- steps


@kernel
def take_steps(
    system: System, stages: Stages, number: int, steps: int, every: int, samples: Floats,
    temperatures: Floats, kept: int,
) -> int:  # fmt: skip
    """Take steps from step ``number`` on; return how many were taken.

    Less where a look ends the run. ``kept`` samples are older than the first row of ``samples``.
    """
    rules, bodies, contacts = system.rules, system.bodies, system.contacts
    state, movers, scheme, h = system.state, system.movers, rules.scheme, rules.step
    for k in range(number + 1, number + steps + 1):
        if scheme == VERLET:
            _kick(state, bodies, movers, 0.5 * h)
            _move(state, movers, h)
        elif scheme == EULER:
            _kick(state, bodies, movers, h)
            _move(state, movers, h)
        else:  # Adams and Bashforth: v+ = v + h/2 (3 a - a_before), x+ = x + h/2 (v + v+)
            _move(state, movers, 0.5 * h)
            _extrapolate(state, system.before)
            _kick(state, bodies, movers, h)
            _move(state, movers, 0.5 * h)
        _clear(system, state, h, k * h)
        for c in range(len(contacts)):
            if not _is_far(state, bodies, contacts[c], rules):
                _touch(system, c, h, k * h)
        if rules.drag > 0.0:
            _add_drag(system)
        if scheme == VERLET:
            _kick(state, bodies, movers, 0.5 * h)
        if rules.heats:
            _warm(system)
        if k % every == 0:
            _sample(system, samples[k // every - kept], temperatures[k // every - kept])
        sequel = look(state, stages, k)
        if sequel == OVER:
            return k - number
        if sequel != GO_ON:
            set_up(system, k * h)
    return steps


@kernel
def set_up(system: System, time: float) -> None:
    """Set forces, torques and heat flows, and move no spring, as in the setup of a run."""
    _clear(system, system.state, 0.0, time)
    for c in range(len(system.contacts)):
        if not _is_far(system.state, system.bodies, system.contacts[c], system.rules):
            _touch(system, c, 0.0, time)
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


@inlined
def _clear(system: System, state: Floats, h: float, time: float) -> None:
    """Begin the sums of a step."""
    for b in range(len(state)):
        for k in range(3):
            state[b, FORCE, k] = state[b, TORQUE, k] = 0.0
        if system.rules.heats:
            system.heat[b, 1] = 0.0
    if system.rules.grows and h > 0.0:
        _grow(system, time)


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
    if contact.second < 0 or contact.radius > 0.0:
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
    contact, rules, touch = system.contacts[c], system.rules, _find_touch(system, c, time)
    law, first = system.laws[contact.law], system.bodies[contact.first].radius
    radius = _effective_radius(rules, first, touch.other)
    sticks = system.sides[c, 0].stuck > 0.0 or system.sides[c, 1].stuck > 0.0
    if not _is_apart(contact, law, rules, touch, radius, first, sticks):
        _add_contact(system, c, touch, radius, h)
    elif contact.radius > 0.0:
        contact.radius = contact.largest = contact.slope = 0.0
        for k in range(3):
            _store(contact.springs[k], NONE)
        for k in range(2):
            mdr.clear(system.sides[c, k])


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
    contact, rules = system.contacts[c], system.rules
    if contact.second >= 0:
        return _touch_body(system.state, system.bodies, contact, rules)
    wall, radius = system.walls[-1 - contact.second], system.bodies[contact.first].radius
    return _touch_wall(wall, rules, _vector(system.state[contact.first, POSITION]), radius, time)


@inlined
def _touch_body(state: Floats, bodies: Records, contact: Records, rules: Records) -> Touch:
    i, j, length = contact.first, contact.second, rules.period
    x, y = _vector(state[i, POSITION]), _vector(state[j, POSITION])
    separation = (
        _nearest(x[0] - y[0], length[0]), _nearest(x[1] - y[1], length[1]),
        _nearest(x[2] - y[2], length[2]),
    )  # fmt: skip
    distance, other = _size(separation), bodies[j].radius
    return Touch(
        _scale(1.0 / distance, separation), bodies[i].radius + other - distance, other, NONE
    )


@kernel
def _nearest(distance: float, period: float) -> float:
    """Return the distance [m] to the nearest periodic image along an axis."""
    if period == 0.0:
        return distance
    return distance - period * math.floor(distance / period + 0.5)


@kernel
def _touch_wall(wall: Records, rules: Records, x: Triple, radius: float, time: float) -> Touch:
    velocity, swing, phase = _vector(wall.velocity), _vector(wall.amplitude), wall.frequency * time
    moved = _add(_scale(time, velocity), _scale(1.0 - math.cos(phase), swing))
    drift = _add(velocity, _scale(wall.frequency * math.sin(phase), swing))
    drift = _add(drift, _vector(wall.surface_velocity))
    separation, axis = _minus(x, _vector(wall.point)), wall.direction
    separation, axis = _minus(separation, moved), (axis[0], axis[1], axis[2])
    if wall.shape == PLANE:
        return Touch(axis, radius - _dot(separation, axis), 0.0, drift)
    other = wall.radius
    if wall.shape == CYLINDER:
        separation, other = _project(separation, axis), 2.0 * wall.radius
        drift = _add(drift, _vector(rules.cylinder_shear))
    distance = math.copysign(_size(separation), wall.radius)
    normal = _scale(1.0 / distance, separation)
    drift = _add(drift, _scale(wall.radius, _cross(_vector(wall.spin), normal)))
    return Touch(normal, radius + wall.radius - distance, other, drift)


@inlined
def _effective_radius(rules: Records, radius: float, other: float) -> float:
    if other != 0.0:
        return radius * other / (radius + other)
    return float(radius / (1.0 + rules.wall_curvature))


@inlined
def _is_apart(
    contact: Records, law: Records, rules: Records, touch: Touch, radius: float, first: float,
    sticks: bool,
) -> bool:  # fmt: skip
    least = 0.0
    if contact.radius > 0.0 and law.normal == JKR:
        least = max(_end_of_jkr(law, radius), -rules.longest_neck)
    elif contact.radius > 0.0 and law.normal == MDR and not rules.mdr_parts_at_zero:
        if sticks:
            return False
    elif rules.least_overlap > 0.0:
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
    relative = _vector(state[i, VELOCITY])
    if j >= 0:
        relative = _minus(relative, _vector(state[j, VELOCITY]))
    elif h > 0.0 or not rules.wall_at_rest_in_setup:
        relative = _minus(relative, touch.drift)
    if law.normal == MDR:
        elastic, edge = _elastic_mdr(system, c, touch, h > 0.0)
        a, pull = math.sqrt(max(radius * touch.overlap, 0.0)), 0.0
    else:
        elastic, a, pull = _elastic(law, radius, touch.overlap)
        edge = a
    eta = _dashpot(contact, law, rules, elastic, edge, touch.overlap, h > 0.0)
    normal_force = elastic - eta * _dot(relative, n)
    if law.clipped:
        normal_force = max(normal_force, 0.0)
    load = abs(normal_force)
    if pull > 0.0:
        load = abs(elastic + (2.0 * pull if law.pull_loads else 0.0))
    along = couple = NONE
    if law.rubs:
        motion = relative, _vector(state[i, SPIN]), _vector(state[j, SPIN]) if j >= 0 else NONE
        forces = radius, a, eta, load, elastic
        slip = _slip(rules, j >= 0, touch, system.bodies[i].radius, motion, h, forces)
        along = _tangential_force(contact, law, rules, n, slip, h)
        couple = _rolling_torque(contact, law, rules, n, slip, h)
        couple = _add(couple, _twisting_torque(contact, law, rules, n, slip, h))
    contact.radius = max(a, 1e-300)
    _store(contact.normal, n)
    force, moment = _add(_scale(normal_force, n), along), _cross(n, along)
    kind = rules.torque_lever if j >= 0 else rules.wall_lever
    arm = _lever(kind, touch.overlap, system.bodies[i].radius)
    _act(state[i], force, _minus(couple, _scale(arm, moment)), 1.0)
    if j >= 0:
        arm = _lever(kind, touch.overlap, touch.other)
        _act(state[j], force, _add(couple, _scale(arm, moment)), -1.0)
    if law.heat > 0:
        _conduct(system, c, a)


@kernel
def _act(body: Floats, force: Triple, torque: Triple, sign: float) -> None:
    for k in range(3):
        body[FORCE, k] += sign * force[k]
        body[TORQUE, k] += sign * torque[k]


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
        return float(mdr.flat_depth(sides, 0, touch.overlap, largest, r, touch.other))
    return float(mdr.flat_depth(sides, 1, touch.overlap, largest, touch.other, r))


@kernel
def _elastic_mdr(system: System, c: int, touch: Touch, moves: bool) -> tuple[float, float]:
    """Return elastic force [N] and contact radius [m] of mdr: those of a wall, or both means."""
    contact, rules = system.contacts[c], system.rules
    law, wall = system.laws[contact.law], contact.second < 0
    contact.largest = max(contact.largest, touch.overlap)
    second = 0.0 if wall else _flat_depth(system, c, touch, 1, contact.largest)
    first, body = (
        _flat_depth(system, c, touch, 0, contact.largest),
        system.mdr_bodies[contact.first],
    )
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
def _lever(kind: int, overlap: float, radius: float) -> float:
    if kind == RADIUS:
        return radius
    return radius - (overlap if kind == HEIGHT else 0.5 * overlap)


@kernel
def _slip(
    rules: Records, pair: bool, touch: Touch, radius: float, motion: tuple[Triple, Triple, Triple],
    h: float, forces: tuple[float, float, float, float, float],
) -> Slip:  # fmt: skip
    """Return how a contact slips, by relative velocity [m/s] and both angular velocities.

    ``forces`` are the first five fields of a Slip.
    """
    n, (relative, spin, other) = touch.normal, motion
    kind = rules.velocity_lever if pair else rules.wall_lever
    first = _lever(kind, touch.overlap, radius)
    second = _lever(kind, touch.overlap, touch.other) if pair else 0.0
    arms = _add(_scale(first, spin), _scale(second, other))
    u = _minus(_project(relative, n), _cross(arms, n))
    moved, along = _scale(h, u), h * _dot(relative, n)
    if rules.slip_step == TURNED_ARMS and h > 0.0:
        sign = 1.0 if pair else -1.0  # at a wall the arm turns back
        by_first = _scale(sign, _turned(rules, _scale(-first, n), _scale(sign * h, spin)))
        by_second = _turned(rules, _scale(second, n), _scale(h, other))
        moved = _minus(_add(_scale(h, relative), by_first), by_second)
        along = _dot(moved, n)
        moved = _project(moved, n)
    felt = _minus(spin, other)
    if not pair and rules.wall_spin == LEVERED:
        felt = _scale((radius - 0.5 * touch.overlap) / (radius - touch.overlap), felt)
    effective, a, eta, load, elastic = forces
    return Slip(effective, a, eta, load, elastic, touch.overlap, u, moved, along, felt,
                _add(spin, other), effective * first / radius)  # fmt: skip


@kernel
def _turned(rules: Records, arm: Triple, angle: Triple) -> Triple:
    """Return how far an arm [m] turned by an angle [rad] about itself moves (Rodrigues)."""
    t = 0.5 * _size(angle)
    if rules.small_angle_quaternion and t > 0.0 and t**4 / 24.0 < 2.220446049250313e-16:
        angle = _scale(math.atan2(t * (1.0 - t * t / 6.0), 1.0 + 0.5 * t * t) / t, angle)
    size = _size(angle)
    if size == 0.0:
        return NONE
    axis, versine = _scale(1.0 / size, angle), 2.0 * math.sin(0.5 * size) ** 2
    across = _minus(_scale(_dot(axis, arm), axis), arm)
    return _add(_scale(versine, across), _scale(math.sin(size), _cross(axis, arm)))


# ---- springs and dashpots under a limit


@kernel
def _limit(
    sticking_only: bool, q: Triple, u: Triple, k: float, eta: float, cap: float
) -> tuple[Triple, Triple, bool]:
    """Return force and spring of a slider with velocity u, at most ``cap``; whether it slides."""
    spring, drag = _scale(-k, q), _scale(-eta, u)
    total = _add(spring, drag)
    sticking_only = sticking_only and k > 0.0
    limited = spring if sticking_only else total
    length = _size(limited)
    if length <= cap * AT_LIMIT:
        return total, q, False
    force = _scale(cap / length, limited)
    if k > 0.0:
        remaining = _scale(-1.0, force) if sticking_only else _minus(drag, force)
        q = _scale(1.0 / k, remaining)
    return force, q, True


@kernel
def _carry(q: Triple, frame: int, n: Triple, last: Triple, twist: float) -> Triple:
    """Return a spring of the step before, with the normal ``last``, in the contact now."""
    if frame == TURNED:
        across = _project(q, n)
        size = _size(across)
        return _scale(_size(q) / size, across) if size > 0.0 else across
    if frame == ROTATED:  # by small angles one after the other
        q = _minus(q, _cross(q, _cross(last, n)))
        return _add(q, _scale(twist, _cross(last, q)))
    if frame == FINITE_ROTATION:  # Rodrigues, of the angle between the normals
        axis, cosine = _cross(last, n), _dot(last, n)
        along = _scale(_dot(axis, q) / (1.0 + cosine), axis)
        return _add(_add(_scale(cosine, q), _cross(axis, q)), along)
    return q


@kernel
def _last_normal(contact: Records, n: Triple) -> Triple:
    return _vector(contact.normal) if contact.radius > 0.0 else n


@kernel
def _tangential_force(
    contact: Records, law: Records, rules: Records, n: Triple, slip: Slip, h: float
) -> Triple:
    """Return the tangential force [N] on the first body, and bring its spring on."""
    a = slip.a
    if law.friction <= 0.0:
        return NONE
    k = law.shear * (a if law.shear_by_radius and not law.keeps_force else 1.0)
    q, last, before = _vector(contact.springs[0]), _last_normal(contact, n), contact.radius
    if law.rescaled and h > 0.0:
        if rules.rescaled_from == BY_DISPLACEMENT:
            before = math.sqrt(slip.radius * max(slip.overlap + slip.along, 0.0))
        q = _scale(a / before, q) if a < before else q
    frame = PROJECTED if law.projected else rules.spring_frame
    q = _carry(q, frame, n, last, 0.5 * h * _dot(slip.both, last))
    if law.shear > 0.0:
        q = _add(q, _scale(a if law.keeps_force else 1.0, slip.moved))
    q = _project(q, n) if frame == PROJECTED and h > 0.0 else q
    eta, cap = law.tangential_damping * slip.eta, law.friction * slip.load
    sticking_only = rules.damping_in_cap == STICKING_ONLY
    force, spring, slides = _limit(sticking_only, q, slip.velocity, k, eta, cap)
    if slides and k > 0.0:
        spring = _scale(a, spring) if law.cut_by_radius else spring
        if _size(q) == 0.0 and not rules.slides_in_setup:
            force, spring = NONE, q
    if h > 0.0 or not rules.forgets_setup:
        _store(contact.springs[0], spring)
    return force


@kernel
def _rolling_torque(
    contact: Records, law: Records, rules: Records, n: Triple, slip: Slip, h: float
) -> Triple:
    """Return the torque of rolling resistance [N m] on the first body, and bring its spring on."""
    turned = rules.torsion_frame == STAYS_TURNED
    if law.rolling_friction <= 0.0:
        return NONE
    if law.rolling == CONSTANT:
        return _constant_torque(law, rules, n, slip)
    u = _cross(slip.spin, n) if turned else _project(slip.spin, n)
    force = _torsion(
        contact, rules, n, slip, h, 1, _scale(slip.radius, u),
        (law.rolling_stiffness, law.rolling_damping, law.rolling_friction * slip.load),
    )  # fmt: skip
    return _scale(slip.radius, _cross(n, force) if turned else force)


@kernel
def _constant_torque(law: Records, rules: Records, n: Triple, slip: Slip) -> Triple:
    """Return the torque [N m] on the first body: -mu_r R* |F_n| w / |w| of the rolling spin w.

    Model A of Ai and others (2011). A body at rest turns back and forth by the spin of a step.
    """
    across = _project(slip.spin, n)
    axis = across if rules.rolling_axis in (ACROSS, PROJECTED_AXIS) else slip.spin
    size = _size(across if rules.rolling_axis == ACROSS else slip.spin)
    if size == 0.0:
        return NONE
    force = abs(slip.elastic) if rules.rolling_load == ELASTIC else slip.load
    arm = slip.arm if rules.rolling_lever == SHORTENED else slip.radius
    torque = law.rolling_friction * arm * force
    return _scale(-torque / (1.0 if rules.rolling_by_rate else size), axis)


@kernel
def _twisting_torque(
    contact: Records, law: Records, rules: Records, n: Triple, slip: Slip, h: float
) -> Triple:
    """Return the torque of twisting [N m] on the first body, and bring its spring on."""
    a, k, eta, mu = slip.a, law.twisting_stiffness, law.twisting_damping, law.twisting_friction
    if law.twisting == MARSHALL:
        k = 0.5 * law.shear * (a if law.marshall_by_radius else 1.0) * a * a
        eta, mu = 0.5 * law.tangential_damping * slip.eta * a * a, 2.0 / 3.0 * a * law.friction
    if mu <= 0.0:
        return NONE
    u = _scale(_dot(slip.spin, n), n)
    return _torsion(contact, rules, n, slip, h, 2, u, (k, eta, mu * slip.load))


@kernel
def _torsion(
    contact: Records, rules: Records, n: Triple, slip: Slip, h: float, kind: int, u: Triple,
    slider: tuple[float, float, float],
) -> Triple:  # fmt: skip
    """Return the force of a rolling (1) or twisting (2) slider: stiffness, dashpot and limit."""
    k, eta, cap = slider
    q, last, frame = _vector(contact.springs[kind]), _last_normal(contact, n), rules.torsion_frame
    if frame == STAYS_TURNED and kind == 2:
        q = _scale(math.copysign(_size(q), _dot(q, n)), n)
    elif frame == STAYS_TURNED:
        q = _carry(q, TURNED, n, last, 0.0)
    elif frame == ROTATED_TORSION:
        q = _carry(q, ROTATED, n, last, 0.5 * h * _dot(slip.both, last))
    forgets = rules.forgets_setup and h == 0.0
    q = _add(q, _scale(rules.step if forgets else h, u))
    force, spring, slides = _limit(rules.damping_in_cap == STICKING_ONLY, q, u, k, eta, cap)
    if slides and kind == 1 and k > 0.0 and _size(q) == 0.0 and not rules.slides_in_setup:
        force, spring = NONE, q
    if slides and kind == 2 and rules.twisting_limit_by_rate:
        force = _scale(-cap * np.sign(_dot(u, n)), n)
        spring = _scale(-1.0 / k, _add(force, _scale(eta, u)))
    if not forgets:
        _store(contact.springs[kind], spring)
    return force


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


# ---- vectors


@kernel
def _vector(values: Floats) -> Triple:
    return (values[0], values[1], values[2])


@kernel
def _store(place: Floats, values: Triple) -> None:
    place[0], place[1], place[2] = values


@kernel
def _add(a: Triple, b: Triple) -> Triple:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def _minus(a: Triple, b: Triple) -> Triple:
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def _scale(factor: float, a: Triple) -> Triple:
    return (factor * a[0], factor * a[1], factor * a[2])


@kernel
def _dot(a: Triple, b: Triple) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def _cross(a: Triple, b: Triple) -> Triple:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def _size(a: Triple) -> float:
    return math.sqrt(_dot(a, a))


@kernel
def _project(a: Triple, n: Triple) -> Triple:
    """Return the part of a vector in the plane of a contact."""
    return _minus(a, _scale(_dot(a, n), n))
