"""A sphere let go on an incline that rolling resistance holds, or slows down as it rolls."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from harness.cases.contact.contact_case import RestingCase, rolling
from harness.cases.contact.motion import Array, Motion
from harness.cases.contact.parameters import dashpots, rest_overlap, tangential_stiffness
from harness.cases.contact.submodels import ROLLING, ROLLING_BESIDE, ROLLING_UNDAMPED, Told
from harness.cases.incline_roll import InclineRoll
from harness.theory.contact import on_an_incline


class InclineRest(InclineRoll):
    """A sphere at rest on a tilted floor with rolling resistance, let go; SI units, degrees."""

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        super().check()
        if self.rolling == "none":
            raise ValueError("rolling = 'none': must be sds in this case, to hold a sphere")
        for name in ("rolling_friction", "rolling_stiffness", "friction"):
            if not getattr(self, name):
                raise ValueError(f"{name} = {getattr(self, name)!r}: must be greater than 0 here")


class InclineRestCase(RestingCase[InclineRest]):
    """A sphere let go on an incline is held by rolling resistance, or rolls against it."""

    name = "incline-rest"
    submodels = ROLLING
    other_submodels = (*ROLLING_BESIDE, *ROLLING_UNDAMPED)
    every_level = ("wall, rests",)
    # tan(angle) over mu_r = 0.05: 0.35, so that a spring without a dashpot holds it as well; 1.4
    systems: ClassVar[Told] = {"wall, rests": {"angle": 1.0}, "wall, rolls": {"angle": 4.0}}
    sets: ClassVar[Told] = {"rests": {"friction": 0.3, **ROLLING[0].law, "angle": 1.0}}

    def observed(self, parameters: InclineRest, motion: Motion) -> Mapping[str, float]:
        """Return how far it got, in all and over the first half, and its mean acceleration."""
        u, spin = rolling(parameters, motion)
        displacement = motion.position[:, 0, 0] - motion.position[0, 0, 0]
        half = len(u) // 2
        return self._quantities(
            parameters,
            motion.time[[half, -1]],
            *(series[[half, -1]] for series in (displacement, u, spin)),
        )

    def sizes(self, parameters: InclineRest) -> Mapping[str, float]:
        """Return that of the displacements where springs hold the sphere: m p / k_r, k_r alone."""
        if math.tan(math.radians(parameters.angle)) >= (parameters.rolling_friction or 0.0):
            return {}
        assert parameters.rolling_stiffness is not None
        end = self.scene(parameters).duration
        held = 2.0 * parameters.mass / parameters.rolling_stiffness
        sizes = {"displacement_ratio": end, "halfway_displacement_ratio": 0.5 * end}
        return {name: min(1.0, held / time**2) for name, time in sizes.items()}

    @staticmethod
    def _quantities(
        parameters: InclineRest, times: Array, displacement: Array, u: Array, spin: Array
    ) -> dict[str, float]:
        """Return the quantities of the states halfway and at the end, each (2,)."""
        pull = parameters.pull[0]
        fallen = 0.5 * pull * times**2
        gained = pull * (times[1] - times[0])
        return {
            "displacement_ratio": float(displacement[1] / fallen[1]),
            "halfway_displacement_ratio": float(displacement[0] / fallen[0]),
            "acceleration_ratio": float((u[1] - u[0]) / gained),
            "rim_acceleration_ratio": float((spin[1] - spin[0]) / gained),
        }

    def closed_forms(self, parameters: InclineRest) -> Mapping[str, float]:
        """Return the motion under springs and a constant torque, where nothing slides."""
        times = self.scene(parameters).duration * np.array([0.5, 1.0])
        load = parameters.mass * -parameters.pull[2]
        overlap = rest_overlap(parameters, load)
        across = tangential_stiffness(parameters, overlap)
        friction, resistance = parameters.friction, parameters.rolling_friction
        stiffness, dashpot = parameters.rolling_stiffness, parameters.rolling_damping
        if parameters.normal not in ("hooke", "hertz") or not across:
            return {}
        eta = (parameters.tangential_damping or 0.0) * dashpots(parameters, overlap)
        states = on_an_incline(
            times,
            parameters.pull[0],
            parameters.mass,
            (across, eta),
            (stiffness or 0.0, dashpot or 0.0),
            ((friction or 0.0) * load, (resistance or 0.0) * load),
        )
        if states is None:
            return {}
        displacement, u, _, spin = np.array(states).T
        return self._quantities(parameters, times, displacement, u, spin)


CASE = InclineRestCase()
