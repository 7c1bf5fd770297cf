"""Rates of the state of a system of contacts: forces, what ends a smooth piece, scales, samples.

The state is a vector: position, velocity and angular velocity of each body, overlap and springs of
each contact. ``modes`` (contacts, columns) say whether a contact is open, and what each of its
sliders does; while they stay the motion is smooth. The arguments of all functions are those.
"""

from __future__ import annotations

import math

import numpy as np

from harness.solvers.pair.friction import (
    OFF,
    SLIDE,
    Normal,
    beyond,
    force,
    limits,
    load_rate,
    normal_force,
    slider_of,
    spring,
    state_rate,
    torque,
    velocity_rate,
)
from harness.solvers.pair.geometry import (
    Geometry,
    geometry,
    geometry_rates,
    levers,
    normal_and_gap,
    vector,
)
from harness.solvers.pair.normal import (
    HOOKE,
    JKR,
    MDR,
    grown,
    last_overlap,
    next_stage,
    pull_off_force,
    remembers,
)
from harness.solvers.pair.records import (
    BODY,
    CONTACT,
    TANGENTIAL,
    Floats,
    Integers,
    System,
    Vector,
    compiled,
    cross,
    length,
    plus,
    scaled,
)

OPEN, CLOSED, CLIPPED = range(3)
"""Of a contact: apart, touching, touching with its attractive force clipped to 0."""

STATE, SIGN, SLIDERS, OPENING = 0, 1, 2, 5
"""Columns of the modes; three sliders stand from SLIDERS on."""

TOUCH, LOAD, TURN, STAGE, KINDS = 0, 1, 5, 6, 7
"""Columns of what ends a piece: contact, sign of load, three sliders, sign of closing, stage."""


NEGLIGIBLE = 1e-8
"""[force, speed of a contact] below which a friction has no direction and closing no sign."""


END = 1e-12
"""[overlap of a contact] at which a contact that opens ends: at 0 its rates are infinite."""


@compiled
def place_of(system: System, contact: int) -> int:
    """Return where a contact stands in the state: overlap, then springs."""
    return int(BODY * len(system.bodies) + CONTACT * contact)


@compiled
def forces(y: Floats, system: System, modes: Integers) -> Floats:
    """Return force [N] and torque [N m] of the contacts on every body, (bodies, 6)."""
    result = np.zeros((len(system.bodies), 6))
    for c in range(len(system.contacts)):
        if modes[c, STATE] == CLOSED:
            _add_contact(result, y, system, modes, c)
    return result


@compiled
def _add_contact(result: Floats, y: Floats, system: System, modes: Integers, c: int) -> None:
    i, j = system.contacts[c].first, system.contacts[c].second
    g = geometry(y, system, c)
    normal = normal_force(g, system, c, modes[c, SIGN])
    total, couple = scaled(normal.force, g.normal), (0.0, 0.0, 0.0)
    first, second = levers(system, c, system.law.torque_lever, g.overlap)
    moment = (0.0, 0.0, 0.0)
    for kind in range(3):
        if modes[c, SLIDERS + kind] == OFF:
            continue
        f = slider_force(kind, g, normal, y, system, modes, c)
        if kind == TANGENTIAL:
            total, moment = plus(total, 1.0, f), cross(g.normal, f)
        else:
            couple = plus(couple, 1.0, torque(kind, f, g, system.contacts[c].curvature))
    add_force(result, i, 1.0, total, plus(couple, -first[0], moment))
    if j >= 0:
        add_force(result, j, -1.0, total, plus(couple, second[0], moment))


@compiled
def slider_force(
    kind: int, g: Geometry, normal: Normal, y: Floats, system: System, modes: Integers, c: int
) -> Vector:
    """Return the force of one slider on body i."""
    slider = slider_of(kind, g, normal, system, c, modes[c, OPENING] == 1)
    q = vector(y, place_of(system, c) + 1 + 3 * kind)
    cap = slider.friction * normal.load
    return force(slider, q, modes[c, SLIDERS + kind], cap, limits(kind, system.law))


@compiled
def slider_spring(y: Floats, system: System, modes: Integers, c: int, kind: int) -> Vector:
    """Return the elastic part of a slider's force on body i."""
    if modes[c, STATE] != CLOSED or modes[c, SLIDERS + kind] == OFF:
        return (0.0, 0.0, 0.0)
    g = geometry(y, system, c)
    normal = normal_force(g, system, c, modes[c, SIGN])
    slider = slider_of(kind, g, normal, system, c, modes[c, OPENING] == 1)
    cut_back, damping = limits(kind, system.law)
    mode = modes[c, SLIDERS + kind] if cut_back else 1
    q = vector(y, place_of(system, c) + 1 + 3 * kind)
    return spring(slider, q, mode, slider.friction * normal.load, damping)


