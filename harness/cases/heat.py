"""Heat through a contact at rest: between two spheres, and from a sphere to a wall."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import (
    ContactSystem,
    Duration,
    counted,
    meets,
    pressed,
)
from harness.cases.contact.submodels import HERTZ, HOOKE, Told, named
from harness.cases.contact.surroundings import refused
from harness.model.scene import Scene
from harness.parameters.scene import ZERO, Body, ContactScene, Segment
from harness.theory.contact import conductance, cooling_rate

SAMPLES = 4

Temperature = Annotated[float, Field(ge=0.0, le=1e9)]
"""[K]"""


class Heat(ContactSystem):
    """Bodies of two temperatures, held in contact; SI units. A contact time is that of cooling."""

    overlap: float = Field(1e-5, gt=0.0, description="[m] to which the sphere is pressed in")
    heat: Literal["radius", "area"] = Field(
        "radius", description="[-] conductance: that of a circle, 2 k a, or h pi a^2"
    )
    conductance: float = Field(
        50.0, gt=0.0, le=1e15, description="[W/m/K] k of radius, [W/m2/K] h of area"
    )
    heat_capacity: float = Field(500.0, ge=1e-9, le=1e9, description="[J/kg/K] of the spheres")
    temperature: Temperature = Field(400.0, description="[K] of the sphere, at the start")
    partner_temperature: Temperature = Field(
        300.0, description="[K] of what it meets; a wall keeps it"
    )
    duration: Duration = Field(2.0, description="[-] in times of the decay")

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        meets(self, "wall", "sphere")
        # a contact of others has another radius, or grows
        refused(self, normal=("hooke", "hertz"), interface=("current",))
        pressed(self, "overlap", "m", self.overlap)
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
        a = math.sqrt(self.reduced_radius * self.overlap)
        return cooling_rate(conductance(self.heat, self.conductance, a), self.capacities)

    @property
    def difference(self) -> float:
        """Return the difference in temperature at the start [K]."""
        return self.temperature - self.partner_temperature


class HeatCase(ContactCase[Heat]):
    """Heat flows through a contact: two temperatures approach one another, or that of a wall."""

    name = "heat"
    submodels = named(
        {
            "heat radius, hooke": {**HOOKE, "heat": "radius", "conductance": 50.0},
            "heat area, hooke": {**HOOKE, "heat": "area", "conductance": 2e5},
            "heat radius, hertz": {**HERTZ, "heat": "radius", "conductance": 50.0},
            "heat area, hertz": {**HERTZ, "heat": "area", "conductance": 2e5},
        }
    )
    systems: ClassVar[Told] = {
        "wall": {"partner": "wall", "partner_radius": None},
        "two spheres": {"partner": "sphere", "partner_radius": None},
        "unequal spheres": {"partner": "sphere", "partner_radius": 0.02},
    }
    sets: ClassVar[Told] = {"cools": HOOKE}

    def scene(self, parameters: Heat) -> ContactScene:
        """Return the bodies, held at rest."""
        n = parameters.steps_per_contact
        counted(parameters, parameters.duration * n)
        every = max(1, round(parameters.duration * n / SAMPLES))
        bodies = self._bodies(parameters)
        still = (ZERO,) * len(bodies)
        return ContactScene(
            bodies,
            parameters.planes,
            parameters.law,
            step=parameters.duration / parameters.rate / SAMPLES / every,
            steps=SAMPLES * every,
            every=every,
            segments=(Segment(SAMPLES * every, still, still),),
        )

    def setup(self, parameters: Heat) -> Scene:
        """Return the scene with what conducts, and the temperatures."""
        scene = super().setup(parameters)
        law = scene.law.replace(heat=parameters.heat, conductance=parameters.conductance)
        temperatures = (parameters.temperature, parameters.partner_temperature)
        bodies = tuple(
            body.replace(temperature=temperature, heat_capacity=parameters.heat_capacity)
            for body, temperature in zip(scene.bodies, temperatures, strict=False)
        )
        walls = (w.replace(temperature=parameters.partner_temperature) for w in scene.walls)
        return scene.replace(law=law, bodies=bodies, walls=tuple(walls))

    def _bodies(self, parameters: Heat) -> tuple[Body, ...]:
        return tuple(parameters.bodies(-parameters.overlap, ZERO))

    def observed(self, parameters: Heat, motion: Motion) -> Mapping[str, float]:
        """Return the temperature above that of the other at the start, and the heat of both."""
        if motion.temperature is None:
            return {}
        above = (motion.temperature - parameters.partner_temperature) / parameters.difference
        quantities = {
            "halfway_excess_ratio": float(above[len(above) // 2, 0]),
            "excess_ratio": float(above[-1, 0]),
        }
        if parameters.partner == "sphere":
            first, second = parameters.capacities
            heat = above[:, 0] + above[:, 1] * second / first
            quantities["partner_excess_ratio"] = float(above[-1, 1])
            quantities["heat_change_ratio"] = float(heat[-1] - heat[0])
        return quantities

    def closed_forms(self, parameters: Heat) -> Mapping[str, float]:
        """Return the exponential approach to the temperature of both, or of the wall."""
        decay = [math.exp(-part * parameters.duration) for part in (0.5, 1.0)]
        if parameters.partner == "wall":
            return {"halfway_excess_ratio": decay[0], "excess_ratio": decay[1]}
        first, second = parameters.capacities
        mean = first / (first + second)
        halfway, end = (mean + (1.0 - mean) * part for part in decay)
        return {
            "halfway_excess_ratio": halfway,
            "excess_ratio": end,
            "partner_excess_ratio": mean * (1.0 - decay[1]),
            "heat_change_ratio": 0.0,
        }


CASE = HeatCase()
