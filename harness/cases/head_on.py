"""A sphere meets a wall or another sphere head-on: normal force and damping alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.impact import head_on, impact, overlap_of, relative_velocity
from harness.cases.contact.motion import Motion, crossing, peak, value_at
from harness.cases.contact.parameters import ContactSystem, Speed, check_impact
from harness.cases.contact.submodels import (
    BRANCHES,
    COHESIVE,
    HEAD_ON,
    NORMAL,
    NORMAL_BESIDE,
    OLD_CLIPPED,
    OLD_NORMAL,
    SYSTEMS,
    TOGETHER,
    TWO_MATERIALS,
    Told,
)
from harness.parameters.scene import ContactScene


class HeadOn(ContactSystem):
    """A head-on impact, in SI units."""

    speed: Speed = Field(1.0, description="[m/s] of the approach")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        check_impact(self, "speed", "m/s", self.speed, lambda speed: speed)


class HeadOnCase(ContactCase[HeadOn]):
    """A sphere meets a wall or a sphere head-on: restitution, contact time, peaks."""

    name = "head-on"
    sets: ClassVar[Told] = {"elastic": {}, **HEAD_ON}
    systems: ClassVar[Told] = {**SYSTEMS, **TWO_MATERIALS}
    submodels = (*NORMAL, *COHESIVE, *OLD_NORMAL, *BRANCHES, *OLD_CLIPPED, *TOGETHER)
    other_submodels = NORMAL_BESIDE
    invariant = (*NORMAL, *COHESIVE, *OLD_NORMAL, *BRANCHES, *TOGETHER)
    over_ranks = ("jkr", "mdr, yield")

    def scene(self, parameters: HeadOn) -> ContactScene:
        """Return the impact, sampled over the contact."""
        return impact(parameters, (0.0, 0.0, -parameters.speed), finely=True)

    def observed(self, parameters: HeadOn, motion: Motion) -> Mapping[str, float]:
        """Return restitution and peaks; contact time and overlap where nothing sticks."""
        overlap, rate = overlap_of(parameters, motion)
        quantities = {
            "restitution": float(relative_velocity(motion)[-1, 2]) / parameters.speed,
            "largest_force_N": peak(motion.force[:, 0, 2]),
        }
        if parameters.surface_energy is None:
            turn = crossing(motion.time, rate, np.gradient(rate, motion.time))
            # at the ends of the run it flies freely, with the gap that is left
            begin, end = (motion.time[i] - overlap[i] / rate[i] for i in (0, -1))
            quantities["contact_time_s"] = float(end - begin)
            quantities["largest_overlap_m"] = value_at(turn, motion.time, overlap, rate)
        return quantities

    def closed_forms(self, parameters: HeadOn) -> Mapping[str, float]:
        """Return what is known exactly of linear springs, Hertz's and constant restitution."""
        return head_on(parameters, parameters.speed)


CASE = HeadOnCase()
