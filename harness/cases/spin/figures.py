"""The figure of a spinning sphere: the spin that is left over the angle at the contact."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from harness.cases.contact_base.curves import OverAngle
from harness.cases.contact_base.motion import Array
from harness.parameters.contact_scene import Vector

if TYPE_CHECKING:
    from harness.cases.spin.case import Spin


def _spin(parameters: Spin, angle: float) -> float:
    """Return the spin [rad/s] with which the surface meets what it hits at an angle [deg]."""
    return parameters.speed * math.tan(math.radians(angle)) / parameters.radius


def _angle(parameters: Spin) -> float:
    return math.degrees(math.atan(parameters.radius * parameters.spin / parameters.speed))


def _sent(parameters: Spin) -> tuple[Vector, Vector]:
    return (0.0, 0.0, -parameters.speed), (0.0, parameters.spin, 0.0)


def _ratio(parameters: Spin, left: Array) -> Array:
    """Return the spin ratio of a sphere, the other without spin.

    An impulse J changes the velocity at the contact by 7/2 J / m*, and r omega by 5/2 J / m.
    """
    return 1.0 - 5.0 / 7.0 * parameters.reduced_mass / parameters.mass * (1.0 - left)


OVER_ANGLE = OverAngle(
    quantity="spin_ratio",
    parameter="spin",
    title="Spin ratio over the angle of the velocity at the contact",
    y="spin after over that before",
    value=_spin,
    angle=_angle,
    sent=_sent,
    ratio=_ratio,
)
