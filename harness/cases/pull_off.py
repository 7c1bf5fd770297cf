"""A sphere that sticks to a wall or a sphere is pulled off: the tension and overlap at parting."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.impact import overlap_of
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import (
    ContactSystem,
    Speed,
    between,
    elastic_force,
    hertz_spring,
    overlaps,
    pressed,
    reduced_modulus,
)
from harness.cases.contact.submodels import COHESIVE, STICKING_FLAT, SYSTEMS, Told
from harness.parameters.law import COHESIVE as COHESIVE_FORCES
from harness.parameters.scene import ZERO, ContactScene, Segment
from harness.theory import contact


class PullOff(ContactSystem):
    """A sphere, pressed into what it sticks to, that is pulled off at a constant speed; SI."""

    overlap: float = Field(1e-5, gt=0.0, description="[m] at the start")
    speed: Speed = Field(1e-3, description="[m/s] of the pull")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        if self.normal == "mdr" and not self.surface_energy:
            raise ValueError(
                f"surface_energy = {self.surface_energy!r} J/m2: normal = mdr needs one, above 0"
            )
        if self.normal not in (*COHESIVE_FORCES, "mdr"):
            raise ValueError(
                f"normal = {self.normal!r}: attracts nothing (normal = dmt, jkr, mdr do)"
            )
        if self.damping != "none":
            raise ValueError(f"damping = {self.damping!r}: must be none, forces are those at rest")
        pressed(self, "overlap", "m", self.overlap)
        # the force at the last step before it parts is that of half a step of overlap beside it
        tension = contact.jkr_pull_off(self.surface_energy or 0.0, self.reduced_radius)
        step: float = (0.1 * tension / hertz_spring(self)) ** (2.0 / 3.0)
        limits = overlaps(self)[0], self.steps_per_contact * step
        why = "with these steps_per_contact the elastic force of a step is a tenth of the tension"
        between("overlap", self.overlap, "m", limits, why)


class PullOffCase(ContactCase[PullOff]):
    """A sphere that sticks is pulled off: largest tension, and overlap where it parts."""

    name = "pull-off"
    submodels = (
        *(submodel for submodel in COHESIVE if "viscoelastic" not in submodel.name),
        STICKING_FLAT,
    )
    sets: ClassVar[Told] = {submodel.name: submodel.law for submodel in submodels}
    systems: ClassVar[Told] = {
        name: changes for name, changes in SYSTEMS.items() if name != "frozen sphere"
    }
    powers: ClassVar[tuple[float, ...]] = (1.0, 1.5, 2.0)

    def scene(self, parameters: PullOff) -> ContactScene:
        """Return the pull, which parts half a step before the end."""
        bodies = tuple(parameters.bodies(-parameters.overlap, ZERO))
        distance = parameters.overlap * (1.0 - self.closed_forms(parameters)["parting_ratio"])
        steps = parameters.steps_per_contact
        still = (ZERO,) * len(bodies)
        pull = Segment(steps, ((0.0, 0.0, parameters.speed), *still[1:]), still)
        return ContactScene(
            bodies,
            parameters.planes,
            parameters.law,
            step=distance / parameters.speed / (steps - 0.5),
            steps=steps,
            segments=(pull,),
        )

    def observed(self, parameters: PullOff, motion: Motion) -> Mapping[str, float]:
        """Return the largest tension and the last overlap with a force."""
        force = motion.force[:, 0, 2]
        overlap, _ = overlap_of(parameters, motion)
        last = int(np.flatnonzero(force)[-1])
        parted = last < len(force) - 1
        return {
            "pull_off_force_N": -float(force.min()),
            "parting_ratio": float(overlap[last]) / parameters.overlap if parted else math.nan,
        }

    def sizes(self, parameters: PullOff) -> Mapping[str, float]:
        """Return the largest elastic force [N], that at the start, of which the tension is left."""
        if parameters.normal != "mdr":
            return {}
        return {"pull_off_force_N": elastic_force(parameters, parameters.overlap)}

    def closed_forms(self, parameters: PullOff) -> Mapping[str, float]:
        """Return tension and overlap where the sphere parts."""
        gamma, radius = parameters.surface_energy or 0.0, parameters.reduced_radius
        if parameters.normal == "mdr":
            flats = 1.0 if parameters.partner == "wall" else 2.0
            modulus = 2.0 * reduced_modulus(parameters)
            tension, last = contact.mdr_pull_off(gamma, modulus, parameters.radius)
            return {
                "pull_off_force_N": tension,
                "parting_ratio": flats * last / parameters.overlap,
            }
        if parameters.normal != "jkr":
            return {"pull_off_force_N": contact.dmt_pull_off(gamma, radius), "parting_ratio": 0.0}
        last = contact.jkr_overlap("largest tension", gamma, reduced_modulus(parameters), radius)
        return {
            "pull_off_force_N": contact.jkr_pull_off(gamma, radius),
            "parting_ratio": last / parameters.overlap,
        }


CASE = PullOffCase()
