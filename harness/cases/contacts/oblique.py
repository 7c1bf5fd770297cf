"""A sphere hits a wall or another sphere at an angle: friction over a whole contact."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, partial_slip, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.impact import impact_scene, relative_velocity
from harness.cases.contacts.parameters import ContactSystem, Speed
from harness.model.base import Vector
from harness.model.motion import Motion
from harness.model.scene import Scene

if TYPE_CHECKING:
    from harness.cases.base import Check, Level
    from harness.cases.bench import Bench
    from harness.engines.base import Engine
    from harness.report.content import Drawing

LEAST_ANGLE = 1e-6  # [deg]: ratios of velocities are known to 1e-16 over its sine, 1e-8


class Oblique(ContactSystem):
    """An impact at an angle to the normal, in SI units and degrees."""

    speed: Speed = Field(1.0, description="[m/s] of the approach")
    angle: float = Field(45.0, ge=0.0, lt=90.0, description="[deg] to the normal")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        along, _, down = self.velocity
        bounds.check_impact(self, "speed", "m/s", -down, lambda speed: speed * self.speed / -down)
        if along:
            why = "0, or more than what rounding leaves of the velocity along the surface"
            bounds.check_range("angle", self.angle, "deg", (LEAST_ANGLE, 90.0), why)

    @property
    def velocity(self) -> Vector:
        """Return the velocity of the sphere [m/s]: along x and down."""
        angle = math.radians(self.angle)
        return (self.speed * math.sin(angle), 0.0, -self.speed * math.cos(angle))


def impulse_scale(p: Oblique) -> float:
    """Return Coulomb's limit of the ratio of impulses, 1 at most: a larger one is not reached."""
    return min(p.friction or 1.0, 1.0)


QUANTITIES: Sequence[Quantity[Any]] = (
    Quantity("normal_restitution", "1", "normal speed after over that before"),
    Quantity("tangential_ratio", "1", "tangential velocity of the centre, likewise"),
    Quantity(
        "rim_speed_ratio", "1",
        "radius times spin at the end over the tangential velocity at the start",
    ),
    Quantity(
        "tangential_impulse_ratio", "1", "tangential over normal impulse: at most mu where the "
        "normal force never pulls, else mu times the integral of |F_n| over that of F_n",
        impulse_scale,
    ),
)  # fmt: skip


class ObliqueCase(ContactCase[Oblique]):
    """Velocity ratios and spin after an impact at an angle."""

    name = "oblique"
    summary = "A sphere hits a wall or a sphere at an angle: velocity ratios and spin."
    formula = (
        "Integrated under the code's conventions. Where it slides throughout and the normal force "
        "never pulls, vx'/vx = 1 - mu (1 + e) vn/vx, r omega' = 5/2 mu (1 + e) vn on a wall."
    )
    parameters = Oblique
    quantities = QUANTITIES
    laws: ClassVar = tables.laws(
        "tangential", "old_tangential", "mdr_friction", "mdr_friction_of_one_size",
        "further_tangential", "undamped_rolling", "friction_of_each",
    )  # fmt: skip
    systems: ClassVar = tables.SYSTEMS | tables.TWO_MATERIALS | tables.MIXED
    always = tuple(tables.MIXED)
    two_materials_law = "mindlin"
    varied = tuple(
        tables.laws("tangential", "old_tangential", "mdr_friction", "mdr_friction_of_one_size")
    )
    varied_by_default = ("mindlin_rescale/force", "old hooke/history")

    def checks_up_to(self, engine: Engine, level: Level) -> Iterator[Check]:
        """Yield the checks of trials, and those that are drawn with the curve of partial slip."""
        yield from super().checks_up_to(engine, level)
        if level != "quick":
            yield from partial_slip.checks(self, engine)

    def own_checks(self) -> Iterator[Check]:
        """Yield the distance of each of Mindlin's laws from partial slip, as findings."""
        yield from partial_slip.own_checks(self)

    def drawings(self, benches: Mapping[str, Bench]) -> Sequence[Drawing]:
        """Return the curve of partial slip with laws and codes."""
        drawing = partial_slip.drawing(self, benches)
        return () if drawing is None else (drawing,)

    def build(self, p: Oblique) -> Scene:
        """Return the impact; samples before and after it."""
        return impact_scene(p, p.velocity, sampled=False)

    def names(self, p: Oblique) -> Iterable[str]:
        """Return all at an angle, else the normal restitution."""
        names = [quantity.name for quantity in self.quantities]
        return names if p.velocity[0] > 0.0 else names[:1]

    def observe(self, p: Oblique, motion: Motion) -> Mapping[str, float]:
        """Return ratios of the velocities after to those before; tangential ones at an angle."""
        return velocity_ratios(p, motion)


def velocity_ratios(p: Oblique, motion: Motion) -> dict[str, float]:
    """Return the quantities of an impact at an angle, by name."""
    along, _, down = p.velocity
    before, after = relative_velocity(motion)[[0, -1]]
    quantities = {"normal_restitution": float(after[2]) / -down}
    if along > 0.0:
        quantities["tangential_ratio"] = float(after[0]) / along
        spin = float(motion.angular_velocity[-1, 0, 1])
        quantities["rim_speed_ratio"] = p.radius * spin / along
        impulses = before[0] - after[0], after[2] - before[2]
        quantities["tangential_impulse_ratio"] = float(impulses[0] / impulses[1])
    return quantities


CASE = ObliqueCase()
