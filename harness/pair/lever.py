"""How far from a sphere's centre a contact takes place: the lever of its force, and of omega."""

from __future__ import annotations

from harness.pair.vectors import compiled

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
    found: tuple[float, float], kind: int, grown: tuple[float, float], spheres: float
) -> tuple[float, float]:
    """Return a lever and its slope where each of one or two ``spheres`` has grown by as much [m].

    ``found`` is that of radius and overlap as they were, ``grown`` has its slope with that overlap,
    too. Both grow, the place of the contact and the centres stay.
    """
    share = 0.0
    if kind == RADIUS:
        share = 1.0
    elif kind == CONTACT_POINT:
        share = 1.0 - 0.5 * spheres
    return found[0] + share * grown[0], found[1] + share * grown[1]


@compiled
def levered(overlap: float, radius: float) -> tuple[float, float]:
    """Return the lever of a contact point over the height of the centre, and its slope [1/m].

    For a sphere on a wall: (r - overlap/2) / (r - overlap).
    """
    height = radius - overlap
    return (radius - 0.5 * overlap) / height, 0.5 * radius / height**2
