"""The law alone: forces and torques along a motion that is given, without an integrator."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.contact_base.contact_case import ContactCase
from harness.cases.contact_base.further import COHESIVE_FRICTION, TURNING
from harness.cases.contact_base.motion import Array, Motion
from harness.cases.contact_base.parameters import ContactSystem
from harness.cases.contact_base.presets import SLIDING, Told
from harness.cases.contact_base.scales import between, dashpots, energy, overlaps, pressed
from harness.cases.contact_base.scans import Scan
from harness.cases.contact_base.submodels import (
    OLD_TANGENTIAL,
    ROLLING,
    ROLLING_BESIDE,
    SYSTEMS,
    TANGENTIAL,
    TANGENTIAL_BESIDE,
    TWISTING,
)
from harness.cases.contact_base.undamped import (
    ROLLING_UNDAMPED,
    TURNING_UNDAMPED,
    TWISTING_UNDAMPED,
)
from harness.cases.contract import Study
from harness.cases.prescribed_motion.turned import levers, tangential_ratio, turned_pair
from harness.comparison.findings import Findings
from harness.engines.contract import Engine
from harness.parameters.contact_scene import ZERO, ContactScene, Segment, Vector


class PrescribedMotion(ContactSystem):
    """A sphere that is pressed, sheared, sheared back, lifted a little, rolled, twisted; SI."""

    overlap: float = Field(1e-4, gt=0.0, description="[m] to which the sphere is pressed in")
    shear: float = Field(2e-5, gt=0.0, description="[m] along the surface, and twice that back")
    lift: float = Field(0.3, ge=0.0, le=0.999, description="[-] of the overlap, after the shear")
    turn: float = Field(1e-3, ge=1e-9, le=1e3, description="[rad] of rolling and of twisting")
    duration: float = Field(1e-3, ge=1e-12, le=1e9, description="[s] of each of the six pieces")
    turned: float = Field(
        0.0,
        ge=0.0,
        le=0.2,
        description="[rad] by which two spheres that stick turn as one body, instead of what "
        "follows the shear",
    )

    def check(self) -> None:
        """Raise ValueError for a motion that leaves the contact, or in which it pulls."""
        if self.turned and self.partner != "sphere":
            raise ValueError(
                f"turned = {self.turned!r}: needs two spheres (partner = sphere), "
                f"got partner = {self.partner!r}"
            )
        pressed(self, "overlap", "m", self.overlap)
        (least, most), left = overlaps(self), (1.0 - self.lift) * self.overlap
        if self.partner == "sphere":
            reach = self.radius + self.second_radius
            most = math.sqrt(0.9 * left * (2.0 * reach - 1.1 * left))
        why = "resolved, and a tenth of the overlap must be left beside the top of a sphere"
        between("shear", self.shear, "m", (least, most), why)
        pull = dashpots(self, self.overlap) * self.lift * self.overlap
        push = energy(self, left) / left
        why = "the dashpot takes more than half of the force as the sphere is lifted"
        between("duration", self.duration, "s", (pull / push, 1e9), why)


PIECES = 6

TURNED = "two spheres, turned"

SLACK = 1e-9
"""[mrad] of round-off."""


class PrescribedMotionCase(ContactCase[PrescribedMotion]):
    """Forces along a given motion: pressed, sheared to and fro, lifted, rolled, twisted."""

    name = "prescribed-motion"
    submodels = (
        *(*TANGENTIAL, *OLD_TANGENTIAL, *ROLLING, *TWISTING),
        *(*COHESIVE_FRICTION, *TURNING),
    )
    beside = (
        *(*TANGENTIAL_BESIDE, *ROLLING_BESIDE),
        *(*ROLLING_UNDAMPED, *TWISTING_UNDAMPED, *TURNING_UNDAMPED),
    )
    invariant = (*ROLLING, *TWISTING)
    over_ranks = ("rolling sds, mindlin", "twisting sds, mindlin")
    sets: ClassVar[Told] = {"usual": SLIDING}
    systems: ClassVar[Told] = {
        **{name: told for name, told in SYSTEMS.items() if name != "frozen sphere"},
        # a quarter of the shear, so that it sticks
        TURNED: {"partner": "sphere", "turned": 0.08, "shear": 5e-6},
    }
    scan = Scan("reversed_ratio", "shear", (1e-6, 3e-6, 1e-5, 2e-5, 4e-5))

    def scene(self, parameters: PrescribedMotion) -> ContactScene:
        """Return the pieces of the motion, the sphere at touch before."""
        if parameters.turned:
            return turned_pair(parameters)
        bodies = tuple(parameters.bodies(0.0, ZERO))
        n, time = parameters.steps_per_contact, parameters.duration
        still = (ZERO,) * len(bodies)

        def piece(v: Vector = ZERO, w: Vector = ZERO) -> Segment:
            moved = (v[0] / time, v[1] / time, v[2] / time)
            turned = (w[0] / time, w[1] / time, w[2] / time)
            return Segment(n, (moved, *still[1:]), (turned, *still[1:]))

        d, s, turn = parameters.overlap, parameters.shear, parameters.turn
        pieces = (
            piece((0.0, 0.0, -d)),
            piece((s, 0.0, 0.0)),
            piece((-2.0 * s, 0.0, 0.0)),
            piece((0.0, 0.0, parameters.lift * d)),
            piece(w=(turn, 0.0, 0.0)),
            piece(w=(0.0, 0.0, turn)),
        )
        return ContactScene(
            bodies,
            parameters.planes,
            parameters.law,
            step=time / n,
            steps=PIECES * n,
            every=n,
            segments=pieces,
        )

    def verify(self, engine: Engine, study: Study) -> Findings:
        """Add what the lever of the engine makes of a pair that turns as one body."""
        found = super().verify(engine, study)
        return replace(found, checks=[*found.checks, *levers(self, found)])

    def observed(self, parameters: PrescribedMotion, motion: Motion) -> Mapping[str, float]:
        """Return forces and torques at the ends of the pieces."""
        force, torque = motion.force[:, 0], motion.torque[:, 0]
        if parameters.turned:
            ratio = tangential_ratio(motion)
            return {"shear_ratio": float(ratio[2]), "turned_ratio": float(ratio[-1])}
        shear, back, lifted, rolled, twisted = range(2, PIECES + 1)
        found = {
            name: float(force[at, 0] / force[at, 2])
            for name, at in (
                ("shear_ratio", shear),
                ("reversed_ratio", back),
                ("lifted_ratio", lifted),
            )
        }
        r = parameters.radius
        if parameters.rolling != "none":
            found["rolling_ratio"] = float(torque[rolled, 0] / (r * force[rolled, 2]))
        if parameters.twisting != "none":
            found["twisting_ratio"] = float(torque[twisted, 2] / (r * force[twisted, 2]))
        if parameters.rolling != "none" and parameters.twisting != "none":
            found["held_ratio"] = float(torque[twisted, 0] / (r * force[twisted, 2]))
        return found

    def axes(self, parameters: PrescribedMotion) -> tuple[str, str]:
        """Return what is drawn: torques where there are some, else the tangential force."""
        if parameters.turned:
            return "time (ms)", "tangential over normal force, both turned"
        if parameters.rolling != "none" or parameters.twisting != "none":
            return "angle (mrad)", "torque over radius and normal force"
        return "displacement (µm)", "tangential force (N)"

    def curves(
        self, parameters: PrescribedMotion, motion: Motion
    ) -> Mapping[str, tuple[Array, Array]]:
        """Return the tangential force over the displacement, or torques over their angles."""
        force, torque = motion.force[:, 0], motion.torque[:, 0]
        if parameters.turned:
            return {"": (1e3 * motion.time, tangential_ratio(motion))}
        if parameters.rolling == "none" and parameters.twisting == "none":
            return {"": (1e6 * motion.position[:, 0, 0], force[:, 0])}
        turned = 1e3 * parameters.turn * (motion.time / parameters.duration - (PIECES - 2))
        pressed = parameters.radius * np.where(force[:, 2] > 0.0, force[:, 2], np.nan)
        found = {}
        if parameters.rolling != "none":
            shown = (turned > -SLACK) & (turned < 1e3 * parameters.turn + SLACK)
            found["rolling"] = turned[shown], (torque[:, 0] / pressed)[shown]
        if parameters.twisting != "none":
            turned = turned - 1e3 * parameters.turn
            shown = turned > -SLACK
            found["twisting"] = turned[shown], (torque[:, 2] / pressed)[shown]
        return found


CASE = PrescribedMotionCase()
