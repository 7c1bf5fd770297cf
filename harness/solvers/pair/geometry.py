"""Where two bodies touch and how they move there; in free flight, when they touch next.

The contact point is at a *lever* from the centre of a sphere, which codes choose differently
(``torque_lever``, ``velocity_lever``, ``wall_lever`` of :class:`~harness.parameters.rules.Rules`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from harness.solvers.pair.normal import grown
from harness.solvers.pair.records import (
    BODY,
    CONTACT,
    Floats,
    System,
    Vector,
    across,
    compiled,
    cross,
    dot,
    length,
    plus,
    scaled,
)

# ---- levers: of the force of a contact, and of omega in the velocity there

RADIUS, CONTACT_POINT, SHARE, CIRCLE, HEIGHT = range(5)

KINDS = {
    "radius": RADIUS,
    "contact_point": CONTACT_POINT,
    "share": SHARE,
    "circle": CIRCLE,
    "height": HEIGHT,
}


@compiled
def lever(kind: int, overlap: float, radius: float, other: float) -> tuple[float, float]:
    """Return the lever [m] of a sphere of a radius on one of another, and d(lever)/d(overlap).

    contact_point: half the overlap is taken off. share: that part of it that the radius has of
    both. circle: the plane in which the spheres cut. height: the plane of a wall.
    """
    if kind == RADIUS:
        return radius, 0.0
    if kind == HEIGHT:
        return radius - overlap, -1.0
    both = radius + other
    if kind == SHARE:
        part = radius / both
        return radius - part * overlap, -part
    if kind == CIRCLE:
        distance = both - overlap
        uneven = (radius - other) * both / distance
        return 0.5 * (distance + uneven), 0.5 * (uneven / distance - 1.0)
    return radius - 0.5 * overlap, -0.5


@compiled
def raised(
    before: tuple[float, float], kind: int, grown: tuple[float, float], spheres: float
) -> tuple[float, float]:
    """Return a lever and its slope where each of one or two ``spheres`` has grown by as much [m].

    ``before`` is that of radius and overlap as they were, ``grown`` has its slope with that
    overlap, too. Both grow, the place of the contact and the centres stay.
    """
    share = 0.0
    if kind == RADIUS:
        share = 1.0
    elif kind == CONTACT_POINT:
        share = 1.0 - 0.5 * spheres
    return before[0] + share * grown[0], before[1] + share * grown[1]


@compiled
def levered(overlap: float, radius: float) -> tuple[float, float]:
    """Return the lever of a contact point over the height of the centre, and its slope [1/m].

    For a sphere on a wall: (r - overlap/2) / (r - overlap).
    """
    height = radius - overlap
    return (radius - 0.5 * overlap) / height, 0.5 * radius / height**2


# ---- a contact at an instant


class Geometry(NamedTuple):
    """A contact at one instant: vectors along and across its normal, from body j to body i."""

    normal: Vector
    turning: Vector  # rate of the normal
    frame: Vector  # angular velocity of the frame in which springs are kept
    overlap: float
    closing: float  # rate of the overlap
    relative: Vector  # v_i - v_j
    levers: tuple[float, float]  # of omega_i and omega_j in the velocity at the contact
    stretching: tuple[float, float]  # rates of the levers
    slip: Vector  # tangential velocity at the contact
    spin: Vector  # that rolling and twisting feel: omega_i - omega_j
    felt: tuple[float, float]  # its share of that, and the rate of the share


@compiled
def vector(y: Floats, at: int) -> Vector:
    """Return three numbers of the state."""
    return (y[at], y[at + 1], y[at + 2])


@compiled
def normal_and_gap(y: Floats, system: System, contact: int) -> tuple[Vector, float, float]:
    """Return the normal, the overlap [m] by the positions and the distance of the centres [m].

    At a wall: infinite, for a sphere on a plane does not turn the normal. Within a hollow sphere
    it is negative, as its radius is: the normal points to its centre.
    """
    i, j = system.contacts[contact].first, system.contacts[contact].second
    place = vector(y, BODY * i)
    if j < 0:
        wall = -1 - j
        point = system.planes[wall].point
        unit = system.planes[wall].normal
        n = (unit[0], unit[1], unit[2])
        height = dot(plus(place, -1.0, (point[0], point[1], point[2])), n)
        return n, system.bodies[i].radius - height, float("inf")
    apart = plus(place, -1.0, vector(y, BODY * j))
    distance = math.copysign(length(apart), system.bodies[j].radius)
    overlap = system.bodies[i].radius + system.bodies[j].radius - distance
    return scaled(1.0 / distance, apart), overlap, distance


@compiled
def geometry(y: Floats, system: System, contact: int) -> Geometry:
    """Return how a contact stands and moves; its overlap is the one in the state."""
    i, j = system.contacts[contact].first, system.contacts[contact].second
    n, _, distance = normal_and_gap(y, system, contact)
    overlap = y[BODY * len(system.bodies) + CONTACT * contact]
    relative, spin = vector(y, BODY * i + 3), vector(y, BODY * i + 6)
    spin_j, kind = (0.0, 0.0, 0.0), system.law.velocity_lever
    if j >= 0:
        relative = plus(relative, -1.0, vector(y, BODY * j + 3))
        spin_j = vector(y, BODY * j + 6)
    turning = scaled(1.0 / distance, across(relative, n))
    frame = cross(n, turning) if system.law.turns else (0.0, 0.0, 0.0)
    if system.law.mean_spin:
        frame = plus(frame, 0.5 * dot(plus(spin, 1.0, spin_j), n), n)
    first, second = levers(system, contact, kind, overlap)
    arms = plus(scaled(first[0], spin), second[0], spin_j)
    slip = plus(across(relative, n), -1.0, cross(arms, n))
    closing = -dot(relative, n)
    share = (1.0, 0.0)
    if j < 0 and system.law.levered:
        share = levered(overlap, system.bodies[i].radius)
    return Geometry(
        n,
        turning,
        frame,
        overlap,
        closing,
        relative,
        (first[0], second[0]),
        (first[1] * closing, second[1] * closing),
        slip,
        scaled(share[0], plus(spin, -1.0, spin_j)),
        (share[0], share[1] * closing),
    )


@compiled
def levers(
    system: System, contact: int, kind: int, overlap: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return the levers of both bodies, each with its slope; a wall has none.

    ``kind`` is that between spheres.
    """
    i, j = system.contacts[contact].first, system.contacts[contact].second
    more = grown(system.law, system.contacts[contact], overlap)
    if j < 0:
        wall = system.law.wall_lever
        before = lever(wall, overlap, system.bodies[i].radius, 0.0)
        return raised(before, wall, more, 1.0), (0.0, 0.0)
    first, second = system.bodies[i].radius, system.bodies[j].radius
    return (
        raised(lever(kind, overlap, first, second), kind, more, 2.0),
        raised(lever(kind, overlap, second, first), kind, more, 2.0),
    )


