"""Where two bodies touch and how they move against each other there."""

from __future__ import annotations

from typing import NamedTuple

from harness.pair.lever import lever, levered, raised
from harness.pair.plastic import grown
from harness.pair.records import BODY, CONTACT, Floats, System
from harness.pair.vectors import Vector, across, compiled, cross, dot, length, plus, scaled


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

    At a wall: infinite, for a sphere on a plane does not turn the normal.
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
    distance = length(apart)
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
        found = lever(wall, overlap, system.bodies[i].radius, 0.0)
        return raised(found, wall, more, 1.0), (0.0, 0.0)
    first, second = system.bodies[i].radius, system.bodies[j].radius
    return (
        raised(lever(kind, overlap, first, second), kind, more, 2.0),
        raised(lever(kind, overlap, second, first), kind, more, 2.0),
    )


class Change(NamedTuple):
    """Rates of what :class:`Geometry` holds, from the bodies' accelerations."""

    closing: float
    slip: Vector
    spin: Vector


@compiled
def change(g: Geometry, y: Floats, system: System, contact: int, accelerations: Floats) -> Change:
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
    return Change(closing, slip, spin)


@compiled
def _arms(g: Geometry, y: Floats, system: System, contact: int) -> Vector:
    i, j = system.contacts[contact].first, system.contacts[contact].second
    arms = scaled(g.levers[0], vector(y, BODY * i + 6))
    return plus(arms, g.levers[1], vector(y, BODY * j + 6)) if j >= 0 else arms


@compiled
def _part(values: Floats, row: int, at: int) -> Vector:
    return (values[row, at], values[row, at + 1], values[row, at + 2])
