"""Two spheres one upon the other between a floor and a ceiling, as in MFiX's DEM03."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import ContactSystem, Density, Duration
from harness.model.motion import Motion
from harness.model.scene import Scene, Wall, sphere

Offset = Annotated[float, Field(ge=-0.1, le=0.1)]  # as far as the squeeze may go


class Stacked(ContactSystem):
    """Two spheres that fill the room between two plates and more; in SI units."""

    # fmt: off
    squeeze: float = Field(0.005, gt=0.0, le=0.1, description="[-] of the height of both spheres")
    offset: Offset = Field(0.002, description="[-] of the lower sphere's radius, up, at the start")
    upper_offset: Offset = Field(0.0, description="[-] likewise, of the upper sphere")
    upper_density: Density | None = Field(
        None, description="[kg/m3] of the upper sphere; that of the lower unless given")
    gravity: float = Field(9.81, ge=0.0, le=1e9, description="[m/s2] downward")
    duration: Duration = Field(6.0, description="[-] in half periods pi sqrt(m / k)")
    # fmt: on

    @property
    def squeezed(self) -> float:
        """Return the height of the spheres less that of the room [m]."""
        return 2.0 * self.squeeze * (self.radius + self.second_radius)

    @property
    def upper_mass(self) -> float:
        """Return the mass of the upper sphere [kg]."""
        return sphere(self.second_radius, self.upper_density or self.density).mass

    @property
    def weight(self) -> float:
        """Return the weight of both spheres [N]."""
        return (self.mass + self.upper_mass) * self.gravity

    @property
    def omega(self) -> float:
        """Return sqrt(k / m) [1/s] with the stiffness at a third of the squeeze."""
        k = self.normal_stiffness
        if k is None:
            assert self.youngs_modulus is not None
            k = self.youngs_modulus * self.contact_radius(self.squeezed / 3.0)
        return math.sqrt(k / self.mass)

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        bounds.check_words(self, partner=("sphere",))
        if self.partner_density is not None:
            raise ValueError(
                f"partner_density = {self.partner_density!r}: upper_density is that of this case"
            )
        if self.two_materials:
            raise ValueError(
                "partner_youngs_modulus, partner_poisson_ratio: spheres and plates are of one "
                "material in this case"
            )
        third, most = self.squeezed / 3.0, 0.5 * bounds.overlap_range(self)[1]
        bounds.check_overlap(self, "squeeze", "", third)
        upper = abs(self.upper_offset) * self.second_radius
        free = (most - third - upper) / self.radius
        why = "no contact may begin with more than half the smaller radius: a swing doubles it"
        bounds.check_range("offset", self.offset, "", (-free, free), why)
        if self.weight:
            most_gravity = 2.0 * self.elastic_energy(most) / most / self.weight * self.gravity
            bounds.check_range("gravity", self.gravity, "m/s2", (0.0, most_gravity), why)
        light = 2.0 * self.mass / (bounds.COARSEST * self.steps_per_contact / math.pi) ** 2
        density = self.density if self.upper_density is None else self.upper_density
        least = light / self.upper_mass * density
        limits = (least, math.inf)
        bounds.check_range("upper_density", density, "kg/m3", limits, "its steps are too long")

    @property
    def scale(self) -> float:
        """Return how far offsets and weight move the spheres, as a part of the squeeze."""
        offsets = abs(self.offset) * self.radius + abs(self.upper_offset) * self.second_radius
        return min(1.0, (offsets + self.rest_overlap(self.weight)) / self.squeezed) or 1.0


def _quantity(name: str, meaning: str) -> Quantity[Stacked]:
    return Quantity(name, "1", meaning, lambda p: p.scale)


class StackedCase(ContactCase[Stacked]):
    """Heights and speeds of two spheres with three contacts."""

    name = "stacked"
    summary = "Two stacked spheres oscillate between plates: three contacts at a time."
    formula = (
        "m1 x1'' = F(floor) - F(between) - m1 g, m2 x2'' = F(between) - F(ceiling) - m2 g, "
        "integrated; with linear springs a linear system of two oscillators."
    )
    parameters = Stacked
    quantities = (
        _quantity("lower_height_ratio", "rise of the lower sphere over the squeeze"),
        _quantity("upper_height_ratio", "rise of the upper sphere over the squeeze"),
        _quantity("lower_speed_ratio", "velocity over omega times the squeeze"),
        _quantity("upper_speed_ratio", "likewise, of the upper sphere"),
    )
    laws: ClassVar = dict(
        sorted(
            tables.laws("normal", "clipped").items(),
            key=lambda row: "clipped" in row[1].law,
        )
    )
    systems: ClassVar = {
        "between plates": {"partner": "sphere", "partner_radius": None},
        "unequal, between plates": {"partner": "sphere", "partner_radius": 0.012},
    }

    def build(self, p: Stacked) -> Scene:
        """Return the spheres with the squeeze shared by the contacts, the lower one off."""
        r, upper = p.radius, p.second_radius
        top = 2.0 * (r + upper) - p.squeezed
        low = r - p.squeezed / 3.0 + p.offset * r
        high = top - upper + p.squeezed / 3.0 + p.upper_offset * upper
        steps = bounds.count_steps(p.duration, p.duration * p.steps_per_contact)
        step = math.pi / p.omega / p.steps_per_contact
        bodies = (
            sphere(r, p.density, position=(0.0, 0.0, low)),
            sphere(upper, p.upper_density or p.density, position=(0.0, 0.0, high)),
        )
        bounds.check_steps(p, bodies, step, p.squeezed / 3.0)
        return Scene(
            bodies=bodies,
            walls=(Wall(), Wall(point=(0.0, 0.0, top), direction=(0.0, 0.0, -1.0))),
            law=p.stated_law,
            gravity=(0.0, 0.0, -p.gravity),
            step=step,
            steps=steps,
            every=steps,
        )

    def observe(self, p: Stacked, motion: Motion) -> Mapping[str, float]:
        """Return the rise of each sphere, and its velocity, at the end."""
        rise = (motion.position[-1, :, 2] - motion.position[0, :, 2]) / p.squeezed
        speed = motion.velocity[-1, :, 2] / p.squeezed / p.omega
        return {
            "lower_height_ratio": float(rise[0]),
            "upper_height_ratio": float(rise[1]),
            "lower_speed_ratio": float(speed[0]),
            "upper_speed_ratio": float(speed[1]),
        }


CASE = StackedCase()