class GeometryRates(NamedTuple):
    """Rates of what :class:`Geometry` holds, from the bodies' accelerations."""

    closing: float
    slip: Vector
    spin: Vector


@compiled
def geometry_rates(
    g: Geometry, y: Floats, system: System, contact: int, accelerations: Floats
) -> GeometryRates:
    """Return the rates of closing, slip and spin, the vectors in the frame of the springs.

    ``accelerations``: (bodies, 6), linear and angular.
    """
    i, j = system.contacts[contact].first, system.contacts[contact].second
    relative, spin = _part(accelerations, i, 0), _part(accelerations, i, 3)
    arms = scaled(g.levers[0], spin)
    arms = plus(arms, g.stretching[0], vector(y, BODY * i + 6))
    if j >= 0:
        relative = plus(relative, -1.0, _part(accelerations, j, 0))
        arms = plus(arms, g.levers[1], _part(accelerations, j, 3))
        arms = plus(arms, g.stretching[1], vector(y, BODY * j + 6))
        spin = plus(spin, -1.0, _part(accelerations, j, 3))
    closing = -dot(relative, g.normal) - dot(g.relative, g.turning)
    slip = plus(across(relative, g.normal), g.closing, g.turning)
    slip = plus(slip, -1.0, cross(arms, g.normal))
    slip = plus(slip, -1.0, cross(_arms(g, y, system, contact), g.turning))
    if system.law.turns:
        slip = plus(across(slip, g.normal), -1.0, across(cross(g.frame, g.slip), g.normal))
    else:  # it leaves the plane that it was in
        slip = plus(slip, -dot(g.relative, g.turning), g.normal)
    spin = plus(scaled(g.felt[0], spin), g.felt[1] / g.felt[0], g.spin)
    spin = plus(spin, -1.0, cross(g.frame, g.spin))
    return GeometryRates(closing, slip, spin)


