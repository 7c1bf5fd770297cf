"""The oblique impact of spheres with friction: where it slides throughout, and where it sticks.

u is the tangential velocity at the contact, v the normal speed; a tangential impulse J changes u
by 7/2 J / m* of solid spheres, of any two masses and of a sphere on a wall alike.
"""

from __future__ import annotations

import math

from harness.theory import dashpot


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


def slides_throughout_elastic(friction: float, stiffness_ratio: float) -> float:
    """Return u / v from which on an elastic contact without damping slides to its end.

    A slider at its limit recovers with the spring as it opens, as long as u > -mu v k_n / k_t:
    7 mu - mu k_n / k_t, psi = 4 chi - 1 of Maw, Barber and Fawcett. With the limit of
    :func:`sticks_at_first` where that is larger.
    """
    recovery = sticks_at_first(friction, stiffness_ratio)
    return max(slides_throughout(friction, 1.0) - recovery, recovery)


def sticking_restitution(stiffness_ratio: float, damping_ratio: float, *, clipped: bool) -> float:
    """Return -u'/u of linear springs, mu so large that they stick, without tangential dashpot.

    u oscillates with omega_t^2 = 7/2 k_t / m*. The limit mu |N| vanishes with the normal force, at
    omega t = 2 acos(zeta) / sqrt(1 - zeta^2), whatever mu: the spring is cut back to nothing and
    starts anew for the attractive tail, if there is one. Hence -cos(omega_t t_1) cos(omega_t t_2)
    with t_1 until then and t_2 from then on; one cosine, of the whole contact, without damping.
    """
    shear = math.sqrt(3.5 * stiffness_ratio)
    repelled = dashpot.duration_clipped(damping_ratio)
    whole = math.pi / math.sqrt(1.0 - damping_ratio**2)
    tail = 0.0 if clipped else whole - repelled
    return -math.cos(shear * repelled) * math.cos(shear * tail)
