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


def velocities_after(mass: tuple[float, float], speed: float) -> tuple[float, float]:
    """Return the velocities after a free elastic collision with a sphere at rest [m/s]."""
    first, second = mass
    total = first + second
    return (first - second) / total * speed, 2 * first / total * speed


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


def displacement_on_fixed(
    mass: float, stiffness: float, speed: float, gravity: float, time: float
) -> float:
    """Return how far the grain has moved after ``time`` [s] of that contact [m]."""
    omega = math.sqrt(stiffness / mass)
    rest = gravity / omega**2
    return rest * (1 - math.cos(omega * time)) + speed / omega * math.sin(omega * time)
