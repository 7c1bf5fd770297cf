"""An oblique impact in LAMMPS's units lj: all numbers in other units, which must change nothing.

In units lj constants of a code are 1 that are others in SI. The numbers are those of an impact in
SI units times powers of two, so that no bit of a ratio may differ.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from harness.cases.contacts import bounds, tables
from harness.cases.contacts.contact_case import ContactCase
from harness.cases.contacts.oblique import CASE as OBLIQUE
from harness.cases.contacts.oblique import QUANTITIES, Oblique, velocity_ratios
from harness.model.base import Vector
from harness.model.motion import Motion
from harness.model.scene import Scene

# [m], [kg], [s]: units in which radius, mass and duration of a contact are about 1
LENGTH, MASS, TIME = 2.0**-6, 2.0**-7, 2.0**-9
SPEED = LENGTH / TIME


class InLjUnits(Oblique):
    """An impact at an angle to the normal, in SI units and degrees; the script has other units."""

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        bounds.check_words(self, normal=("hooke", "hertz", "dmt", "jkr"), materials_as=("stated",))
        super().check()


class LjUnitsCase(ContactCase[InLjUnits]):
    """An oblique impact in units lj."""

    name = "lj-units"
    summary = "An oblique impact in units lj: velocity ratios and spin are those in SI units."
    formula = "As an oblique impact, all numbers times powers of the units."
    parameters = InLjUnits
    quantities = QUANTITIES
    units = "lj"
    laws: ClassVar = tables.pick(
        "linear_history", "mindlin", "rolling sds, linear_history", "mindlin_rescale/force",
        "mindlin, jkr",
    )  # fmt: skip
    systems: ClassVar = tables.systems("wall", "two spheres", "unequal spheres")

    def build(self, p: InLjUnits) -> Scene:
        """Return the impact in other units."""
        scene = OBLIQUE.build(p)
        bodies = (
            body.replace(
                radius=body.radius / LENGTH,
                mass=body.mass / MASS,
                position=_divided(body.position, LENGTH),
                velocity=_divided(body.velocity, SPEED),
                angular_velocity=_divided(body.angular_velocity, 1.0 / TIME),
            )
            for body in scene.bodies
        )
        law = scene.law.in_units(LENGTH, MASS, TIME)
        return scene.replace(bodies=tuple(bodies), law=law, step=scene.step / TIME)

    def observe(self, p: InLjUnits, motion: Motion) -> Mapping[str, float]:
        """Return the ratios of an oblique impact."""
        velocity, spin = motion.velocity * SPEED, motion.angular_velocity / TIME
        return velocity_ratios(p, replace(motion, velocity=velocity, angular_velocity=spin))


def _divided(vector: Vector, unit: float) -> Vector:
    x, y, z = vector
    return (x / unit, y / unit, z / unit)


CASE = LjUnitsCase()
