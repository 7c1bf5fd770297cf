"""A sphere slides on a floor until it rolls: what friction leaves of the speed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact.contact_case import Friction, Resting, RestingCase, rolling, speed_ratios
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import Duration, Speed
from harness.cases.contact.submodels import ROLLING_ON, SLIDING, Told
from harness.cases.contact.submodels import SLIP_TO_ROLL as MFIX
from harness.errors import RequestError
from harness.parameters.scene import ZERO, Vector

LEAST = 1e-6
"""Friction: with less, slipping lasts a day and longer."""


class SlipToRoll(Resting):
    """A sphere on a floor, pressed in by its weight, that starts to slide; in SI units."""

    speed: Speed = Field(0.1, description="[m/s] along the floor, at the start")
    duration: Duration = Field(1.5, description="[-] in times 2 u / (7 mu g) until it rolls")

    @property
    def start(self) -> tuple[Vector, Vector]:
        """Return sliding without spin."""
        return (self.speed, 0.0, 0.0), ZERO

    @property
    def seconds(self) -> float:
        """Return the duration [s]; raise RequestError without friction."""
        friction = self.friction or 0.0
        if friction < LEAST:
            raise RequestError(f"friction = {self.friction!r}: must be at least {LEAST:g} to roll")
        return self.duration * (2.0 * self.speed / 7.0 / friction / self.gravity)


class SlipToRollCase(Friction, RestingCase[SlipToRoll]):
    """A sphere slides on a floor until it rolls, at 5/7 of its speed."""

    name = "slip-to-roll"
    other_submodels = (*Friction.other_submodels, *ROLLING_ON)
    sets: ClassVar[Told] = {"usual": SLIDING, **MFIX}
    systems: ClassVar[Told] = {"wall": {}}

    def observed(self, parameters: SlipToRoll, motion: Motion) -> Mapping[str, float]:
        """Return speeds after the second quarter and at the end, spin at the end."""
        u, spin = rolling(parameters, motion)
        quantities = speed_ratios("sliding_speed_ratio", parameters, motion, parameters.speed)
        return {**quantities, "momentum_ratio": float(u[-1] + 0.4 * spin[-1]) / parameters.speed}

    def closed_forms(self, parameters: SlipToRoll) -> Mapping[str, float]:
        """Return the momentum about the floor, which no force there changes, but a torque does."""
        return {"momentum_ratio": 1.0} if parameters.rolling == "none" else {}


CASE = SlipToRollCase()
