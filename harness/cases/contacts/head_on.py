"""A sphere hits a wall or another sphere head-on: normal force and damping alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.impact import (
    head_on_exact,
    impact_scene,
    overlap_and_rate,
    peak,
    relative_velocity,
    value_at_turn,
)
from harness.cases.contacts.laws import (
    CLIPPED_NORMAL,
    COHESIVE,
    MDR_BRANCHES,
    MDR_TOGETHER,
    NORMAL,
    OLD_CLIPPED,
    OLD_NORMAL,
    SYSTEMS,
    TWO_MATERIALS,
)
from harness.cases.contacts.parameters import ContactSystem, Speed, check_impact
from harness.model.motion import Motion
from harness.model.scene import Scene


class HeadOn(ContactSystem):
    """A head-on impact, in SI units."""

    speed: Speed = Field(1.0, description="[m/s] of the approach")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        check_impact(self, "speed", "m/s", self.speed, lambda speed: speed)

    @property
    def depth(self) -> float:
        """Return the largest overlap without damping [m]."""
        return self.elastic_overlap(self.speed)


class HeadOnCase(ContactCase[HeadOn]):
    """Restitution, contact time and peaks of a head-on impact."""

    name = "head-on"
    summary = "A sphere hits a wall or a sphere head-on: restitution, contact time, peaks."
    formula = (
        "Linear spring: e = exp(-pi zeta / sqrt(1 - zeta^2)), contact time pi / (omega sqrt(1 - "
        "zeta^2)); Hertz: largest overlap (15 m* v^2 / (16 E* sqrt(R*)))^(2/5); constant "
        "restitution at every speed; the rest is integrated."
    )
    parameters = HeadOn
    quantities = (
        Quantity[HeadOn]("restitution", "1", "speed of departure over that of approach"),
        Quantity[HeadOn](
            "contact_time_s", "s", "of the first contact, while the surfaces overlap",
            lambda p: 2.0 * p.depth / p.speed,
        ),
        Quantity[HeadOn](
            "largest_overlap_m", "m", "overlap at the turning point, between the samples",
            lambda p: 0.5 * p.depth,
        ),
        Quantity[HeadOn](
            "largest_force_N", "N", "on the sphere, the dashpot's part included",
            lambda p: p.elastic_force(p.depth),
        ),
    )  # fmt: skip
    laws: ClassVar = {
        **NORMAL, **COHESIVE, **OLD_NORMAL, **MDR_BRANCHES, **OLD_CLIPPED, **MDR_TOGETHER,
        **CLIPPED_NORMAL,
    }  # fmt: skip
    systems: ClassVar = {**SYSTEMS, **TWO_MATERIALS}
    usual: ClassVar = {"elastic": {}}
    varied = tuple({**NORMAL, **COHESIVE, **OLD_NORMAL, **MDR_BRANCHES, **MDR_TOGETHER})
    varied_by_default = ("jkr", "mdr, yield")

    def build(self, parameters: HeadOn) -> Scene:
        """Return the impact, sampled over the contact."""
        return impact_scene(parameters, (0.0, 0.0, -parameters.speed), sampled=True)

    def names(self, parameters: HeadOn) -> Iterable[str]:
        """Return all, without contact time and overlap where a surface energy makes them stick."""
        names = [quantity.name for quantity in self.quantities]
        sticks = parameters.surface_energy is not None
        return [n for n in names if not sticks or n not in ("contact_time_s", "largest_overlap_m")]

    def observe(self, parameters: HeadOn, motion: Motion) -> Mapping[str, float]:
        """Return restitution and peaks; contact time and overlap where nothing sticks."""
        overlap, rate = overlap_and_rate(parameters, motion)
        quantities = {
            "restitution": float(relative_velocity(motion)[-1, 2]) / parameters.speed,
            "largest_force_N": peak(motion.force[:, 0, 2]),
        }
        if parameters.surface_energy is None:
            # at the ends of the run it flies freely, with the gap that is left
            begin, end = (motion.time[i] - overlap[i] / rate[i] for i in (0, -1))
            quantities["contact_time_s"] = float(end - begin)
            quantities["largest_overlap_m"] = value_at_turn(motion.time, overlap, rate)
        return quantities

    def exact(self, parameters: HeadOn) -> Mapping[str, float]:
        """Return what is known of linear springs, Hertz's, and constant restitution."""
        return head_on_exact(parameters, parameters.speed)


CASE = HeadOnCase()
