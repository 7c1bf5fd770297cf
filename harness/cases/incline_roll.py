"""A sphere that rolls or slides down an incline.

Down an incline: rolling while the friction suffices, sliding beyond.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact.contact_case import Friction, Resting, RestingCase, rolling
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import Gravity
from harness.cases.contact.submodels import ROLLING_ON, SLIDING, Told
from harness.parameters.scene import Vector
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


class InclineRollCase(Friction, RestingCase[InclineRoll]):
    """A sphere let go on an incline rolls, or slides where the friction does not suffice."""

    name = "incline-roll"
    # a linear spring without a dashpot rings on: what its phase is off hides the limit
    other_submodels = (
        *(
            submodel
            for submodel in Friction.other_submodels
            if submodel.name != "linear_history, elastic"
        ),
        *ROLLING_ON,
    )
    sets: ClassVar[Told] = {"rolls": SLIDING}
    systems: ClassVar[Told] = {
        "wall, rolls": {"angle": 20.0},
        "wall, slides": {"angle": 60.0},
    }

    def observed(self, parameters: InclineRoll, motion: Motion) -> Mapping[str, float]:
        """Return accelerations over the second half, and the momentum at the end."""
        u, spin = rolling(parameters, motion)
        half = len(u) // 2
        pull = parameters.pull[0]
        gained = pull * float(motion.time[-1] - motion.time[half])
        return {
            "acceleration_ratio": float(u[-1] - u[half]) / gained,
            "rim_acceleration_ratio": float(spin[-1] - spin[half]) / gained,
            "momentum_ratio": float(u[-1] + 0.4 * spin[-1]) / (pull * float(motion.time[-1])),
        }

    def closed_forms(self, parameters: InclineRoll) -> Mapping[str, float]:
        """Return the momentum, and for a sphere that slides all the time both accelerations.

        What resists rolling changes momentum and spin; a sphere that slides slides all the more.
        """
        exact = {"momentum_ratio": 1.0}
        angle = math.radians(parameters.angle)
        expected = down_an_incline(angle, parameters.friction or 0.0, parameters.gravity)
        if not expected.rolls and parameters.tangential != "linear_nohistory":
            exact["acceleration_ratio"] = expected.acceleration / parameters.pull[0]
            exact["rim_acceleration_ratio"] = expected.turning / parameters.pull[0]
        if parameters.rolling != "none":
            return {name: value for name, value in exact.items() if name == "acceleration_ratio"}
        return exact


CASE = InclineRollCase()
