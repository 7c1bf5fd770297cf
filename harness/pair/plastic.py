"""mdr's yield of a sphere on a rigid flat: how it is pressed in, swells and springs back.

Zunker and Kamrin, J. Mech. Phys. Solids 183, 105492 (2024). With the flat at the distance d from
the centre, the depth delta = R - d and the yield stress Y, the mean pressure is at most

    p = Y (1 + 1.75 exp(-4.4 delta / R)),

which Hertz's, 4 E' / (3 pi) sqrt(delta / R), reaches at delta_Y. From there on F = p pi a^2 with
a^2 = 2 R delta - delta^2 - delta_Y (R_0 - delta_Y), which begins with Hertz's a^2 = R_0 delta_Y.

Plastic flow keeps the volume: the apparent radius R swells by what the flat displaces,

    4/3 pi R^3 - pi/3 delta^2 (3 R - delta) - V_0 e = constant,   e (1 + e) = -F d / (3 K V_0),

V_0 = 4/3 pi R_0^3, where e is the mean elastic strain of the volume; it does not shrink, so that
at first, while e falls faster, it is R_0. Both are functions of d alone as long as d falls.

It springs back elastically by A/2 - u: A/2 = 2 p a / E' is how far a uniform pressure p on the
circle of radius a moves the surface in its middle, u by how much it moves the centre of the sphere,
z = R - delta + A/2 below (Boussinesq),

    u = p / (2 G s) (2 (1 - nu) a^2 - (1 - 2 nu) z (s - z)),   s^2 = a^2 + z^2:

as an ellipse of the axes A and B = 2 a, which is at A/2 at the largest depth and comes to 0 there.

A sphere that has swollen is that large: friction has its radius as the lever, and it turns with the
moment of inertia 2/5 m R^2 (:func:`grown`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from harness.pair.normal import Elastic
from harness.pair.records import Records
from harness.pair.vectors import compiled

ELASTIC, PLASTIC, SWELLING = range(3)
"""Stages of a contact that is pressed in."""

NEVER = 1e300
"""[m] of a depth that is not reached."""


class Dent(NamedTuple):
    """What a plastic contact springs back by: its ellipse, and the depth that is left [m].

    The ellipse is at ``stretch`` times the depth less what is left.
    """

    height: float
    width: float
    left: float
    stretch: float


class Pressed(NamedTuple):
    """The force of yield [N] at a depth, its slopes at a fixed radius and with the radius."""

    force: float
    slope: float
    by_radius: float  # at a fixed distance of the flat
    square: float  # a^2 [m2]
    pressure: float


@compiled
def _pressed(stress: float, onset: float, first: float, depth: float, radius: float) -> Pressed:
    soft = 1.75 * stress * math.exp(-4.4 * depth / radius)
    p, falls = stress + soft, -4.4 * soft / radius
    square = depth * (2.0 * radius - depth) - onset * (first - onset)
    slope = math.pi * (2.0 * (radius - depth) * p + square * falls)
    by_radius = math.pi * (2.0 * depth * p - square * falls * depth / radius)
    return Pressed(math.pi * square * p, slope, slope + by_radius, square, p)


@compiled
def _kept(
    law: Records, onset: float, radius: float, depth: float, swelling: float
) -> tuple[float, float, float]:
    """Return what volume is kept [m3], and its slopes with the flat's way and with the swelling.

    Less that of the sphere; ``depth`` is that of the flat in the sphere as it was.
    """
    now, away = radius + swelling, radius - depth
    real = depth + swelling
    one = _pressed(law.yield_stress, onset, radius, real, now)
    sphere = 4.0 / 3.0 * math.pi * radius**3
    share = 1.0 / (3.0 * law.bulk_modulus)
    root = math.sqrt(1.0 - 4.0 * share * one.force * away / sphere)
    strained = -2.0 * share * one.force * away / (1.0 + root)  # V_0 e
    more = 4.0 / 3.0 * math.pi * swelling * (3.0 * radius * (radius + swelling) + swelling**2)
    cap = math.pi / 3.0 * real**2 * (3.0 * now - real)
    by_way = -math.pi * (now - away) * (now + away) + share * (one.slope * away - one.force) / root
    by_swelling = 2.0 * math.pi * now * (2.0 * now - real) + share * one.by_radius * away / root
    return more - cap - strained, by_way, by_swelling


@compiled
def yield_depth(modulus: float, stress: float, radius: float) -> float:
    """Return delta_Y [m] of E' [Pa], Y [Pa] and R_0 [m]; NEVER where it is beyond the radius."""
    low, high = 0.0, radius
    for _ in range(300):
        depth = 0.5 * (low + high)
        if depth in (low, high):
            break
        hertz = 4.0 * modulus / (3.0 * math.pi) * math.sqrt(depth / radius)
        if hertz < _pressed(stress, 0.0, 0.0, depth, radius).pressure:
            low = depth
        else:
            high = depth
    return high if high < radius else NEVER


