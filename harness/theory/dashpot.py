"""The linear spring-dashpot contact in closed form: its restitution and its duration.

m x'' + 2 zeta omega m x' + omega^2 m x = 0 from x = 0 at speed 1. With the
attractive tail kept the contact ends when x returns to 0; clipped, it ends
when the force k x + eta x' does (Schwager and Poeschel, Granular Matter 9,
465 (2007)).
"""

from __future__ import annotations

import math


def damping_ratio(restitution: float) -> float:
    """Return zeta = |ln e| / sqrt(pi^2 + ln^2 e), the inverse of the unclipped restitution.

    Restitution 0 gives 1, critical damping.
    """
    if restitution == 0.0:
        return 1.0
    logarithm = math.log(restitution)
    return -logarithm / math.hypot(math.pi, logarithm)


def restitution_unclipped(zeta: float) -> float:
    """Return exp(-pi zeta / sqrt(1 - zeta^2)); 0 from critical damping on."""
    if zeta >= 1.0:
        return 0.0
    return math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta * zeta))


def restitution_clipped(zeta: float) -> float:
    """Return exp(-2 zeta omega t) / ... at the time the force vanishes: exp(-zeta omega t_end).

    The duration follows from :func:`duration_clipped`; at critical damping the
    result is exp(-2) = 0.135, which is why a clipped contact always rebounds.
    """
    return math.exp(-zeta * duration_clipped(zeta))


def duration_clipped(zeta: float) -> float:
    """Return omega t_end [-] of the clipped contact: when x'' first returns to 0."""
    if zeta == 1.0:
        return 2.0
    if zeta < 1.0:
        root = math.sqrt(1.0 - zeta * zeta)
        return 2.0 * math.acos(zeta) / root
    root = math.sqrt(zeta * zeta - 1.0)
    return 2.0 * math.acosh(zeta) / root


def duration_unclipped(zeta: float) -> float:
    """Return omega t_end [-] of a contact with its attractive tail, x = 0 again; zeta below 1."""
    return math.pi / math.sqrt(1.0 - zeta * zeta)


def largest_overlap(zeta: float) -> float:
    """Return omega x / v [-] where x' = 0; zeta below 1.

    x = exp(-zeta omega t) sin(root omega t) / root, root^2 = 1 - zeta^2, turns where
    tan(root omega t) = root / zeta, half the time of :func:`duration_clipped`.
    """
    return math.exp(-0.5 * zeta * duration_clipped(zeta))
