"""The oblique impact of spheres with friction: where it slides throughout, and where it sticks.

u is the tangential velocity at the contact, v the normal speed; a tangential impulse J changes u
by 7/2 J / m* of solid spheres, of any two masses and of a sphere on a wall alike.
"""

from __future__ import annotations


def sliding_impulse(friction: float, restitution: float, speed: float) -> float:
    """Return the tangential impulse over m* [m/s] of an impact that slides: mu (1 + e) v.

    A sphere on a wall loses that much tangential velocity, and 5/2 of it is its change of r omega.
    """
    return friction * (1.0 + restitution) * speed


def slides_throughout(friction: float, restitution: float) -> float:
    """Return u / v from which on a rigid contact slides to its end: 7/2 mu (1 + e)."""
    return 3.5 * friction * (1.0 + restitution)


def sticks_at_first(friction: float, stiffness_ratio: float) -> float:
    """Return u / v up to which an elastic contact begins sticking: mu k_n / k_t.

    The ratio k_t / k_n is of stiffnesses at one overlap: 4 G* / E* for Hertz and increments of
    Mindlin's force, 2 (1 - nu) / (2 - nu) of like materials, which is psi = 1 in Maw, Barber and
    Fawcett, Wear 38, 101 (1976). Mindlin on the total displacement has 2/3 of it.
    """
    return friction / stiffness_ratio
