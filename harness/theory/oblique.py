"""The oblique impact of spheres with friction: where it slides throughout, and where it sticks.

u is the tangential velocity at the contact, v the normal speed; a tangential impulse J changes u
by 7/2 J / m* of solid spheres, of any two masses and of a sphere on a wall alike.
"""

from __future__ import annotations

import cmath
import math


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


def held(stiffness: float, dashpot: float, duration: float) -> float:
    """Return the tangential velocity at a contact that sticks throughout, after over before.

    ``stiffness`` 7/2 k_t / m* [1/s2] of the spring and ``dashpot`` 7/2 eta_t / m* [1/s], either of
    which may be 0: u'' + dashpot u' + stiffness u = 0 from a spring at rest, over the ``duration``
    [s] of the contact. Without a dashpot the cosine of Walton, in Particulate Two-Phase Flow
    (1993), and of Schaefer, Dippel and Wolf, J. Phys. I France 6, 5 (1996).
    """
    half = 0.5 * dashpot
    turning = cmath.sqrt(stiffness - half * half)
    phase = turning * duration
    swings = cmath.sin(phase) / turning if turning else duration
    return math.exp(-half * duration) * (cmath.cos(phase) - half * swings).real


def two_branches(incidence: float, friction: float, restitution: float, sticking: float) -> float:
    """Return the tangential velocity at the contact after over before, sticking or sliding.

    An impact that sticks leaves ``sticking``, one that slides 1 - 7/2 mu (1 + e) v / u; the impulse
    is the lesser of both (Walton 1993; Foerster, Louge, Chang and Allia, Phys. Fluids 6, 1108
    (1994)). ``incidence`` is u / v, above 0.
    """
    return max(sticking, 1.0 - slides_throughout(friction, restitution) / incidence)
