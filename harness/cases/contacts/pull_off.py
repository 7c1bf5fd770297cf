"""A sphere that sticks to a wall or a sphere is pulled off: the tension and overlap at parting."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.impact import overlap_and_rate
from harness.cases.contacts.parameters import ContactSystem, Speed
from harness.model.base import ZERO
from harness.model.motion import Motion
from harness.model.scene import Scene, Segment
from harness.theory import contact


class PullOff(ContactSystem):
    """A sphere, pressed into its partner, that is pulled off at a constant speed; SI units."""

    allowed: ClassVar = {
        **ContactSystem.allowed, "normal": ("dmt", "jkr", "mdr"), "damping": ("none",),
    }  # fmt: skip

    overlap: float = Field(1e-5, gt=0.0, description="[m] at the start")
    speed: Speed = Field(1e-3, description="[m/s] of the pull")

    def check(self) -> None:
        """Raise ValueError without attraction, and for an overlap that a step does not resolve."""
        if self.normal == "mdr" and not self.surface_energy:
            raise self.invalid("surface_energy", "normal = mdr needs one, above 0")
        self.check_overlap("overlap", self.overlap)
        # the force at the last step before it parts is that of half a step of overlap there
        tension = contact.jkr_pull_off(self.surface_energy or 0.0, self.effective_radius)
        step = (0.1 * tension / self.hertz_coefficient) ** (2.0 / 3.0)
        reason = (
            "with these steps_per_contact the elastic force of a step is a tenth of the tension"
        )
        self.check_range("overlap", 0.0, self.steps_per_contact * step, reason)

    @property
    def tension_and_overlap(self) -> tuple[float, float]:
        """Return the largest tension [N], and the overlap where the sphere parts [m]."""
        gamma, radius = self.surface_energy or 0.0, self.effective_radius
        modulus = self.moduli[0] if self.moduli else 0.0
        if self.normal == "mdr":
            flats = 1.0 if self.partner == "wall" else 2.0
            tension, last = contact.mdr_pull_off(gamma, 2.0 * modulus, self.radius)
            return tension, flats * last
        if self.normal == "dmt":
            return contact.dmt_pull_off(gamma, radius), 0.0
        last = contact.jkr_overlap("largest tension", gamma, modulus, radius)
        return contact.jkr_pull_off(gamma, radius), last

    @property
    def force_scale(self) -> float:
        """Return the size of the tension [N]; of mdr the elastic force at the start.

        mdr's ellipse has t - sin(t) of an angle t = 0.03 from its cosine: a rounding of 2e-16 / t
        in t is 3e-10 of t^3 / 6. So many digits of the elastic force remain where the forces
        nearly balance.
        """
        if self.normal == "mdr":
            return self.elastic_force(self.overlap)
        return self.tension_and_overlap[0]

    @property
    def neck_ratio(self) -> float:
        """Return the neck of JKR at its largest tension over the overlap of the start."""
        modulus, gamma = self.moduli[0] if self.moduli else 0.0, self.surface_energy or 0.0
        neck = contact.jkr_overlap("largest tension", gamma, modulus, self.effective_radius)
        return -neck / self.overlap or 1.0

    def scene(self) -> Scene:
        """Return the pull, which parts half a step before the end."""
        steps, bodies = self.steps_per_contact, self.bodies(-self.overlap)
        distance = self.overlap - self.tension_and_overlap[1]
        still = (ZERO,) * len(bodies)
        pull = Segment(
            steps=steps, velocities=((0.0, 0.0, self.speed), *still[1:]), angular_velocities=still
        )
        return Scene(
            bodies=bodies,
            walls=self.walls,
            law=self.stated_law,
            step=distance / self.speed / (steps - 0.5),
            steps=steps,
            segments=(pull,),
        )

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the largest tension and the last overlap with a force."""
        force = motion.force[:, 0, 2]
        overlap, _ = overlap_and_rate(self, motion)
        last = int(np.flatnonzero(force)[-1])
        parted = last < len(force) - 1
        return {
            "pull_off_force_N": -float(force.min()),
            "parting_ratio": float(overlap[last]) / self.overlap if parted else math.nan,
        }

    def exact(self) -> Mapping[str, float]:
        """Return tension and overlap where the sphere parts."""
        tension, last = self.tension_and_overlap
        return {"pull_off_force_N": tension, "parting_ratio": last / self.overlap}


PULL_OFF = ContactCase(
    name="pull-off",
    summary="A sphere that sticks is pulled off: largest tension, and overlap where it parts.",
    formula="DMT: 4 pi gamma R*, at touch. JKR: 3 pi gamma R*, at -a^2 / (3 R*) with a^3 = 9 pi "
    "gamma R*^2 / (4 E*); gamma is the energy of each surface. mdr, on each side of a flat with "
    "which a sphere has the energy gamma: 3/2 pi gamma R for small a / R, down to where no area is "
    "left.",
    parameters=PullOff,
    quantities=(
        Quantity("pull_off_force_N", "N", "largest tension", lambda p: p.force_scale),
        Quantity(
            "parting_ratio", "1", "overlap at the last force over that of the start",
            lambda p: p.neck_ratio,
        ),
    ),
)  # fmt: skip
