"""A sphere hits a wall or another sphere head-on: normal force and damping alone."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.impact import (
    head_on_exact,
    impact_scene,
    overlap_and_rate,
    peak,
    relative_velocity,
    value_at_turn,
)
from harness.cases.contacts.parameters import ContactSystem, Speed
from harness.model.motion import Motion
from harness.model.scene import Scene


class HeadOn(ContactSystem):
    """A head-on impact, in SI units."""

    speed: Speed = Field(1.0, description="[m/s] of the approach")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        bounds.check_impact(self, "speed", "m/s", self.speed, lambda speed: speed)

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
        Quantity("restitution", "1", "speed of departure over that of approach"),
        Quantity(
            "contact_time_s", "s", "of the first contact, while the surfaces overlap",
            lambda p: 2.0 * p.depth / p.speed,
        ),
        Quantity(
            "largest_overlap_m", "m", "overlap at the turning point, between the samples",
            lambda p: 0.5 * p.depth,
        ),
        Quantity(
            "largest_force_N", "N", "on the sphere, the dashpot's part included",
            lambda p: p.elastic_force(p.depth),
        ),
    )  # fmt: skip
    laws: ClassVar = tables.laws(
        "normal", "cohesive", "old", "mdr_damping", "mdr_yield", "mdr_bulk", "old_clipped",
        "mdr_together", "clipped", "restitution_of_each",
    )  # fmt: skip
    systems: ClassVar = tables.SYSTEMS | tables.TWO_MATERIALS | tables.MIXED
    always = tuple(tables.MIXED)
    varied = tuple(
        tables.laws(
            "normal", "cohesive", "old", "mdr_damping", "mdr_yield", "mdr_bulk", "mdr_together"
        )
    )
    varied_by_default = ("jkr", "mdr, yield")

    def build(self, p: HeadOn) -> Scene:
        """Return the impact, sampled over the contact."""
        return impact_scene(p, (0.0, 0.0, -p.speed), sampled=True)

    def names(self, p: HeadOn) -> Iterable[str]:
        """Return all, without contact time and overlap where a surface energy makes them stick."""
        names = [quantity.name for quantity in self.quantities]
        sticks = p.surface_energy is not None
        return [n for n in names if not sticks or n not in ("contact_time_s", "largest_overlap_m")]

    def observe(self, p: HeadOn, motion: Motion) -> Mapping[str, float]:
        """Return restitution and peaks; contact time and overlap where nothing sticks."""
        overlap, rate = overlap_and_rate(p, motion)
        quantities = {
            "restitution": float(relative_velocity(motion)[-1, 2]) / p.speed,
            "largest_force_N": peak(motion.force[:, 0, 2]),
        }
        if p.surface_energy is None:
            # at the ends of the run it flies freely, with the gap that is left
            begin, end = (motion.time[i] - overlap[i] / rate[i] for i in (0, -1))
            quantities["contact_time_s"] = float(end - begin)
            quantities["largest_overlap_m"] = value_at_turn(motion.time, overlap, rate)
        return quantities

    def exact(self, p: HeadOn) -> Mapping[str, float]:
        """Return what is known of linear springs, Hertz's, and constant restitution."""
        return head_on_exact(p, p.speed)


CASE = HeadOnCase()
