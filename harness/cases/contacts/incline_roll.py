"""A sphere let go on an incline rolls, or slides where the friction does not suffice."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import tables
from harness.cases.contacts.parameters import Gravity
from harness.cases.contacts.resting import Resting, RestingCase, rolling
from harness.model.base import Vector
from harness.model.motion import Motion
from harness.theory.contact import down_an_incline


class InclineRoll(Resting):
    """A sphere at rest on a tilted floor, pressed in by its weight, let go; SI units, degrees."""

    angle: float = Field(20.0, ge=1e-6, lt=90.0, description="[deg] tilt of the floor")
    gravity: Gravity = Field(9.81, description="[m/s2]")

    @property
    def pull(self) -> Vector:
        """Return gravity along the tilted floor and into it [m/s2]."""
        angle = math.radians(self.angle)
        return (self.gravity * math.sin(angle), 0.0, -self.gravity * math.cos(angle))


class InclineRollCase(RestingCase[InclineRoll]):
    """Accelerations and momentum of a sphere on an incline."""

    name = "incline-roll"
    summary = "A sphere let go on an incline rolls, or slides where the friction does not suffice."
    formula = (
        "u + 2/5 r omega = g sin(angle) t. Sliding, from tan(angle) = 7/2 mu on: acceleration g "
        "(sin - mu cos), r times the angular one 5/2 mu g cos. Rolling: 5/7 g sin(angle), with "
        "what the tangential spring makes of it: integrated."
    )
    parameters = InclineRoll
    quantities = (
        Quantity("acceleration_ratio", "1", "mean over the second half, over g sin(angle)"),
        Quantity("rim_acceleration_ratio", "1", "radius times angular acceleration, likewise"),
        Quantity("momentum_ratio", "1", "u + 2/5 r omega over g sin(angle) t"),
    )
    # a linear spring without a dashpot rings on: its phase hides the limit
    laws: ClassVar = {
        name: row
        for name, row in tables.FLOOR_FRICTION.items()
        if name != "linear_history, elastic"
    }
    systems: ClassVar = {"wall, rolls": {"angle": 20.0}, "wall, slides": {"angle": 60.0}}

    def observe(self, p: InclineRoll, motion: Motion) -> Mapping[str, float]:
        """Return accelerations over the second half, and the momentum at the end."""
        u, rim = rolling(p, motion)
        half, pull = len(u) // 2, p.pull[0]
        gained = pull * float(motion.time[-1] - motion.time[half])
        return {
            "acceleration_ratio": float(u[-1] - u[half]) / gained,
            "rim_acceleration_ratio": float(rim[-1] - rim[half]) / gained,
            "momentum_ratio": float(u[-1] + 0.4 * rim[-1]) / (pull * float(motion.time[-1])),
        }

    def exact(self, p: InclineRoll) -> Mapping[str, float]:
        """Return the momentum, and for a sphere that slides all the time both accelerations.

        Rolling resistance changes momentum and spin; a sphere that slides slides all the more.
        """
        exact = {"momentum_ratio": 1.0}
        expected = down_an_incline(math.radians(p.angle), p.friction or 0.0, p.gravity)
        if not expected.rolls and p.tangential != "linear_nohistory":
            exact["acceleration_ratio"] = expected.acceleration / p.pull[0]
            exact["rim_acceleration_ratio"] = expected.turning / p.pull[0]
        if p.rolling != "none":
            return {name: value for name, value in exact.items() if name == "acceleration_ratio"}
        return exact


CASE = InclineRollCase()
