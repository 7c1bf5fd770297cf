"""A sphere falls on a floor or on a sphere and bounces; gravity acts during the contact, too."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.impact import impact_scene, oscillator
from harness.cases.contacts.parameters import ContactSystem, Gravity
from harness.model.motion import Motion
from harness.model.scene import Scene
from harness.theory import contact


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
        bounds.check_words(self, partner=("wall", "frozen"))
        g = self.gravity
        bounds.check_impact(
            self, "height", "m", self.speed, lambda speed: speed * speed / 2.0 / g, g
        )


class BounceCase(ContactCase[Bounce]):
    """Height of the rebound and contact time.

    Off a sphere it would fall, but round-off sideways has no time to grow within a contact.
    """

    name = "bounce"
    summary = "A sphere falls on a floor or a sphere and bounces under gravity."
    formula = (
        "m x'' = m g - F during the contact, free flight after it: height u^2 / 2 g. Piece by "
        "piece on a linear spring; without dissipation the height of the fall; else integrated."
    )
    parameters = Bounce
    quantities = (
        Quantity("rebound_ratio", "1", "height of the rebound over that of the fall"),
        Quantity(
            "contact_time_s", "s", "of the first contact, while the surfaces overlap",
            lambda p: 2.0 * p.elastic_overlap(p.speed) / p.speed,
        ),
    )  # fmt: skip
    laws: ClassVar = tables.laws("normal", "old", "clipped")
    systems: ClassVar = tables.systems("wall", "frozen sphere")

    def build(self, p: Bounce) -> Scene:
        """Return the contact with gravity, from half a step before it on."""
        velocity, gravity = (0.0, 0.0, -p.speed), (0.0, 0.0, -p.gravity)
        return impact_scene(p, velocity, sampled=True, gravity=gravity)

    def observe(self, p: Bounce, motion: Motion) -> Mapping[str, float]:
        """Return the height that the sphere will reach, and how long it touched."""
        g, z, v = p.gravity, motion.position[:, 0, 2], motion.velocity[:, 0, 2]
        # heights above touch, of fall and rebound, by the energy of free flight
        fall, rise = (float(z[i] - p.radius + 0.5 * v[i] ** 2 / g) for i in (0, -1))
        begin = float(motion.time[0]) + (math.sqrt(2.0 * g * fall) + float(v[0])) / g
        end = float(motion.time[-1]) - (math.sqrt(2.0 * g * rise) - float(v[-1])) / g
        return {"rebound_ratio": rise / p.height, "contact_time_s": end - begin}

    def exact(self, p: Bounce) -> Mapping[str, float]:
        """Return height and time of the bounce on a linear spring, the height of an elastic one."""
        elastic = {"rebound_ratio": 1.0} if p.damping == "none" else {}
        if not p.is_linear or p.clipped:
            return elastic
        zeta, omega = oscillator(p)
        after = contact.rebound(omega, zeta, p.gravity, p.speed) if zeta < 1.0 else None
        if after is None:
            return elastic
        ratio = after.speed**2 / (2.0 * p.gravity * p.height)
        return {"rebound_ratio": ratio, "contact_time_s": after.duration, **elastic}


CASE = BounceCase()