@compiled
def swelling_depth(law: Records, onset: float, radius: float) -> float:
    """Return the depth [m] from which on the radius swells; NEVER where it is beyond the radius."""
    if onset >= radius or _kept(law, onset, radius, onset, 0.0)[1] < 0.0:
        return onset
    low, high = onset, radius
    for _ in range(300):
        depth = 0.5 * (low + high)
        if depth in (low, high):
            break
        if _kept(law, onset, radius, depth, 0.0)[1] > 0.0:
            low = depth
        else:
            high = depth
    return high if high < radius else NEVER


@compiled
def swelling(law: Records, contact: Records, depth: float, radius: float) -> tuple[float, float]:
    """Return R - R_0 [m] at a depth in the sphere as it was, and its slope."""
    onset = contact.onset
    if depth <= contact.swells:
        return 0.0, 0.0
    kept = _kept(law, onset, radius, contact.swells, 0.0)[0]
    grown = 0.0
    for _ in range(50):
        now, by_way, by_swelling = _kept(law, onset, radius, depth, grown)
        change = (now - kept) / by_swelling
        grown -= change
        if abs(change) <= 4e-16 * depth:
            break
    return grown, -by_way / by_swelling


@compiled
def next_stage(contact: Records) -> float:
    """Return the overlap [m] at which a contact that closes yields, or swells."""
    flats = 1.0 if contact.second < 0 else 2.0
    if contact.stage == ELASTIC:
        return float(flats * contact.onset)
    return float(flats * contact.swells) if contact.stage == PLASTIC else NEVER


@compiled
def loaded(law: Records, contact: Records, depth: float, radius: float) -> Elastic:
    """Return the force of a contact that yields, pressed in further than ever."""
    grown, rate = swelling(law, contact, depth, radius)
    if contact.stage < SWELLING:
        grown, rate = 0.0, 0.0
    one = _pressed(law.yield_stress, contact.onset, radius, depth + grown, radius + grown)
    slope = one.slope + rate * one.by_radius
    flat = radius - depth  # of the flat from the centre, which stays as the radius grows
    widens = (flat * (1.0 + rate) + (depth + grown) * rate) / one.square  # d(ln a)/d(depth)
    return Elastic(one.force, slope, math.sqrt(one.square), widens)


@compiled
def grown(law: Records, contact: Records, overlap: float) -> tuple[float, float]:
    """Return by how much the radius of a sphere in a contact has grown [m], d(that)/d(overlap).

    ``overlap`` [m] is that of the spheres as they were.
    """
    if not law.yields or contact.stage < SWELLING:
        return 0.0, 0.0
    flats = 1.0 if contact.second < 0 else 2.0
    most = max(overlap, contact.largest)
    more, rate = swelling(law, contact, most / flats, contact.first_radius)
    return more, rate / flats if overlap >= contact.largest else 0.0


@compiled
def sprung_back(law: Records, contact: Records, largest: float, radius: float) -> Dent:
    """Return how a contact springs back from its largest depth in the sphere as it was."""
    grown, _ = swelling(law, contact, largest, radius)
    now, depth = radius + grown, largest + grown
    one = _pressed(law.yield_stress, contact.onset, radius, depth, now)
    a2, a, p = one.square, math.sqrt(one.square), one.pressure
    middle = p * a / law.stiffness  # 2 p a / E'
    z = now - depth + middle
    s = math.sqrt(a2 + z * z)
    along = 2.0 * (1.0 - law.poisson) * a2 - (1.0 - 2.0 * law.poisson) * z * (s - z)
    u = p / (2.0 * law.shear_modulus * s) * along
    return Dent(2.0 * middle, 2.0 * a, largest - (middle - u), 1.0 / (1.0 - u / middle))
