"""The angles of the frictionless incline in closed form, in degrees."""

from __future__ import annotations

import math

from harness.errors import RequestError
from harness.theory.shock import SHOCK_WITHOUT_REBOUND

STATIC_ANGLE_DEG = 30.0
"""The tilt at which a grain at rest in a well stands on the crest and leaves it."""


def critical_angle(shock: float = SHOCK_WITHOUT_REBOUND) -> float:
    """Return theta_c [deg], the smallest tilt at which motion persists.

    From E* >= C with C + dE = 1 - cos(30 deg + theta) (units of m g d):
    shock = (1 - cos(30 - theta)) / (1 - cos(30 + theta))
    = (sin(15 - theta/2) / sin(15 + theta/2))^2, hence
    tan(theta/2) = tan(15 deg) (1 - sqrt(shock)) / (1 + sqrt(shock)).
    It is 30 deg (the static angle) at shock 0 and 0 at shock 1. Raise
    RequestError unless 0 <= shock <= 1.
    """
    if not 0.0 <= shock <= 1.0:
        raise RequestError(f"shock = {shock!r} is not allowed: must be from 0 to 1")
    root = math.sqrt(shock)
    tangent = math.tan(math.pi / 12.0) * (1.0 - root) / (1.0 + root)
    return math.degrees(2.0 * math.atan(tangent))


def no_flight_bound(shock: float = SHOCK_WITHOUT_REBOUND) -> float:
    """Return the tilt [deg] above which the grain in steady motion leaves the row.

    Contact is weakest just before the shock, where the kinetic energy is
    dE / (1 - shock): m g cos(30 + theta) = 2 m g sin(theta) / (1 - shock).
    15.30 deg at shock = 1/4. Raise RequestError unless 0 <= shock < 1.
    """
    if not 0.0 <= shock < 1.0:
        raise RequestError(f"shock = {shock!r} is not allowed: must be from 0 to below 1")
    ratio = 2.0 / (1.0 - shock)
    return math.degrees(math.atan(math.cos(math.pi / 6.0) / (ratio + math.sin(math.pi / 6.0))))
