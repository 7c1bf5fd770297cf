"""Two spheres one upon the other between a floor and a ceiling, as in MFiX's DEM03."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from harness.cases.base import Quantity
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.parameters import ContactSystem, Density, Duration
from harness.model.scene import Motion, Scene, Wall, sphere

Offset = Annotated[float, Field(ge=-0.1, le=0.1)]  # as far as the squeeze may go


class Stacked(ContactSystem):
    """Two stacked spheres oscillate between plates: three contacts at a time.

    m1 x1'' = F(floor) - F(between) - m1 g, m2 x2'' = F(between) - F(ceiling) - m2 g,
    integrated; with linear springs a linear system of two oscillators.
    """

    quantities: ClassVar = tuple(
        Quantity(name, "1", text, lambda p: p.scale)
        for name, text in {
            "lower_height_ratio": "rise of the lower sphere over the squeeze",
            "upper_height_ratio": "rise of the upper sphere over the squeeze",
            "lower_speed_ratio": "velocity over omega times the squeeze",
            "upper_speed_ratio": "likewise, of the upper sphere",
        }.items()
    )

    allowed: ClassVar = {**ContactSystem.allowed, "partner": ("sphere",)}

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
            k = (self.youngs_modulus or 0.0) * self.contact_radius(self.squeezed / 3.0)
        return math.sqrt(k / self.mass)

    def check(self) -> None:
        """Raise ValueError for another material, and contacts that are too deep or too shallow."""
        for name in type(self).model_fields:
            of_partner = name.startswith("partner_") and name != "partner_radius"
            if of_partner and getattr(self, name) is not None:
                raise self.invalid(name, "must not be given: upper_density is that of this case")
        third, most = self.squeezed / 3.0, 0.5 * self.overlap_range[1]
        self.check_overlap("squeeze", third)
        upper = abs(self.upper_offset) * self.second_radius
        free = (most - third - upper) / self.radius
        reason = "no contact may begin with more than half the smaller radius: a swing doubles it"
        self.check_range("offset", -free, free, reason)
        if self.weight:
            most_gravity = self.gravity * most / self.rest_overlap(self.weight)
            self.check_range("gravity", 0.0, most_gravity, reason)

    @property
    def scale(self) -> float:
        """Return how far offsets and weight move the spheres, as a part of the squeeze."""
        offsets = abs(self.offset) * self.radius + abs(self.upper_offset) * self.second_radius
        return min(1.0, (offsets + self.rest_overlap(self.weight)) / self.squeezed) or 1.0

    def scene(self) -> Scene:
        """Return the spheres with the squeeze shared by the contacts, the lower one off."""
        r, upper = self.radius, self.second_radius
        top = 2.0 * (r + upper) - self.squeezed
        low = r - self.squeezed / 3.0 + self.offset * r
        high = top - upper + self.squeezed / 3.0 + self.upper_offset * upper
        steps = math.ceil(self.duration * self.steps_per_contact)
        bodies = (
            sphere(r, self.density, position=(0.0, 0.0, low)),
            sphere(upper, self.upper_density or self.density, position=(0.0, 0.0, high)),
        )
        return Scene(
            bodies=bodies,
            walls=(Wall(), Wall(point=(0.0, 0.0, top), direction=(0.0, 0.0, -1.0))),
            law=self.stated_law,
            gravity=(0.0, 0.0, -self.gravity),
            step=math.pi / self.omega / self.steps_per_contact,
            steps=steps,
            every=steps,
        )

    def observe(self, motion: Motion) -> Mapping[str, float]:
        """Return the rise of each sphere, and its velocity, at the end."""
        rise = (motion.position[-1, :, 2] - motion.position[0, :, 2]) / self.squeezed
        speed = motion.velocity[-1, :, 2] / self.squeezed / self.omega
        return {
            "lower_height_ratio": float(rise[0]),
            "upper_height_ratio": float(rise[1]),
            "lower_speed_ratio": float(speed[0]),
            "upper_speed_ratio": float(speed[1]),
        }


STACKED = ContactCase("stacked", Stacked)
