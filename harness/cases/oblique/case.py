"""The oblique impact: what friction makes of the velocity along the surface, and of the spin."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from harness.cases.contact_base.branches import RUBBING
from harness.cases.contact_base.contact_case import ContactCase, Friction
from harness.cases.contact_base.impact import impact, relative_velocity
from harness.cases.contact_base.motion import Motion
from harness.cases.contact_base.parameters import ContactSystem, Speed
from harness.cases.contact_base.presets import OBLIQUE, SLIDING, Told
from harness.cases.contact_base.scales import between, met
from harness.cases.contact_base.scans import Scan
from harness.cases.contact_base.submodels import SYSTEMS, TWO_MATERIALS
from harness.cases.contact_base.undamped import ROLLING_UNDAMPED
from harness.cases.contract import Study
from harness.comparison.findings import Findings
from harness.parameters.contact_scene import ContactScene
from harness.report.sections import Drawing, Plot, Section

if TYPE_CHECKING:
    from harness.cases.contact_base.evidence import Evidence, Tried


LEAST_ANGLE = 1e-6
"""[deg]: ratios of velocities are known to 1e-16 over its sine, 1e-8."""


class Oblique(ContactSystem):
    """An impact at an angle to the normal, in SI units and degrees."""

    speed: Speed = Field(1.0, description="[m/s] of the approach")
    angle: float = Field(45.0, ge=0.0, lt=90.0, description="[deg] to the normal")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        along, _, down = self.velocity
        met(self, "speed", "m/s", -down, lambda speed: speed * self.speed / -down)
        if along:
            why = "0, or more than what rounding leaves of the velocity along the surface"
            between("angle", self.angle, "deg", (LEAST_ANGLE, 90.0), why)

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Return the velocity of the sphere [m/s]: along x and down."""
        angle = math.radians(self.angle)
        return (self.speed * math.sin(angle), 0.0, -self.speed * math.cos(angle))


class ObliqueCase(Friction, ContactCase[Oblique]):
    """A sphere meets a wall or a sphere at an angle: velocity ratios and spin."""

    name = "oblique"
    sets: ClassVar[Told] = {"usual": SLIDING, **OBLIQUE}
    beside = (*Friction.beside, *ROLLING_UNDAMPED)
    shown = "tangential_ratio"
    systems: ClassVar[Told] = {**SYSTEMS, **TWO_MATERIALS}
    two_materials_of = "mindlin"
    submodels = (*Friction.submodels, *RUBBING)
    invariant = submodels
    over_ranks = ("mindlin_rescale/force", "old hooke/history")
    scan = Scan("tangential_ratio", "angle", (5.0, 15.0, 25.0, 35.0, 45.0, 55.0, 65.0, 75.0, 85.0))

    def drawings(self, evidence: Evidence) -> Sequence[Drawing]:
        """Return the velocity ratio over the angle, and the errors."""
        from harness.cases.oblique.figures import ratio_over_angle

        over_angle = Drawing(
            "oblique-ratio",
            "oblique: velocity ratio over the angle",
            "Tangential velocity after over that before, by law, for a sphere on a wall.",
            lambda: ratio_over_angle(self, evidence.climbed, evidence.who),
        )
        return (over_angle, *super().drawings(evidence))

    def verify_own(self, study: Study) -> Findings:
        """Hold Mindlin's laws, which stick as a whole, beside partial slip."""
        from harness.cases.oblique.partial_slip import beside_partial_slip

        return Findings(self.name) if study.level == "quick" else beside_partial_slip(self)

    def sections(
        self, main: Findings | None, own: Findings, beside: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Add the curve of partial slip to what every contact case tells."""
        from harness.cases.oblique.partial_slip import drawn_beside

        made = super().sections(main, own, beside)
        further = drawn_beside(own.evidence or {})
        return [replace(one, drawings=(*one.drawings, *further)) for one in made]

    def plot(self, one: Tried, who: str) -> Plot:
        """Return the velocity ratio over the angle; of mdr between spheres the motion alone."""
        from harness.cases.contact_base.curves import ratio_plot
        from harness.cases.oblique.figures import OVER_ANGLE

        if one.finest.normal == "mdr" and one.finest.partner != "wall":
            # its integration takes seconds at glancing angles, with a bulk response minutes
            return super().plot(one, who)
        return ratio_plot(self, one, who, OVER_ANGLE)

    def scene(self, parameters: Oblique) -> ContactScene:
        """Return the impact; samples before and after it."""
        return impact(parameters, parameters.velocity, finely=False)

    def observed(self, parameters: Oblique, motion: Motion) -> Mapping[str, float]:
        """Return ratios of the velocities after to those before; tangential ones at an angle."""
        along, _, down = parameters.velocity
        before, after = relative_velocity(motion)[[0, -1]]
        found = {"normal_restitution": float(after[2]) / -down}
        if along > 0.0:
            found["tangential_ratio"] = float(after[0]) / along
            found["rim_speed_ratio"] = parameters.radius * float(motion.omega[-1, 0, 1]) / along
            impulses = before[0] - after[0], after[2] - before[2]
            found["tangential_impulse_ratio"] = float(impulses[0] / impulses[1])
        return found

    def sizes(self, parameters: Oblique) -> Mapping[str, float]:
        """Return Coulomb's limit of the impulses' ratio, 1 at most: a larger one is not reached."""
        return {"tangential_impulse_ratio": min(parameters.friction or 1.0, 1.0)}


CASE = ObliqueCase()
