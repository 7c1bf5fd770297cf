"""Two spheres one upon the other between a floor and a ceiling, as in MFiX's DEM03."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, ClassVar

from pydantic import Field

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.motion import Motion
from harness.cases.contact.parameters import (
    COARSEST,
    FLOOR,
    ContactSystem,
    Density,
    Duration,
    between,
    counted,
    energy,
    meets,
    overlaps,
    pressed,
    resolved,
    rest_overlap,
)
from harness.cases.contact.submodels import NORMAL, NORMAL_BESIDE, Told
from harness.cases.contact.submodels import STACKED as MFIX
from harness.parameters.scene import Body, ContactScene, Plane, sphere_mass

Offset = Annotated[float, Field(ge=-0.1, le=0.1)]
"""Of a radius: as far as the squeeze may go."""


class Stacked(ContactSystem):
    """Two spheres that fill the room between two plates and more; in SI units."""

    squeeze: float = Field(0.005, gt=0.0, le=0.1, description="[-] of the height of both spheres")
    offset: Offset = Field(0.002, description="[-] of the lower sphere's radius, up, at the start")
    upper_offset: Offset = Field(0.0, description="[-] likewise, of the upper sphere")
    upper_density: Density | None = Field(
        None, description="[kg/m3] of the upper sphere; that of the lower unless given"
    )
    gravity: float = Field(9.81, ge=0.0, le=1e9, description="[m/s2] downward")
    duration: Duration = Field(6.0, description="[-] in half periods pi sqrt(m / k)")

    @property
    def squeezed(self) -> float:
        """Return how much higher the spheres are than the room [m]."""
        return 2.0 * self.squeeze * (self.radius + self.second_radius)

    @property
    def upper_mass(self) -> float:
        """Return the mass of the upper sphere [kg]."""
        return sphere_mass(self.second_radius, self.upper_density or self.density)

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        meets(self, "sphere")
        if self.partner_density is not None:
            raise ValueError(
                f"partner_density = {self.partner_density!r}: upper_density is that of this case"
            )
        if self.two_materials:
            raise ValueError(
                "partner_youngs_modulus, partner_poisson_ratio: spheres and plates are of one "
                "material in this case"
            )
        third, most = self.squeezed / 3.0, 0.5 * overlaps(self)[1]
        pressed(self, "squeeze", "", third)
        upper = abs(self.upper_offset) * self.second_radius
        free = (most - third - upper) / self.radius
        why = "no contact may begin with more than half the smaller radius: what swings doubles it"
        between("offset", self.offset, "", (-free, free), why)
        weight = (self.mass + self.upper_mass) * self.gravity
        if weight:
            load = 2.0 * energy(self, most) / most / weight * self.gravity
            between("gravity", self.gravity, "m/s2", (0.0, load), why)
        light = 2.0 * self.mass / (COARSEST * self.steps_per_contact / math.pi) ** 2
        density = self.density if self.upper_density is None else self.upper_density
        least = light / self.upper_mass * density
        between("upper_density", density, "kg/m3", (least, math.inf), "its steps are too long")


class StackedCase(ContactCase[Stacked]):
    """Two stacked spheres oscillate between plates: three contacts at a time."""

    name = "stacked"
    submodels = tuple(submodel for submodel in NORMAL if "clipped" not in submodel.name)
    other_submodels = tuple(
        submodel for submodel in (*NORMAL, *NORMAL_BESIDE) if "clipped" in submodel.name
    )
    sets: ClassVar[Told] = {"usual": {"partner": "sphere", **NORMAL[1].law}, **MFIX}
    lasts = True
    systems: ClassVar[Told] = {
        "between plates": {"partner": "sphere", "partner_radius": None},
        "unequal, between plates": {"partner": "sphere", "partner_radius": 0.012},
    }

    def scene(self, parameters: Stacked) -> ContactScene:
        """Return the spheres with the room's squeeze shared by the contacts, the lower one off."""
        r, upper = parameters.radius, parameters.second_radius
        squeeze = parameters.squeezed
        top = 2.0 * (r + upper) - squeeze
        low = r - squeeze / 3.0 + parameters.offset * r
        high = top - upper + squeeze / 3.0 + parameters.upper_offset * upper
        step = math.pi / self._omega(parameters) / parameters.steps_per_contact
        steps = counted(parameters, parameters.duration * parameters.steps_per_contact)
        scene = ContactScene(
            (
                Body(r, parameters.mass, (0.0, 0.0, low)),
                Body(upper, parameters.upper_mass, (0.0, 0.0, high)),
            ),
            (FLOOR, Plane((0.0, 0.0, top), (0.0, 0.0, -1.0))),
            parameters.law,
            step=step,
            steps=steps,
            every=steps,
            gravity=(0.0, 0.0, -parameters.gravity),
        )
        return resolved(parameters, scene, squeeze / 3.0)

    def observed(self, parameters: Stacked, motion: Motion) -> Mapping[str, float]:
        """Return how far each sphere rose, and its velocity, at the end."""
        squeeze = parameters.squeezed
        rise = (motion.position[-1, :, 2] - motion.position[0, :, 2]) / squeeze
        speed = motion.velocity[-1, :, 2] / squeeze / self._omega(parameters)
        return {
            "lower_height_ratio": float(rise[0]),
            "upper_height_ratio": float(rise[1]),
            "lower_speed_ratio": float(speed[0]),
            "upper_speed_ratio": float(speed[1]),
        }

    def sizes(self, parameters: Stacked) -> Mapping[str, float]:
        """Return how far what is off and what weighs moves the spheres, as part of the squeeze."""
        off = abs(parameters.offset) * parameters.radius
        off += abs(parameters.upper_offset) * parameters.second_radius
        weight = (parameters.mass + parameters.upper_mass) * parameters.gravity
        size = min(1.0, (off + rest_overlap(parameters, weight)) / parameters.squeezed) or 1.0
        names = (quantity.name for quantity in self.quantities)
        return dict.fromkeys(names, size)

    def _omega(self, parameters: Stacked) -> float:
        """Return sqrt(k / m) [1/s] with the stiffness at a third of the squeeze."""
        k = parameters.normal_stiffness
        if k is None:
            curved = math.sqrt(parameters.reduced_radius * parameters.squeezed / 3.0)
            assert parameters.youngs_modulus is not None
            k = parameters.youngs_modulus * curved
        return math.sqrt(k / parameters.mass)


CASE = StackedCase()
