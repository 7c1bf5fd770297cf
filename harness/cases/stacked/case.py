"""Two spheres one upon the other between a floor and a ceiling, as in MFiX's DEM03."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import Field

from harness.cases.contact_base.contact_case import ContactCase
from harness.cases.contact_base.motion import Array, Motion
from harness.cases.contact_base.parameters import FLOOR, ContactSystem
from harness.cases.contact_base.presets import STACKED as MFIX
from harness.cases.contact_base.scans import Scan
from harness.cases.contact_base.submodels import NORMAL, NORMAL_BESIDE
from harness.observables.declared import Observable
from harness.parameters.contact_scene import Body, ContactScene, Plane, sphere_mass


class Stacked(ContactSystem):
    """Two spheres that fill the room between two plates and more; in SI units."""

    squeeze: float = Field(0.005, gt=0.0, le=0.1, description="[-] of the height of both spheres")
    offset: float = Field(0.002, description="[-] of the lower sphere's radius, up, at the start")
    upper_offset: float = Field(0.0, description="[-] likewise, of the upper sphere")
    upper_density: float | None = Field(
        None, gt=0.0, description="[kg/m3] of the upper sphere; that of the lower unless given"
    )
    gravity: float = Field(9.81, ge=0.0, description="[m/s2] downward")
    duration: float = Field(6.0, gt=0.0, description="[-] in half periods pi sqrt(m / k)")


class StackedCase(ContactCase[Stacked]):
    """Three contacts at once: floor, each other, ceiling."""

    name = "stacked"
    summary = "Two stacked spheres oscillate between plates: three contacts at a time."
    parameters = Stacked
    quantities = (
        Observable("lower_height_ratio", "1", "", "rise of the lower sphere over the squeeze"),
        Observable("upper_height_ratio", "1", "", "rise of the upper sphere over the squeeze"),
        Observable("lower_speed_ratio", "1", "", "velocity over omega times the squeeze"),
        Observable("upper_speed_ratio", "1", "", "likewise, of the upper sphere"),
    )
    submodels = tuple(one for one in NORMAL if "clipped" not in one.name)
    beside = tuple(one for one in (*NORMAL, *NORMAL_BESIDE) if "clipped" in one.name)
    systems: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "between plates": {"partner": "sphere", "partner_radius": None},
        "unequal, between plates": {"partner": "sphere", "partner_radius": 0.012},
    }
    scan = Scan(
        "lower_height_ratio",
        "duration",
        (1.0, 2.0, 3.0, 4.0, 5.0, 6.0),
        (("hooke",), ("hertz",)),
    )
    formula: ClassVar[str] = (
        "m1 x1'' = F(floor) - F(between) - m1 g, m2 x2'' = F(between) - F(ceiling) - m2 g, "
        "integrated; with linear springs a linear system of two oscillators."
    )

    @property
    def presets(self) -> Mapping[str, Stacked]:
        """Return equal spheres with a linear contact, and MFiX's DEM03."""
        usual = Stacked(partner="sphere", **NORMAL[1].law)
        return {"usual": usual, **{name: Stacked(**told) for name, told in MFIX.items()}}

    def scene(self, parameters: Stacked) -> ContactScene:
        """Return the spheres with the room's squeeze shared by the contacts, the lower one off."""
        r, upper = parameters.radius, parameters.second_radius
        squeeze = self._squeeze(parameters)
        top = 2.0 * (r + upper) - squeeze
        low = r - squeeze / 3.0 + parameters.offset * r
        high = top - upper + squeeze / 3.0 + parameters.upper_offset * upper
        heavier = sphere_mass(upper, parameters.upper_density or parameters.density)
        step = math.pi / self._omega(parameters) / parameters.steps_per_contact
        steps = math.ceil(parameters.duration * parameters.steps_per_contact)
        return ContactScene(
            (
                Body(r, parameters.mass, (0.0, 0.0, low)),
                Body(upper, heavier, (0.0, 0.0, high)),
            ),
            (FLOOR, Plane((0.0, 0.0, top), (0.0, 0.0, -1.0))),
            parameters.law,
            step=step,
            steps=steps,
            every=steps,
            gravity=(0.0, 0.0, -parameters.gravity),
        )

    def observed(self, parameters: Stacked, motion: Motion) -> Mapping[str, float]:
        """Return how far each sphere rose, and its velocity, at the end."""
        squeeze = self._squeeze(parameters)
        rise = (motion.position[-1, :, 2] - motion.position[0, :, 2]) / squeeze
        speed = motion.velocity[-1, :, 2] / squeeze / self._omega(parameters)
        return {
            "lower_height_ratio": float(rise[0]),
            "upper_height_ratio": float(rise[1]),
            "lower_speed_ratio": float(speed[0]),
            "upper_speed_ratio": float(speed[1]),
        }

    def axes(self, parameters: Stacked) -> tuple[str, str]:  # noqa: ARG002
        """Return what is drawn: how far each sphere rises."""
        return "time (ms)", "rise (µm)"

    def curves(self, parameters: Stacked, motion: Motion) -> Mapping[str, tuple[Array, Array]]:  # noqa: ARG002
        """Return the rise of both spheres."""
        rise = 1e6 * (motion.position[:, :, 2] - motion.position[0, :, 2])
        return {name: (1e3 * motion.time, rise[:, i]) for i, name in enumerate(("lower", "upper"))}

    def _squeeze(self, parameters: Stacked) -> float:
        """Return how much higher the spheres are than the room [m]."""
        return 2.0 * parameters.squeeze * (parameters.radius + parameters.second_radius)

    def _omega(self, parameters: Stacked) -> float:
        """Return sqrt(k / m) [1/s] with the stiffness at a third of the squeeze."""
        k = parameters.normal_stiffness
        if k is None:
            curved = math.sqrt(parameters.reduced_radius * self._squeeze(parameters) / 3.0)
            assert parameters.youngs_modulus is not None
            k = parameters.youngs_modulus * curved
        return math.sqrt(k / parameters.mass)


CASE = StackedCase()
