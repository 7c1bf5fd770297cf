"""How far round-off may move a run: that of coordinates, and that of mdr's force.

Each step rounds positions and velocities. mdr's force of a flat at the depth d, in an ellipse of
axes A and B, E' A B / 4 (theta - sin theta cos theta), cos theta = 1 - 2 d / A, is a difference in
which digits are lost, more of them the smaller d. As codes write it, acos(1 - y) - (1 - y) sqrt(2 y
- y^2), y = 2 d / A: 1 - y is rounded by eps / 4, which acos multiplies by 1 / sin theta, at most
pi / (2 theta); what else is rounded is theta at most, eight times by eps / 2. The difference is off
by eps (1 / (2 theta) + 4 theta) at most, and by sqrt(eps) where 1 - y is rounded to 1.

What that leaves of a motion follows from the overlaps that an engine goes through: at each step a
push of that error, carried on by the law made linear about them, their absolute values added up.
Friction takes mu of it along the surface, 5/2 of that over the radius in a spin. Two runs differ
by twice the sum. Where it yields, a sphere that is pressed in has no such difference, one that
springs back that of its own ellipse; of the bulk, the ellipse keeps the depth of its first step.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from harness.cases.contact_base.motion import Array
from harness.pair.flat import pressed
from harness.pair.plastic import ELASTIC, PLASTIC, SWELLING, sprung_back
from harness.pair.records import System
from harness.pair.system import system_of
from harness.pair.vectors import compiled
from harness.parameters.contact_rules import Rules
from harness.parameters.contact_scene import ContactScene

EPS = float(np.finfo(float).eps)

FORCES = 8.0
"""Roundings of a force besides, each of eps of itself, at most."""


@compiled
def lost(theta: float) -> float:
    """Return by how much theta - sin theta cos theta is off at most, as codes write it."""
    most = math.sqrt(EPS)
    return most if theta <= 0.0 else min(most, EPS * (0.5 / theta + 4.0 * theta))


def of_force(
    scene: ContactScene, rules: Rules, overlaps: Array, sizes: Mapping[str, float], slack: float
) -> float:
    """Return the part of the sizes by which two runs of mdr may differ for its force's round-off.

    ``overlaps`` (M,) [m] are those of every step, each off by ``slack`` [m] at most.
    """
    system = system_of(scene, rules)
    h, mass = scene.step, float(system.contacts[0]["mass"])
    errors, slopes = _errors(system, overlaps, slack)
    pushes = np.flatnonzero(errors)
    x, v = np.zeros(len(pushes)), np.zeros(len(pushes))
    worst, begun = 0.0, 0
    for k in range(len(overlaps)):
        x += h * v
        v -= h / mass * slopes[k] * x
        if errors[k] > 0.0:
            v[begun] += h / mass * errors[k]
            begun += 1
        away, fast = float(np.abs(x).sum()), float(np.abs(v).sum())
        worst = max(
            worst,
            away / sizes["position"],
            fast / sizes["velocity"],
            (errors[k] + slopes[k] * away) / sizes["force"],
        )
    return 2.0 * (1.0 + 3.5 * (scene.law.friction or 0.0)) * worst


@compiled
def _errors(system: System, overlaps: Array, slack: float) -> tuple[Array, Array]:
    """Return by how much the force is off at each overlap [N], at most, and its slope [N/m]."""
    law, contact = system.law, system.contacts[0]
    flats = 1.0 if contact.second < 0 else 2.0
    first, largest = 0.0, 0.0
    errors, slopes = np.zeros(len(overlaps)), np.zeros(len(overlaps))
    for k in range(len(overlaps)):
        overlap = overlaps[k]
        if overlap + slack <= contact.last:
            continue
        if first == 0.0:
            first = max(overlap, 0.0)
        opens = overlap < largest
        largest = max(largest, overlap)
        _follow(system, largest, flats, opens)
        found = pressed(law, contact, overlap)
        depth = min(overlap, first) if law.bulk else overlap
        errors[k] = FORCES * EPS * abs(found.force)
        errors[k] += _of_ellipse(system, depth - slack, flats, opens)
        slopes[k] = found.slope
    return errors, slopes


@compiled
def _follow(system: System, largest: float, flats: float, opens: bool) -> None:
    """Tell the contact how far it has been pressed in [m], and whether it opens."""
    law, contact = system.law, system.contacts[0]
    depth = largest / flats
    contact.stage = ELASTIC
    if law.yields and depth > contact.onset:
        contact.stage = SWELLING if depth > contact.swells else PLASTIC
        contact.last = flats * sprung_back(law, contact, depth, contact.first_radius).left
    contact.largest = largest if opens else 0.0


@compiled
def _of_ellipse(system: System, overlap: float, flats: float, opens: bool) -> float:
    """Return by how much the force of the ellipse is off at an overlap [m], at most [N]."""
    law, contact = system.law, system.contacts[0]
    modulus = 2.0 * law.stiffness
    if contact.stage != ELASTIC:
        if not opens:
            return 0.0
        dent = sprung_back(law, contact, contact.largest / flats, contact.first_radius)
        depth = (overlap / flats - dent.left) * dent.stretch
        return float(0.25 * modulus * dent.height * dent.width * lost(_angle(depth / dent.height)))
    one, other = contact.first_radius, contact.second_radius
    most = max(contact.largest, overlap)
    share = 1.0 if flats < 2.0 else 0.5 * (2.0 * other - most) / (one + other - most)
    sides = one**2 * lost(_angle(0.25 * share * overlap / one))
    if flats < 2.0:
        return float(2.0 * modulus * sides)
    sides += other**2 * lost(_angle(0.25 * (1.0 - share) * overlap / other))
    return float(modulus * sides)


@compiled
def _angle(part: float) -> float:
    return 2.0 * math.asin(math.sqrt(min(1.0, part))) if part > 0.0 else 0.0