@compiled
def add_force(result: Floats, body: int, sign: float, f: Vector, moment: Vector) -> None:
    """Add a force [N] and its torque [N m], times a sign, to those on a body (bodies, 6)."""
    for k in range(3):
        result[body, k] += sign * f[k]
        result[body, 3 + k] += sign * moment[k]


@compiled
def accelerations(y: Floats, system: System, modes: Integers) -> Floats:
    """Return linear [m/s2] and angular [rad/s2] accelerations, (bodies, 6)."""
    result = forces(y, system, modes)
    for b in range(len(system.bodies)):
        body = system.bodies[b]
        slower = _slower(y, system, body.radius)
        for k in range(3):
            result[b, k] = result[b, k] * body.inverse_mass + body.gravity[k]
            result[b, 3 + k] *= body.inverse_inertia * slower
    return result


@compiled
def _slower(y: Floats, system: System, radius: float) -> float:
    """Return the square of a radius [m] over that of the sphere grown: it has one contact."""
    if not system.law.yields:
        return 1.0
    more, _ = grown(system.law, system.contacts[0], y[place_of(system, 0)])
    return float((radius / (radius + more)) ** 2)


@compiled
def rates(y: Floats, system: System, modes: Integers, result: Floats) -> None:
    """Set ``result`` to the rate of the state."""
    accelerated = accelerations(y, system, modes)
    for b in range(len(system.bodies)):
        for k in range(3):
            result[BODY * b + k] = y[BODY * b + 3 + k]
            result[BODY * b + 3 + k] = accelerated[b, k]
            result[BODY * b + 6 + k] = accelerated[b, 3 + k]
    for c in range(len(system.contacts)):
        at = place_of(system, c)
        result[at : at + CONTACT] = 0.0
        if modes[c, STATE] != OPEN:
            _contact_rates(y, system, modes, accelerated, c, result)


@compiled
def _contact_rates(
    y: Floats, system: System, modes: Integers, accelerated: Floats, c: int, result: Floats
) -> None:
    at = place_of(system, c)
    g = geometry(y, system, c)
    result[at] = g.closing
    if modes[c, STATE] == CLIPPED:
        return
    normal = normal_force(g, system, c, modes[c, SIGN])
    rate = geometry_rates(g, y, system, c, accelerated)
    for kind in range(3):
        mode = modes[c, SLIDERS + kind]
        if mode == OFF:
            continue
        place = at + 1 + 3 * kind
        q = vector(y, place)
        slider = slider_of(kind, g, normal, system, c, modes[c, OPENING] == 1)
        size = system.contacts[c].mass * system.contacts[c].speed ** 2 / system.contacts[c].overlap
        cap = (slider.friction * normal.load, NEGLIGIBLE * slider.friction * size)
        swing = velocity_rate(kind, rate, g, system, c)
        moved = state_rate(slider, q, mode, cap, limits(kind, system.law), swing)
        moved = plus(moved, 1.0, cross(g.frame, q))
        for k in range(3):
            result[place + k] = moved[k]


@compiled
def endings(y: Floats, system: System, modes: Integers) -> Floats:
    """Return (contacts, 6) numbers that turn positive where a piece of the motion ends."""
    accelerated = accelerations(y, system, modes)
    result = np.full((len(system.contacts), KINDS), -1.0)
    for c in range(len(system.contacts)):
        if modes[c, STATE] == OPEN:
            _, overlap, _ = normal_and_gap(y, system, c)
            result[c, TOUCH] = _touch(overlap, geometry(y, system, c).closing, system, c)
        else:
            _contact_endings(y, system, modes, accelerated, c, result[c])
    return result


@compiled
def _touch(size: float, rate: float, system: System, c: int) -> float:
    """Return a size at whose rise through 0 a contact begins or ends; negative as it falls.

    Where a contact has just begun or ended it is positive or 0, and leads nowhere.
    """
    return size if rate > 0.0 else min(size, -END * system.contacts[c].overlap)


@compiled
def _contact_endings(
    y: Floats, system: System, modes: Integers, accelerated: Floats, c: int, result: Floats
) -> None:
    law = system.law
    g = geometry(y, system, c)
    normal = normal_force(g, system, c, modes[c, SIGN])
    curvature = system.contacts[c].curvature
    last = system.contacts[c].last
    if law.normal != MDR:
        last = last_overlap(law.normal, law.stiffness, law.surface, curvature, law.fold)
    separation = last + END * system.contacts[c].overlap - g.overlap
    result[TOUCH] = _touch(separation, -g.closing, system, c)
    if modes[c, STATE] == CLIPPED:
        result[LOAD] = normal.force
        return
    if normal.eta > 0.0 and law.surface == 0.0:
        result[LOAD] = -modes[c, SIGN] * normal.force
    turned = g.closing if modes[c, OPENING] == 1 else -g.closing
    result[TURN] = turned - NEGLIGIBLE * system.contacts[c].speed
    if law.yields and modes[c, OPENING] == 0:
        result[STAGE] = g.overlap - next_stage(system.contacts[c])
    elif modes[c, OPENING] == 0 and remembers(law, system.contacts[c]):
        largest = system.contacts[c].largest
        result[STAGE] = g.overlap - largest if largest > 0.0 else -1.0
    rate = geometry_rates(g, y, system, c, accelerated)
    grows = load_rate(normal, g, rate.closing, law, modes[c, SIGN])
    for kind in range(3):
        mode = modes[c, SLIDERS + kind]
        if mode == OFF:
            continue
        slider = slider_of(kind, g, normal, system, c, modes[c, OPENING] == 1)
        cap = slider.friction * normal.load
        cap_rate = slider.friction_rate * normal.load + slider.friction * grows
        q = vector(y, place_of(system, c) + 1 + 3 * kind)
        swing = velocity_rate(kind, rate, g, system, c)
        result[SLIDERS + kind] = beyond(slider, q, mode, (cap, cap_rate), limits(kind, law), swing)


