"""The linear spring-dashpot contact in closed form: its restitution and its duration.

m x'' + 2 zeta omega m x' + omega^2 m x = 0 from x = 0 at speed 1. With the
attractive tail kept the contact ends when x returns to 0; clipped, it ends
when the force k x + eta x' does (Schwager and Poeschel, Granular Matter 9,
465 (2007)).
"""

from __future__ import annotations

import math

import numpy as np

PHASES = 400
"""Places within a step at which a contact is taken to begin."""

MOST_STEPS = 1000.0
"""Steps per contact time above which the restitution is that of the closed form, to 0.2 %."""

LONGEST = 10.0
"""Contact times pi / omega after which a grain that has not left creeps, and does not rebound."""


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


def restitution_in_steps(zeta: float, steps: float, *, clipped: bool) -> float:
    """Return the greatest restitution that the contact has at so many steps per pi / omega.

    v+ = v + h a(x, v), x+ = x + h v+, the recurrence of velocity Verlet in the velocities of half
    steps and of semi-implicit Euler. A step sees the contact only where there is overlap, so the
    restitution depends on where within a step the contact begins: this is the greatest over
    ``PHASES`` places, and not less than that of the closed form.
    """
    exact = (restitution_clipped if clipped else restitution_unclipped)(zeta)
    if steps > MOST_STEPS:
        return exact
    h = math.pi / steps
    x = h * (np.arange(PHASES) + 0.5) / PHASES  # the overlap in the first step that sees it
    v = np.ones(PHASES)
    touching = x > 0.0
    for _ in range(math.ceil(LONGEST * steps)):
        force = x + 2.0 * zeta * v
        force = np.maximum(force, 0.0) if clipped else force
        v = np.where(touching, v - h * force, v)
        x = np.where(touching, x + h * v, x)
        touching = touching & (x > 0.0)
        if not touching.any():
            break
    return max(exact, float(-v[~touching].min(initial=0.0)))
