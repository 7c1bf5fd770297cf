"""A sphere let go on an incline is held by rolling resistance, or rolls against it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from harness.cases.base import Quantity
from harness.cases.contacts import tables
from harness.cases.contacts.incline_roll import InclineRoll
from harness.cases.contacts.resting import RestingCase, rolling
from harness.model.motion import Floats, Motion
from harness.theory.contact import on_an_incline


class InclineRest(InclineRoll):
    """A sphere at rest on a tilted floor with rolling resistance, let go; SI units, degrees."""

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        super().check()
        if self.rolling != "sds":
            raise ValueError(
                f"rolling = {self.rolling!r}: must be sds in this case, to hold a sphere"
            )
        for name in ("rolling_friction", "rolling_stiffness", "friction"):
            if not getattr(self, name):
                raise ValueError(f"{name} = {getattr(self, name)!r}: must be greater than 0 here")


def displacement_scale(p: InclineRest, share: float) -> float:
    """Return the size of a displacement ratio: of a sphere that springs hold m p / k_r."""
    if math.tan(math.radians(p.angle)) >= (p.rolling_friction or 0.0):
        return 1.0
    assert p.rolling_stiffness is not None
    return min(1.0, 2.0 * p.mass / p.rolling_stiffness / (share * p.seconds) ** 2)


class InclineRestCase(RestingCase[InclineRest]):
    """Displacement and acceleration of a sphere with rolling resistance on an incline."""

    name = "incline-rest"
    summary = "A sphere let go on an incline is held by rolling resistance, or rolls against it."
    formula = (
        "tan(angle) < mu_r: the springs hold it, at x = m g sin(angle) (1/k_t + 1/k_r) for a small "
        "overlap, about which it swings. Beyond: 5/7 g (sin(angle) - mu_r cos(angle)). Both "
        "exactly by linear springs in turn: a torque that the spring gives, and one of mu_r R* F_n."
    )
    parameters = InclineRest
    quantities = (
        Quantity(
            "displacement_ratio", "1", "of the centre along the incline, over g sin(angle) t^2 / 2",
            lambda p: displacement_scale(p, 1.0),
        ),
        Quantity(
            "halfway_displacement_ratio", "1", "likewise, halfway",
            lambda p: displacement_scale(p, 0.5),
        ),
        Quantity(
            "acceleration_ratio", "1", "mean over the second half, over g sin(angle)"
        ),
        Quantity(
            "rim_acceleration_ratio", "1", "radius times angular acceleration, likewise"
        ),
    )  # fmt: skip
    laws: ClassVar = tables.laws("rolling", "further_rolling", "undamped_rolling")
    # tan(angle) over mu_r = 0.05: 0.35, so that a spring without a dashpot holds it as well; 1.4
    systems: ClassVar = {"wall, rests": {"angle": 1.0}, "wall, rolls": {"angle": 4.0}}
    always = ("wall, rests",)

    def observe(self, p: InclineRest, motion: Motion) -> Mapping[str, float]:
        """Return the displacement, in all and over the first half, and the mean acceleration."""
        u, rim = rolling(p, motion)
        displacement = motion.position[:, 0, 0] - motion.position[0, 0, 0]
        at = [len(u) // 2, -1]
        return _ratios(p, motion.time[at], displacement[at], u[at], rim[at])

    def exact(self, p: InclineRest) -> Mapping[str, float]:
        """Return the motion under springs and a constant torque, where nothing slides."""
        along = p.tangential_slope(p.overlap_at_rest)
        if p.normal not in ("hooke", "hertz") or not along:
            return {}
        times = self.scene(p).duration * np.array([0.5, 1.0])
        eta = (p.tangential_damping or 0.0) * p.eta(p.overlap_at_rest)
        rolls = p.rolling_stiffness or 0.0, p.rolling_damping or 0.0
        limits = (p.friction or 0.0) * p.load, (p.rolling_friction or 0.0) * p.load
        states = on_an_incline(times, p.pull[0], p.mass, (along, eta), rolls, limits)
        if states is None:
            return {}
        displacement, u, _, rim = np.array(states).T
        return _ratios(p, times, displacement, u, rim)


def _ratios(
    p: InclineRest, times: Floats, displacement: Floats, u: Floats, rim: Floats
) -> dict[str, float]:
    """Return the quantities of the states halfway and at the end, each (2,)."""
    pull = p.pull[0]
    fallen, gained = 0.5 * pull * times**2, pull * (times[1] - times[0])
    return {
        "displacement_ratio": float(displacement[1] / fallen[1]),
        "halfway_displacement_ratio": float(displacement[0] / fallen[0]),
        "acceleration_ratio": float((u[1] - u[0]) / gained),
        "rim_acceleration_ratio": float((rim[1] - rim[0]) / gained),
    }


CASE = InclineRestCase()
