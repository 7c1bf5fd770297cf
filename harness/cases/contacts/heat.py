"""Heat through a contact at rest: between two spheres, and from a sphere to a wall."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import ContactSystem, Duration
from harness.errors import EngineOutputError
from harness.model.base import ZERO
from harness.model.motion import Motion
from harness.model.scene import Scene, Segment
from harness.theory.contact import conductance, cooling_rate

Temperature = Annotated[float, Field(ge=0.0, le=1e9)]


class Heat(ContactSystem):
    """Bodies of two temperatures, held in contact; SI units. A contact time is that of cooling."""

    conducts: ClassVar[bool] = True

    # fmt: off
    overlap: float = Field(1e-5, gt=0.0, description="[m] to which the sphere is pressed in")
    heat: Literal["radius", "area"] = Field(
        "radius", description="[-] conductance: that of a circle, 2 k a, or h pi a^2")
    conductance: float = Field(
        50.0, gt=0.0, le=1e15, description="[W/m/K] k of radius, [W/m2/K] h of area")
    heat_capacity: float = Field(500.0, ge=1e-9, le=1e9, description="[J/kg/K] of the spheres")
    temperature: Temperature = Field(400.0, description="[K] of the sphere, at the start")
    partner_temperature: Temperature = Field(
        300.0, description="[K] of the other sphere; a wall keeps it")
    duration: Duration = Field(2.0, description="[-] in times of the decay")
    # fmt: on

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        # a contact of other normal forces has another radius, or grows
        bounds.check_words(
            self, partner=("wall", "sphere"), normal=("hooke", "hertz"), interface=("current",)
        )
        bounds.check_overlap(self, "overlap", "m", self.overlap)
        if math.isclose(self.temperature, self.partner_temperature, rel_tol=1e-6):
            raise ValueError(
                f"partner_temperature = {self.partner_temperature!r} K: must not be that of the "
                "sphere: no heat flows"
            )

    @property
    def capacities(self) -> tuple[float, ...]:
        """Return the heat capacity of each body [J/K]; a wall has none."""
        masses = (self.mass,) if self.partner == "wall" else (self.mass, self.second_mass)
        return tuple(self.heat_capacity * mass for mass in masses)

    @property
    def rate(self) -> float:
        """Return the rate at which the difference decays [1/s]."""
        a = self.contact_radius(self.overlap)
        return cooling_rate(conductance(self.heat, self.conductance, a), self.capacities)


class HeatCase(ContactCase[Heat]):
    """Temperatures of two bodies in contact."""

    name = "heat"
    summary = "Heat flows through a contact: two temperatures approach, or that of a wall."
    formula = (
        "C_i T_i' = -+ G (T_1 - T_2), G = 2 k a or h pi a^2, a^2 = R* overlap: the difference "
        "decays as exp(-G (1/C_1 + 1/C_2) t), at a wall with 1/C_2 = 0; the heat of both stays."
    )
    parameters = Heat
    quantities = (
        Quantity(
            "halfway_excess_ratio", "1", "temperature of the first above that of the other at the "
            "start, over the difference then, halfway",
        ),
        Quantity("excess_ratio", "1", "likewise, at the end"),
        Quantity("partner_excess_ratio", "1", "that of the second, likewise"),
        Quantity(
            "heat_change_ratio", "1",
            "heat of both after less before, over that of the first above the other",
        ),
    )  # fmt: skip
    laws: ClassVar = tables.laws("heat")
    systems: ClassVar = tables.systems("wall", "two spheres", "unequal spheres")

    def build(self, p: Heat) -> Scene:
        """Return the bodies, held at rest."""
        steps = p.duration * p.steps_per_contact
        grid = bounds.quarters(p.duration, steps, p.duration / p.rate)
        temperatures = (p.temperature, p.partner_temperature)
        bodies = tuple(
            body.replace(temperature=temperature, heat_capacity=p.heat_capacity)
            for body, temperature in zip(p.bodies(-p.overlap), temperatures, strict=False)
        )
        still = (ZERO,) * len(bodies)
        return Scene(
            bodies=bodies,
            walls=tuple(wall.replace(temperature=p.partner_temperature) for wall in p.walls),
            law=p.stated_law,
            segments=(Segment(steps=grid["steps"], velocities=still, angular_velocities=still),),
            **grid,
        )

    def names(self, p: Heat) -> Iterable[str]:
        """Return all of two spheres, the first two at a wall."""
        names = [quantity.name for quantity in self.quantities]
        return names[:2] if p.partner == "wall" else names

    def observe(self, p: Heat, motion: Motion) -> Mapping[str, float]:
        """Return temperatures above that of the other at the start, and the heat of both."""
        if motion.temperature is None:
            raise EngineOutputError("the output has no temperatures")
        above = (motion.temperature - p.partner_temperature) / (
            p.temperature - p.partner_temperature
        )
        quantities = {
            "halfway_excess_ratio": float(above[len(above) // 2, 0]),
            "excess_ratio": float(above[-1, 0]),
        }
        if p.partner == "sphere":
            first, second = p.capacities
            heat = above[:, 0] + above[:, 1] * second / first
            quantities["partner_excess_ratio"] = float(above[-1, 1])
            quantities["heat_change_ratio"] = float(heat[-1] - heat[0])
        return quantities

    def exact(self, p: Heat) -> Mapping[str, float]:
        """Return the exponential approach to the temperature of both, or of the wall."""
        decay = [math.exp(-part * p.duration) for part in (0.5, 1.0)]
        if p.partner == "wall":
            return {"halfway_excess_ratio": decay[0], "excess_ratio": decay[1]}
        first, second = p.capacities
        mean = first / (first + second)
        halfway, end = (mean + (1.0 - mean) * part for part in decay)
        return {
            "halfway_excess_ratio": halfway,
            "excess_ratio": end,
            "partner_excess_ratio": mean * (1.0 - decay[1]),
            "heat_change_ratio": 0.0,
        }


CASE = HeatCase()
