"""A solid sphere that slides, rolls or turns on a plane under its weight: I = 2/5 m r^2."""

from __future__ import annotations

import math
from typing import NamedTuple


class SlipToRoll(NamedTuple):
    """When a sphere that slides begins to roll [s], and its speed from then on [m/s]."""

    time: float
    speed: float


def slip_to_roll(speed: float, friction: float, gravity: float) -> SlipToRoll:
    """Return 2 u0 / (7 mu g) and 5/7 u0 of a sphere that starts without rotation.

    u = u0 - mu g t and r omega = 5/2 mu g t meet there; the speed does not depend on mu.
    """
    return SlipToRoll(2.0 * speed / (7.0 * friction * gravity), 5.0 / 7.0 * speed)


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


def rolling_deceleration(rolling_friction: float, radius: float, gravity: float) -> float:
    """Return by how much omega falls in a second [rad/s2] while rolling: 5/7 mu_r g / r.

    The resisting torque is mu_r r m g (mu_r a number; R* = r on a plane). Friction at the contact
    bears 5/7 mu_r m g, which mu must allow.
    """
    return 5.0 / 7.0 * rolling_friction * gravity / radius


def twisting_deceleration(twisting_friction: float, radius: float, gravity: float) -> float:
    """Return by how much omega about the normal falls in a second [rad/s2]: 5/2 mu_w g / r^2.

    The resisting torque is mu_w m g with mu_w a length [m]; Marshall's is 2/3 mu a, a the contact
    radius (of a pressure that is constant over the contact).
    """
    return 2.5 * twisting_friction * gravity / radius**2
