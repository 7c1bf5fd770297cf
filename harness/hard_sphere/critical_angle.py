"""The critical angle of rigid spheres with restitution, by events.

The grain comes over a crest at rest and slides into the well, as in the passage of a DEM: the
smallest angle at which it passes the next crest, once its hops in the well have died out. Up to a
restitution of 0.7 that is also the smallest angle of steady motion, from whatever start; above,
the grain is in flight at the crest, and fates of different starts differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from harness.errors import RequestError
from harness.hard_sphere.motion import WELL
from harness.hard_sphere.passage import MOVES_ON, follow

MOST_RESTITUTION = 0.7
WINDOW = (5.0, 15.0)
SCAN = 41
RESOLUTION_DEG = 1e-10

STEADY_SPEED = 0.48
"""[sqrt(g d)] of a start in the well, along the sphere ahead: more than it takes to the crest."""


def passage(angle_deg: float, restitution: float) -> tuple[int, float, int, bool, float]:
    """Return what becomes of a grain that came over the last crest at rest.

    Its fate, the energy above that of rest on the next crest [m g d], the collisions, whether it
    slid at the end, and the angle ahead of the crest [rad] at which its hops died out, as
    :func:`harness.hard_sphere.passage.follow` tells them.
    """
    theta = math.radians(angle_deg)
    speed = math.sqrt(2.0 * (1.0 - math.cos(WELL + theta)))
    vx, vy = speed * math.cos(WELL), -speed * math.sin(WELL)
    return follow(math.sin(WELL), math.cos(WELL), vx, vy, theta, restitution, 1, True)


def steady(angle_deg: float, restitution: float, wells: int = 100) -> int:
    """Return the fate of a grain that starts in a well, to pass so many."""
    vx, vy = STEADY_SPEED * math.cos(WELL), STEADY_SPEED * math.sin(WELL)
    start = (math.sin(WELL), math.cos(WELL), vx, vy)
    return follow(*start, math.radians(angle_deg), restitution, wells, False)[0]


@cache
def critical_angle(restitution: float) -> float:
    """Return the critical angle [deg] of rigid spheres.

    Raise RequestError for a restitution outside 0 to 0.7.
    """
    if not 0.0 <= restitution <= MOST_RESTITUTION:
        raise RequestError(
            f"restitution = {restitution!r}: must be from 0 to {MOST_RESTITUTION:g}, above which "
            "the grain of rigid spheres flies over the crest"
        )
    return first_moving(lambda angle: passage(angle, restitution)[0])


@cache
def hops_end(restitution: float) -> float:
    """Return how far before the next crest [deg] the hops die out at the critical angle.

    Raise RequestError for a restitution outside 0 to 0.7.
    """
    return -math.degrees(passage(critical_angle(restitution), restitution)[4])


def first_moving(fate: Callable[[float], int]) -> float:
    """Return the lowest angle [deg] from which on a grain moves, trapped just below it."""
    angles = np.linspace(*WINDOW, SCAN)
    moves = [fate(angle) == MOVES_ON for angle in angles]
    first = moves.index(True)
    low, high = float(angles[first - 1]), float(angles[first])
    while high - low > RESOLUTION_DEG:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fate(middle) == MOVES_ON else (middle, high)
    return 0.5 * (low + high)