# ---- units in which the errors of a step are measured


@compiled
def set_size(y: Floats, system: System, c: int) -> None:
    """Set overlap [m] and speed [m/s] of a contact: those of impact, weight and cohesion."""
    law, mass, curvature = system.law, system.contacts[c].mass, system.contacts[c].curvature
    g = geometry(y, system, c)
    speed = abs(g.closing)
    load = pull_off_force(law.normal, law.surface, curvature)
    for b in range(len(system.bodies)):
        pull = system.bodies[b].gravity
        load = max(load, mass * length((pull[0], pull[1], pull[2])))
    if law.normal == HOOKE:
        stiffness = law.stiffness
        overlap = max(speed * math.sqrt(mass / stiffness), load / stiffness, abs(g.overlap))
    else:
        k = 4.0 / 3.0 * law.stiffness * math.sqrt(curvature)
        last = last_overlap(law.normal, law.stiffness, law.surface, curvature, True)
        last = -last if law.normal == JKR else 0.0
        overlap = max((1.25 * mass * speed**2 / k) ** 0.4, (load / k) ** (2.0 / 3.0), last)
        overlap = max(overlap, abs(g.overlap), 1e-12 * curvature)
        stiffness = k * math.sqrt(overlap)
    overlap = max(overlap, 1e-12 * curvature)
    system.contacts[c].overlap = overlap
    system.contacts[c].speed = overlap * math.sqrt(stiffness / mass)


@compiled
def state_scales(y: Floats, system: System, modes: Integers) -> Floats:
    """Return the size of every number of the state, in which its errors are measured.

    A contact that overlaps more than its size gets a new one.
    """
    result = np.ones_like(y)
    overlap, speed = math.inf, math.inf
    for c in range(len(system.contacts)):
        if modes[c, STATE] != OPEN:
            if y[place_of(system, c)] > 2.0 * system.contacts[c].overlap:
                set_size(y, system, c)
            _contact_scales(y, system, modes, c, result)
            overlap, speed = (
                min(overlap, system.contacts[c].overlap),
                min(speed, system.contacts[c].speed),
            )
    for b in range(len(system.bodies)):
        at = BODY * b
        result[at : at + 3] = overlap
        result[at + 3 : at + 6] = speed
        result[at + 6 : at + 9] = speed / abs(system.bodies[b].radius)
    return result


@compiled
def _contact_scales(y: Floats, system: System, modes: Integers, c: int, result: Floats) -> None:
    overlap, speed = system.contacts[c].overlap, system.contacts[c].speed
    at = place_of(system, c)
    result[at : at + CONTACT] = overlap
    if system.law.by_force:
        result[at + 1 : at + 4] *= math.sqrt(system.contacts[c].curvature * overlap)
    result[at + 7 : at + 10] /= system.bodies[system.contacts[c].first].radius
    size = system.contacts[c].mass * speed**2 / overlap
    load = abs(normal_force(geometry(y, system, c), system, c, modes[c, SIGN]).load)
    for kind in range(3):
        if modes[c, SLIDERS + kind] == SLIDE and system.law.cut_back:
            # a direction counts by the force that it has
            place = at + 1 + 3 * kind
            result[place : place + 3] = min(1e8, max(1.0, size / max(load, 1e-300)))


# ---- what a run keeps of a state


@compiled
def sampled(y: Floats, system: System, modes: Integers) -> tuple[Floats, Floats, Floats]:
    """Return forces (bodies, 6) [N, N m], overlaps (contacts,) [m] and springs (contacts, 3, 3).

    An overlap is negative where the bodies are apart; springs are in N, N and N m.
    """
    overlaps, springs = np.empty(len(modes)), np.empty((len(modes), 3, 3))
    for c in range(len(modes)):
        if modes[c, STATE] == OPEN:
            overlaps[c] = normal_and_gap(y, system, c)[1]
        else:
            overlaps[c] = geometry(y, system, c).overlap
        for kind in range(3):
            springs[c, kind] = slider_spring(y, system, modes, c, kind)
    return forces(y, system, modes), overlaps, springs
