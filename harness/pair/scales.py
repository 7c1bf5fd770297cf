"""What is small in a contact system: the units in which its errors are measured."""

from __future__ import annotations

import math

import numpy as np

from harness.pair.friction import normal_force
from harness.pair.geometry import geometry
from harness.pair.normal import HOOKE, JKR, last_overlap, pull_off_force
from harness.pair.rates import OPEN, SIGN, SLIDERS, STATE, place_of
from harness.pair.records import BODY, CONTACT, Floats, Integers, System
from harness.pair.slider import SLIDE
from harness.pair.vectors import compiled, length


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
        result[at + 6 : at + 9] = speed / system.bodies[b].radius
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
