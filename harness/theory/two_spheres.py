"""A linear elastic contact of two spheres, in closed form.

The source calls this case without analytical solution; it is a half-wave.
"""

from __future__ import annotations

import math


def contact_time(mass: float, stiffness: float) -> float:
    """Return how long two free equal spheres touch [s], ``pi / sqrt(2) sqrt(m/k)``."""
    return math.pi * math.sqrt(mass / (2 * stiffness))


def peak_overlap(mass: float, stiffness: float, speed: float) -> float:
    """Return the largest overlap of two free equal spheres [m], ``v sqrt(m / 2k)``."""
    return speed * math.sqrt(mass / (2 * stiffness))


def contact_time_on_fixed(mass: float, stiffness: float, speed: float, gravity: float) -> float:
    """Return t0, how long a grain under gravity touches one fixed particle [s].

    ``(2/omega) (pi - atan(v0 omega / g))`` with ``omega = sqrt(k/m)``.
    """
    omega = math.sqrt(stiffness / mass)
    return 2 / omega * (math.pi - math.atan2(speed * omega, gravity))


def impulse_on_fixed(mass: float, stiffness: float, speed: float, gravity: float) -> float:
    """Return the impulse of that contact on the grain [N s], ``2 m v0 + m g t0``."""
    t0 = contact_time_on_fixed(mass, stiffness, speed, gravity)
    return 2 * mass * speed + mass * gravity * t0


def peak_force_on_fixed(mass: float, stiffness: float, speed: float, gravity: float) -> float:
    """Return the largest force of that contact [N], ``m g + sqrt((m g)^2 + k m v0^2)``."""
    weight = mass * gravity
    return weight + math.sqrt(weight**2 + stiffness * mass * speed**2)
