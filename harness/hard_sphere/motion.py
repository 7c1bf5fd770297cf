"""Flight, collision and sliding of the grain, in units of diameter, gravity and mass.

The row's spheres have their centres at (j, 0), the grain's centre stays at a distance of 1 or more
from each. Gravity is (sin theta, -cos theta). On a sphere the grain stands at an angle beta from
the vertical, positive ahead, where its potential energy over the centre is cos beta.
"""

from __future__ import annotations

import math

import numpy as np

from harness.compiled import compiled
from harness.hard_sphere.roots import NEVER, roots_within, value

LOWEST = 0.8
"""Height over the row below any contact, sqrt(3) / 2 at least: where a flight has ended."""

TOUCHING = 1e-13
"""Gap of a contact, to rounding."""

WELL = math.pi / 6.0
"""Angle from the row's normal at which the grain touches two spheres."""

LEAVES, SHOCK, TURNS = 0, 1, 2
"""How sliding ends: the normal force vanishes, another sphere is met, the grain comes to rest."""


@compiled
def flight(x: float, y: float, vx: float, vy: float, theta: float, left: int) -> tuple[float, int]:
    """Return how long the grain flies, and the sphere that it meets.

    ``left`` is the sphere that it has just left, on which it stands to rounding.
    """
    along, down = math.sin(theta), math.cos(theta)
    longest = (vy + math.sqrt(vy * vy + 2.0 * down * (y - LOWEST))) / down
    turn = min(max(-vx / along, 0.0), longest) if along > 0.0 else 0.0
    far = max(x, x + vx * longest + 0.5 * along * longest**2)
    near = min(x, x + vx * turn + 0.5 * along * turn**2)
    first, met = NEVER, left
    for sphere in range(math.floor(near) - 1, math.ceil(far) + 2):
        rx, ry = x - sphere, y
        quartic = np.array(
            [
                rx * rx + ry * ry - 1.0,
                2.0 * (rx * vx + ry * vy),
                vx * vx + vy * vy + rx * along - ry * down,
                vx * along - vy * down,
                0.25,
            ]
        )
        if sphere == left:
            quartic = quartic[1:].copy()  # the contact at the start is no root
        elif quartic[0] <= TOUCHING and quartic[1] < TOUCHING:
            return 0.0, sphere  # it stands on it, and moves into it or along it
        slope = quartic[1:] * np.arange(1.0, quartic.size)
        for t in roots_within(quartic, longest):
            if t < first and value(slope, t) < 0.0:
                first, met = t, sphere
                break
    return first, met


@compiled
def slide(energy: float, beta: float, forward: bool, theta: float) -> tuple[float, int]:
    """Return the angle at which sliding ends, and how: LEAVES, SHOCK, or TURNS.

    ``energy`` is v^2 / 2 + cos beta. The normal force cos beta - v^2 vanishes where
    cos beta = 2 E / 3, the speed where cos beta = E; the next sphere is met at WELL from the
    row's normal. Seen from behind, where the grain moves backward.
    """
    side = 1.0 if forward else -1.0
    beta, well = side * beta, WELL + side * theta
    if energy < 1.0 and beta < 0.0:
        return -side * math.acos(energy), TURNS
    leaves = math.acos(max(-1.0, min(1.0, 2.0 * energy / 3.0)))
    if leaves < well:
        return side * max(leaves, beta), LEAVES
    return side * well, SHOCK
