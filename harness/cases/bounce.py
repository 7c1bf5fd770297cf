"""A sphere falls on a floor or on a sphere and bounces; gravity acts during the contact, too."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.impact import impact, rebound
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import ContactSystem, Gravity, check_impact, meets
from harness.cases.contact.submodels import BOUNCE, NORMAL, NORMAL_BESIDE, OLD_NORMAL, SYSTEMS, Told
from harness.parameters.scene import ContactScene


class Bounce(ContactSystem):
    """A fall from rest above a floor or a frozen sphere, in SI units."""

    height: float = Field(0.05, ge=1e-18, le=1e9, description="[m] of the fall")
    gravity: Gravity = Field(9.81, description="[m/s2] downward")

    @property
    def speed(self) -> float:
        """Return the speed at touch [m/s]."""
        return math.sqrt(2.0 * self.gravity * self.height)

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        meets(self, "wall", "frozen")
        g = self.gravity
        check_impact(self, "height", "m", self.speed, lambda speed: speed * speed / 2.0 / g, g)


class BounceCase(ContactCase[Bounce]):
    """A sphere falls on a floor or a sphere and bounces under gravity: height, contact time."""

    name = "bounce"
    submodels = (*NORMAL, *OLD_NORMAL)
    other_submodels = NORMAL_BESIDE
    # off a sphere it would fall, but not within a contact: round-off sideways has no time to grow
    systems: ClassVar[Told] = {name: SYSTEMS[name] for name in ("wall", "frozen sphere")}
    sets: ClassVar[Told] = {"usual": NORMAL[1].law, **BOUNCE}

    def scene(self, parameters: Bounce) -> ContactScene:
        """Return the contact with gravity, from half a step before it on."""
        g = parameters.gravity
        return impact(
            parameters, (0.0, 0.0, -parameters.speed), finely=True, gravity=(0.0, 0.0, -g)
        )

    def observed(self, parameters: Bounce, motion: Motion) -> Mapping[str, float]:
        """Return the height that the sphere will reach, and how long it touched."""
        g, z, v = parameters.gravity, motion.position[:, 0, 2], motion.velocity[:, 0, 2]
        # heights above touch, of fall and rebound, by the energy of free flight
        fall, rise = (float(z[i] - parameters.radius + 0.5 * v[i] ** 2 / g) for i in (0, -1))
        begin = float(motion.time[0]) + (math.sqrt(2.0 * g * fall) + float(v[0])) / g
        end = float(motion.time[-1]) - (math.sqrt(2.0 * g * rise) - float(v[-1])) / g
        return {"rebound_ratio": rise / parameters.height, "contact_time_s": end - begin}

    def closed_forms(self, parameters: Bounce) -> Mapping[str, float]:
        """Return height and time of the bounce on a linear spring, the height of an elastic one."""
        return rebound(parameters, parameters.height, parameters.gravity)


CASE = BounceCase()
