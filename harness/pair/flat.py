"""A sphere on a rigid flat by mdr, in the branches that are not elastic alone.

Two equal spheres meet a flat between them, each at half the overlap; a wall is one. Zunker and
Kamrin, J. Mech. Phys. Solids 183, 105492 and 105493 (2024), with E' = E / (1 - nu^2), the depth
delta of the flat, and by the method of dimensionality reduction an ellipse of the half axes A/2
along the motion and B/2 across that sinks into springs, E' for each length:

    cos theta = 1 - 2 delta_e / A,   a = B/2 sin theta,
    F = E' A B / 4 (theta - sin theta cos theta)

elastic: A = 4 R, B = 2 R, delta_e = delta. Yield: :mod:`harness.pair.plastic`. Adhesion, of the
energy gamma of sphere and flat: as the contact opens, springs hold on until they are longer by
l(a) = sqrt(2 pi a gamma / E'), those at the edge first: with the depth g(a) = A/2 (1 - cos theta)

    F = E' A B / 4 (theta - sin theta cos theta) - 2 E' a l(a),   delta = g(a) - l(a),

which is JKR for small a / R, down to the a below which delta grows again; before, a stays that of
the largest depth. Bulk response, of one contact: the mean displacement of its surface is delta, so
that nothing is left to the ellipse; a pressure of the bulk modulus K times the volume
displaced, A_c delta, over that of the sphere without its cap acts on the area A_c = pi R delta:

    F = K A_c^2 delta / (4/3 pi R^3 - pi/3 delta^2 (3 R - delta)).
"""

from __future__ import annotations

import math

from harness.pair.normal import MAGNIFIED, MDR, Elastic, at_flat, between, elastic, segment
from harness.pair.plastic import PLASTIC, loaded, sprung_back
from harness.pair.records import Records
from harness.pair.vectors import compiled


@compiled
def remembers(law: Records, contact: Records) -> bool:
    """Return whether a contact that does not yield opens along another curve than it closed."""
    uneven = contact.first_radius != contact.second_radius
    return bool(law.normal == MDR and (uneven or law.surface > 0.0))


@compiled
def pressed(law: Records, contact: Records, overlap: float) -> Elastic:
    """Return the elastic normal force of a contact at an overlap [m], of any law."""
    wall = contact.second < 0
    if law.normal != MDR or not (law.bulk or law.yields or law.surface > 0.0):
        if law.normal == MDR and wall:
            return at_flat(law.stiffness, contact.curvature, overlap, law.wall_magnified)
        if remembers(law, contact):
            radii = (contact.first_radius, contact.second_radius)
            return between(law.stiffness, radii, overlap, contact.largest)
        stiffness = law.stiffness * contact.factor
        return elastic(law.normal, stiffness, law.surface, contact.curvature, overlap)
    share = 1.0 if wall else 0.5
    radius = contact.curvature / share
    bare = _on_flat(law, contact, share * overlap, share * contact.largest, radius)
    more, rise = 0.0, 0.0
    if wall and law.wall_magnified:
        more = math.exp(MAGNIFIED[0] * overlap / radius + MAGNIFIED[1])
        rise = more * MAGNIFIED[0] / radius
    slope = share * (1.0 + more) * bare.slope + rise * bare.force
    return Elastic((1.0 + more) * bare.force, slope, bare.radius, share * bare.growth)


@compiled
def _on_flat(
    law: Records, contact: Records, depth: float, largest: float, radius: float
) -> Elastic:
    modulus = 2.0 * law.stiffness
    if law.surface > 0.0:
        if depth < largest:
            return held(modulus, law.surface, radius, contact.least, depth, largest)
        return ellipse(modulus, 4.0 * radius, 2.0 * radius, depth)
    if depth <= 0.0:
        return Elastic(0.0, 0.0, 0.0, 0.0)
    if law.bulk:
        return _bulk(law.bulk_modulus, radius, depth)
    if contact.stage < PLASTIC:
        return ellipse(modulus, 4.0 * radius, 2.0 * radius, depth)
    if depth < largest:
        dent = sprung_back(law, contact, largest, radius)
        bare = ellipse(modulus, dent.height, dent.width, (depth - dent.left) * dent.stretch)
        return Elastic(
            bare.force, dent.stretch * bare.slope, bare.radius, dent.stretch * bare.growth
        )
    return loaded(law, contact, depth, radius)


