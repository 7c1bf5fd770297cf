"""A solid sphere that slides, rolls or turns on a plane under its weight: I = 2/5 m r^2."""

from __future__ import annotations

import math
from typing import NamedTuple


class Incline(NamedTuple):
    """Whether a sphere rolls down an incline, its acceleration and r times its angular one."""

    rolls: bool
    acceleration: float
    turning: float


def down_an_incline(angle: float, friction: float, gravity: float) -> Incline:
    """Return how a sphere starts down an incline [rad, m/s2].

    It rolls with 5/7 g sin(angle) while tan(angle) <= 7/2 mu, for that takes a friction of 2/7 of
    the pull; else it slides with g (sin - mu cos), and r alpha = 5/2 mu g cos.
    """
    pull, load = gravity * math.sin(angle), gravity * math.cos(angle)
    if pull <= 3.5 * friction * load:
        return Incline(True, 5.0 / 7.0 * pull, 5.0 / 7.0 * pull)
    return Incline(False, pull - friction * load, 2.5 * friction * load)


def twisting_deceleration(twisting_friction: float, radius: float, gravity: float) -> float:
    """Return by how much omega about the normal falls in a second [rad/s2]: 5/2 mu_w g / r^2.

    The resisting torque is mu_w m g with mu_w a length [m]; Marshall's is 2/3 mu a, a the contact
    radius (of a pressure that is constant over the contact).
    """
    return 2.5 * twisting_friction * gravity / radius**2
