"""A sphere slides on a floor until it rolls: the speed that friction leaves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import tables
from harness.cases.contacts.parameters import Duration, Speed
from harness.cases.contacts.resting import Resting, RestingCase, rolling, speed_ratios
from harness.errors import RequestError
from harness.model.base import ZERO, Vector
from harness.model.motion import Motion

LEAST_FRICTION = 1e-6  # with less, slipping lasts a day and longer


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
        """Return the duration [s]. Raise RequestError without friction."""
        friction = self.friction or 0.0
        if friction < LEAST_FRICTION:
            raise RequestError(
                f"friction = {self.friction!r}: must be at least {LEAST_FRICTION:g} to roll"
            )
        return self.duration * (2.0 * self.speed / 7.0 / friction / self.gravity)


class SlipToRollCase(RestingCase[SlipToRoll]):
    """Speeds of a sphere that slides until it rolls."""

    name = "slip-to-roll"
    summary = "A sphere slides on a floor until it rolls, at 5/7 of its speed."
    formula = (
        "u + 2/5 r omega stays u0, whatever the friction. It rolls from t = 2 u0 / (7 mu g) on, "
        "about 5/7 u0, with what the tangential spring makes of it: integrated."
    )
    parameters = SlipToRoll
    quantities = (
        Quantity("sliding_speed_ratio", "1", "speed over that of the start, while it slides"),
        Quantity("speed_ratio", "1", "speed over that of the start, at the end"),
        Quantity(
            "rim_speed_ratio", "1", "radius times spin at the end over the speed at the start"
        ),
        Quantity("momentum_ratio", "1", "u + 2/5 r omega at the end over the speed at the start"),
    )
    laws: ClassVar = tables.FLOOR_FRICTION
    systems: ClassVar = {"wall": {}}

    def observe(self, p: SlipToRoll, motion: Motion) -> Mapping[str, float]:
        """Return speeds after the second quarter and at the end, spin at the end."""
        u, rim = rolling(p, motion)
        momentum = float(u[-1] + 0.4 * rim[-1]) / p.speed
        ratios = speed_ratios("sliding_speed_ratio", p, motion, p.speed)
        return {**ratios, "momentum_ratio": momentum}

    def exact(self, p: SlipToRoll) -> Mapping[str, float]:
        """Return the momentum about the floor, which no force there changes, but a torque does."""
        return {"momentum_ratio": 1.0} if p.rolling == "none" else {}


CASE = SlipToRollCase()