@compiled
def ellipse(modulus: float, height: float, width: float, depth: float) -> Elastic:
    """Return force and slope of springs, E' for a length, under an ellipse of axes A and B."""
    if depth <= 0.0:
        return Elastic(0.0, 0.0, 0.0, 0.0)
    theta = 2.0 * math.asin(math.sqrt(min(1.0, depth / height)))
    a = 0.5 * width * math.sin(theta)
    growth = 2.0 * math.cos(theta) / (height * math.sin(theta) ** 2)
    force = 0.125 * modulus * height * width * segment(2.0 * theta)
    return Elastic(force, 2.0 * modulus * a, a, growth)


@compiled
def _bulk(bulk_modulus: float, radius: float, depth: float) -> Elastic:
    area = math.pi * radius * depth
    cap = math.pi / 3.0 * depth**2 * (3.0 * radius - depth)
    volume = 4.0 / 3.0 * math.pi * radius**3 - cap
    force = bulk_modulus * area**2 * depth / volume
    slope = force * (3.0 / depth + math.pi * depth * (2.0 * radius - depth) / volume)
    return Elastic(force, slope, math.sqrt(radius * depth), 0.5 / depth)


@compiled
def sunk(modulus: float, surface: float, radius: float, a: float) -> tuple[float, float, float]:
    """Return g(a), l(a) and d(g - l)/da of an elastic sphere on a flat."""
    root = math.sqrt((radius - a) * (radius + a))
    length = math.sqrt(2.0 * math.pi * a * surface / modulus)
    return 2.0 * a * a / (radius + root), length, 2.0 * a / root - 0.5 * length / a


@compiled
def fold(modulus: float, surface: float, radius: float) -> tuple[float, float]:
    """Return the contact radius below which the depth grows again, and the depth there [m]."""
    if surface <= 0.0:
        return 0.0, 0.0
    low, high = 0.0, radius
    for _ in range(200):
        a = 0.5 * (low + high)
        if a in (low, high):
            break
        if sunk(modulus, surface, radius, a)[2] < 0.0:
            low = a
        else:
            high = a
    g, length, _ = sunk(modulus, surface, radius, high)
    return high, g - length


@compiled
def held(
    modulus: float, surface: float, radius: float, least: float, depth: float, largest: float
) -> Elastic:
    """Return the force of a contact that opens and sticks, from the largest depth on.

    ``least`` is the contact radius of :func:`fold`.
    """
    a = math.sqrt(max(0.0, largest * (radius - 0.25 * largest)))
    g, length, rate = sunk(modulus, surface, radius, a)
    if a <= least or depth >= g - length:
        force = ellipse(modulus, 4.0 * radius, 2.0 * radius, g).force
        return Elastic(force + 2.0 * modulus * a * (depth - g), 2.0 * modulus * a, a, 0.0)
    for _ in range(100):  # from above, where g - l rises and is convex, down to the root
        change = (g - length - depth) / rate
        a = max(a - change, least)
        g, length, rate = sunk(modulus, surface, radius, a)
        if change <= 4e-16 * a or a == least:
            break
    rate = max(rate, 1e-12 * a / radius)
    force = ellipse(modulus, 4.0 * radius, 2.0 * radius, g).force - 2.0 * modulus * a * length
    slope = 2.0 * modulus * (a * rate - length) / rate
    return Elastic(force, slope, a, 1.0 / (a * rate))
