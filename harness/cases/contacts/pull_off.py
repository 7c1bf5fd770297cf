"""A sphere that sticks to a wall or a sphere is pulled off: the tension and overlap at parting."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.impact import overlap_and_rate
from harness.cases.contacts.parameters import ContactSystem, Speed
from harness.cases.equal_steps import ROUND_OFF
from harness.model.base import ZERO
from harness.model.motion import Motion
from harness.model.scene import Scene, Segment
from harness.results.rows import Tolerance
from harness.theory import contact

ELLIPSE = "the force of mdr's ellipse is the difference of an angle and its sine: 3e-10 is rounding"


class PullOff(ContactSystem):
    """A sphere, pressed into its partner, that is pulled off at a constant speed; SI units."""

    overlap: float = Field(1e-5, gt=0.0, description="[m] at the start")
    speed: Speed = Field(1e-3, description="[m/s] of the pull")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        bounds.check_words(self, normal=("dmt", "jkr", "mdr"), damping=("none",))
        if self.normal == "mdr" and not self.surface_energy:
            raise ValueError(
                f"surface_energy = {self.surface_energy!r} J/m2: normal = mdr needs one, above 0"
            )
        bounds.check_overlap(self, "overlap", "m", self.overlap)
        # the force at the last step before it parts is that of half a step of overlap next to it
        tension = contact.jkr_pull_off(self.surface_energy or 0.0, self.effective_radius)
        step = (0.1 * tension / self.hertz_coefficient) ** (2.0 / 3.0)
        limits = bounds.overlap_range(self)[0], self.steps_per_contact * step
        why = "with these steps_per_contact the elastic force of a step is a tenth of the tension"
        bounds.check_range("overlap", self.overlap, "m", limits, why)

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


def neck_ratio(p: PullOff) -> float:
    """Return the neck of JKR at its largest tension over the overlap of the start."""
    modulus, gamma = p.moduli[0] if p.moduli else 0.0, p.surface_energy or 0.0
    neck = contact.jkr_overlap("largest tension", gamma, modulus, p.effective_radius)
    return -neck / p.overlap or 1.0


class PullOffCase(ContactCase[PullOff]):
    """Largest tension and overlap at parting."""

    name = "pull-off"
    summary = "A sphere that sticks is pulled off: largest tension, and overlap where it parts."
    formula = (
        "DMT: 4 pi gamma R*, at touch. JKR: 3 pi gamma R*, at -a^2 / (3 R*) with a^3 = 9 pi gamma "
        "R*^2 / (4 E*); gamma is the energy of each surface. mdr, on each side of a flat with "
        "which a sphere has the energy gamma: 3/2 pi gamma R for small a / R, down to where no "
        "area is left."
    )
    parameters = PullOff
    quantities = (
        Quantity("pull_off_force_N", "N", "largest tension", lambda p: p.tension_and_overlap[0]),
        Quantity(
            "parting_ratio", "1", "overlap at the last force over that of the start", neck_ratio
        ),
    )
    laws: ClassVar = tables.pick("dmt", "jkr", "mdr, adhesion")
    systems: ClassVar = tables.systems("wall", "two spheres", "unequal spheres")

    def build(self, p: PullOff) -> Scene:
        """Return the pull, which parts half a step before the end."""
        steps = p.steps_per_contact
        bodies = p.bodies(-p.overlap)
        distance = p.overlap - p.tension_and_overlap[1]
        still = (ZERO,) * len(bodies)
        pull = Segment(
            steps=steps, velocities=((0.0, 0.0, p.speed), *still[1:]), angular_velocities=still
        )
        return Scene(
            bodies=bodies,
            walls=p.walls,
            law=p.stated_law,
            step=distance / p.speed / (steps - 0.5),
            steps=steps,
            segments=(pull,),
        )

    def observe(self, p: PullOff, motion: Motion) -> Mapping[str, float]:
        """Return the largest tension and the last overlap with a force."""
        force = motion.force[:, 0, 2]
        overlap, _ = overlap_and_rate(p, motion)
        last = int(np.flatnonzero(force)[-1])
        parted = last < len(force) - 1
        return {
            "pull_off_force_N": -float(force.min()),
            "parting_ratio": float(overlap[last]) / p.overlap if parted else math.nan,
        }

    def tolerance(self, p: PullOff, quantity: Quantity[PullOff]) -> Tolerance:
        """Return the tolerance; of mdr's tension a part of the elastic force at the start.

        t - sin(t) of an angle t = 0.03 from its cosine has a rounding of 2e-16 / t in t, which is
        3e-10 of t^3 / 6: so many digits of the elastic force are left where the forces nearly
        balance.
        """
        if p.normal != "mdr" or quantity.unit != "N":
            return super().tolerance(p, quantity)
        width = ROUND_OFF * p.elastic_force(p.overlap)
        return Tolerance(absolute=width, reason=ELLIPSE)

    def exact(self, p: PullOff) -> Mapping[str, float]:
        """Return tension and overlap where the sphere parts."""
        tension, last = p.tension_and_overlap
        return {"pull_off_force_N": tension, "parting_ratio": last / p.overlap}


CASE = PullOffCase()