@compiled
def _arms(g: Geometry, y: Floats, system: System, contact: int) -> Vector:
    i, j = system.contacts[contact].first, system.contacts[contact].second
    arms = scaled(g.levers[0], vector(y, BODY * i + 6))
    return plus(arms, g.levers[1], vector(y, BODY * j + 6)) if j >= 0 else arms


@compiled
def _part(values: Floats, row: int, at: int) -> Vector:
    return (values[row, at], values[row, at + 1], values[row, at + 2])


# ---- free flight, in closed form: the first root of a polynomial

NEVER = 1e300
"""[s] or a power of it."""


def next_contact(y: Floats, system: System) -> tuple[float, int]:
    """Return the time until two bodies first touch [s] and which contact it is; inf for none.

    A contact that overlaps and closes begins at once.
    """
    times = [(_time_to(y, system, c), c) for c in range(len(system.contacts))]
    return min(times, default=(math.inf, -1))


def flown(y: Floats, system: System, time: float) -> Floats:
    """Return the state after a flight: parabolas and steady rotation."""
    result = y.copy()
    for b in range(len(system.bodies)):
        at = BODY * b
        velocity, gravity = y[at + 3 : at + 6], system.bodies[b]["gravity"]
        result[at : at + 3] += velocity * time + 0.5 * gravity * time**2
        result[at + 3 : at + 6] += gravity * time
    return result


def _time_to(y: Floats, system: System, contact: int) -> float:
    i, j = system.contacts[contact]["first"], system.contacts[contact]["second"]
    place, velocity = y[BODY * i : BODY * i + 3], y[BODY * i + 3 : BODY * i + 6]
    gravity = system.bodies[i]["gravity"]
    if j < 0:
        n = system.planes[-1 - j]["normal"]
        gap = (place - system.planes[-1 - j]["point"]) @ n - system.bodies[i]["radius"]
        return _first_fall([0.5 * gravity @ n, velocity @ n, gap])
    apart = place - y[BODY * j : BODY * j + 3]
    velocity = velocity - y[BODY * j + 3 : BODY * j + 6]
    gravity = gravity - system.bodies[j]["gravity"]
    reach = system.bodies[i]["radius"] + system.bodies[j]["radius"]
    distance = float(np.sqrt(apart @ apart))
    outside = math.copysign(1.0, reach)  # within a hollow sphere the distance grows up to it
    return _first_fall(
        [
            outside * 0.25 * gravity @ gravity,
            outside * gravity @ velocity,
            outside * (velocity @ velocity + gravity @ apart),
            outside * 2.0 * float(velocity @ apart),
            outside * (distance - reach) * (distance + reach),
        ]
    )


def _first_fall(polynomial: list[float]) -> float:
    """Return the first time from 0 on at which a polynomial falls through 0; inf for none."""
    coefficients = np.trim_zeros(np.array(polynomial, dtype=float), "f")
    # a factor so small has its root beyond any time, and overflows on the way there
    while len(coefficients) > 1 and abs(coefficients[0]) * NEVER < np.abs(coefficients[1:]).max():
        coefficients = coefficients[1:]
    slopes = np.polyder(coefficients) if len(coefficients) > 1 else np.zeros(1)
    if polynomial[-1] <= 0.0 and _falls_at_once(polynomial):
        return 0.0
    if len(coefficients) < 2:
        return math.inf
    roots = np.roots(coefficients)
    real = np.sort(roots[np.abs(roots.imag) <= 1e-7 * np.abs(roots)].real)
    for root in real[real > 0.0]:
        if np.polyval(slopes, root) < 0.0:
            return float(root - np.polyval(coefficients, root) / np.polyval(slopes, root))
    return math.inf


def _falls_at_once(polynomial: list[float]) -> bool:
    """Return whether the first derivative that is not 0 at time 0 is negative."""
    moving = [c for c in reversed(polynomial[:-1]) if c != 0.0]
    return bool(moving) and moving[0] < 0.0
