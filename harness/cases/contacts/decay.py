"""Exponential decays: a fall in a viscous fluid, and heat through a contact at rest.

The fluid is LAMMPS's fix viscous: a force -drag v on each free body.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import ContactSystem, Duration, Gravity, quarters, ratios
from harness.errors import EngineOutputError
from harness.model.base import ZERO
from harness.model.scene import Motion, Scene, Segment
from harness.theory.contact import conductance, cooling_rate, dragged

Temperature = Annotated[float, Field(ge=0.0, le=1e9)]


class Drag(ContactSystem):
    """A falling sphere reaches its terminal velocity in a viscous fluid.

    m u' = m g - gamma u: u = v (1 - exp(-gamma t / m)), v = m g / gamma. The time in which steps
    are counted is m / gamma.
    """

    quantities: ClassVar = ratios(
        halfway_speed_over_terminal="speed of the fall over m g / gamma, halfway",
        speed_over_terminal="speed of the fall over m g / gamma, at the end",
        fall_ratio="height of the fall over m g / gamma times the time",
    )

    allowed: ClassVar = {**ContactSystem.allowed, "partner": ("wall",)}

    drag: float = Field(0.1, ge=1e-12, le=1e12, description="[kg/s] force over velocity")
    gravity: Gravity = Field(9.81, description="[m/s2] downward")
    duration: Duration = Field(2.0, description="[-] in times m / drag")

    def scene(self) -> Scene:
        """Return the sphere alone."""
        seconds = self.duration * self.mass / self.drag
        return Scene(
            bodies=self.bodies(0.0)[:1],
            law=self.stated_law,
            gravity=(0.0, 0.0, -self.gravity),
            drag=self.drag,
            **quarters(self.duration, self.duration * self.steps_per_contact, seconds),
        )

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the speed halfway, at the end and on average, over the terminal speed m g / c."""
        terminal_speed = self.gravity * self.mass / self.drag
        fall = -motion.velocity[:, 0, 2] / terminal_speed
        distance = float(motion.position[0, 0, 2] - motion.position[-1, 0, 2])
        return {
            "halfway_speed_over_terminal": float(fall[len(fall) // 2]),
            "speed_over_terminal": float(fall[-1]),
            "fall_ratio": distance / terminal_speed / float(motion.time[-1]),
        }

    def exact(self) -> Mapping[str, float]:
        """Return the exponential approach."""
        (halfway, _), (speed, fallen) = (dragged(t * self.duration) for t in (0.5, 1.0))
        return {
            "halfway_speed_over_terminal": halfway,
            "speed_over_terminal": speed,
            "fall_ratio": fallen / self.duration,
        }


class Heat(ContactSystem):
    """Heat flows through a contact: two temperatures approach, or that of a wall.

    C_i T_i' = -+ G (T_1 - T_2), G = 2 k a or h pi a^2, a^2 = R* overlap: the difference decays
    as exp(-G (1/C_1 + 1/C_2) t), at a wall with 1/C_2 = 0; the heat of both stays.
    """

    quantities: ClassVar = ratios(
        halfway_excess_ratio="temperature of the first above that of the other at the start, over "
        "the difference then, halfway",
        excess_ratio="likewise, at the end",
        partner_excess_ratio="that of the second, likewise",
        heat_change_ratio="heat of both after less before, over that of the first above the other",
    )

    # a contact of other normal forces has another radius, or grows
    allowed: ClassVar = {
        "partner": ("wall", "sphere"), "normal": ("hooke", "hertz"), "interface": ("current",),
    }  # fmt: skip

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
        """Raise ValueError for an overlap out of range, and equal temperatures."""
        self.check_overlap("overlap", self.overlap)
        if math.isclose(self.temperature, self.partner_temperature, rel_tol=1e-6):
            raise self.invalid("partner_temperature", "must not be that of the sphere: no heat")

    @property
    def capacities(self) -> tuple[float, ...]:
        """Return the heat capacity of each body [J/K]; a wall has none."""
        masses = (self.mass,) if self.partner == "wall" else (self.mass, self.second_mass)
        return tuple(self.heat_capacity * mass for mass in masses)

    def scene(self) -> Scene:
        """Return the bodies, fixed at rest for the times of the decay of their difference."""
        flow = conductance(self.heat, self.conductance, self.contact_radius(self.overlap))
        seconds = self.duration / cooling_rate(flow, self.capacities)
        grid = quarters(self.duration, self.duration * self.steps_per_contact, seconds)
        temperatures = (self.temperature, self.partner_temperature)
        bodies = tuple(
            body.replace(temperature=temperature, heat_capacity=self.heat_capacity)
            for body, temperature in zip(self.bodies(-self.overlap), temperatures, strict=False)
        )
        still = (ZERO,) * len(bodies)
        return Scene(
            bodies=bodies,
            walls=tuple(wall.replace(temperature=self.partner_temperature) for wall in self.walls),
            law=self.stated_law,
            segments=(Segment(steps=grid["steps"], velocities=still, angular_velocities=still),),
            **grid,
        )

    def absent(self) -> Collection[str]:
        """Return the quantities of the second sphere at a wall."""
        return ("partner_excess_ratio", "heat_change_ratio") if self.partner == "wall" else ()

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return temperatures above that of the other at the start, and the heat of both."""
        if motion.temperature is None:
            raise EngineOutputError("the output has no temperatures")
        difference = self.temperature - self.partner_temperature
        above = (motion.temperature - self.partner_temperature) / difference
        quantities = {
            "halfway_excess_ratio": float(above[len(above) // 2, 0]),
            "excess_ratio": float(above[-1, 0]),
        }
        if self.partner == "sphere":
            first, second = self.capacities
            heat = above[:, 0] + above[:, 1] * second / first
            quantities["partner_excess_ratio"] = float(above[-1, 1])
            quantities["heat_change_ratio"] = float(heat[-1] - heat[0])
        return quantities

    def exact(self) -> Mapping[str, float]:
        """Return the exponential approach to the temperature of both, or of the wall."""
        decay = [math.exp(-part * self.duration) for part in (0.5, 1.0)]
        if self.partner == "wall":
            return {"halfway_excess_ratio": decay[0], "excess_ratio": decay[1]}
        first, second = self.capacities
        mean = first / (first + second)
        halfway, end = (mean + (1.0 - mean) * part for part in decay)
        return {
            "halfway_excess_ratio": halfway,
            "excess_ratio": end,
            "partner_excess_ratio": mean * (1.0 - decay[1]),
            "heat_change_ratio": 0.0,
        }


DRAG = ContactCase("drag", Drag)
HEAT = ContactCase("heat", Heat)
