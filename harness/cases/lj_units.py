"""An oblique impact in LAMMPS's units lj: all numbers in other units, which must change nothing.

In units lj constants of a code are 1 that are others in SI. The numbers are those of an impact in
SI units times powers of two, so that no bit of a ratio may differ.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from harness.cases.contact.contact_case import ContactCase
from harness.cases.contact.motion import Motion
from harness.cases.contact.submodels import (
    COHESIVE_FRICTION,
    ROLLING,
    SLIDING,
    SYSTEMS,
    TANGENTIAL,
    Told,
)
from harness.cases.contact.surroundings import refused
from harness.cases.oblique import CASE as OBLIQUE
from harness.cases.oblique import Oblique
from harness.engines.contract import Job
from harness.engines.scene_jobs import scene_job
from harness.model.base import Vector
from harness.model.scene import Scene
from harness.parameters.scene import ContactScene

LENGTH, MASS, TIME = 2.0**-6, 2.0**-7, 2.0**-9
"""Units [m], [kg], [s] in which the sphere's radius and mass and a contact are about 1."""
SPEED = LENGTH / TIME


class InLjUnits(Oblique):
    """An impact at an angle to the normal, in SI units and degrees: those of the script follow."""

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        refused(self, normal=("hooke", "hertz", "dmt", "jkr"), materials_as=("stated",))
        super().check()


class LjUnitsCase(ContactCase[InLjUnits]):
    """An oblique impact in units lj: velocity ratios and spin are those in SI units."""

    name = "lj-units"
    submodels = (
        *(submodel for submodel in TANGENTIAL if submodel.name in ("linear_history", "mindlin")),
        *(submodel for submodel in ROLLING if submodel.name == "rolling sds, linear_history"),
        *(submodel for submodel in TANGENTIAL if submodel.name == "mindlin_rescale/force"),
        *(submodel for submodel in COHESIVE_FRICTION if submodel.name == "mindlin, jkr"),
    )
    sets: ClassVar[Told] = {"usual": SLIDING}
    systems: ClassVar[Told] = {
        name: SYSTEMS[name] for name in ("wall", "two spheres", "unequal spheres")
    }

    def scene(self, parameters: InLjUnits) -> ContactScene:
        """Return the impact in SI units."""
        return OBLIQUE.scene(parameters)

    def setup(self, parameters: InLjUnits) -> Scene:
        """Return the impact in other units."""
        scene = super().setup(parameters)
        bodies = (
            body.replace(
                radius=body.radius / LENGTH,
                mass=body.mass / MASS,
                position=divided(body.position, LENGTH),
                velocity=divided(body.velocity, SPEED),
                angular_velocity=divided(body.angular_velocity, 1.0 / TIME),
            )
            for body in scene.bodies
        )
        walls = (wall.replace(point=divided(wall.point, LENGTH)) for wall in scene.walls)
        law = scene.law.in_units(LENGTH, MASS, TIME)
        return scene.replace(
            bodies=tuple(bodies), walls=tuple(walls), law=law, step=scene.step / TIME
        )

    def job(self, parameters: InLjUnits) -> Job:
        """Return the job of one run in units lj."""
        return scene_job(self.setup(parameters), units="lj")

    def observed(self, parameters: InLjUnits, motion: Motion) -> Mapping[str, float]:
        """Return the ratios of an oblique impact."""
        velocity, spin = motion.velocity * SPEED, motion.angular_velocity / TIME
        return OBLIQUE.observed(
            parameters, replace(motion, velocity=velocity, angular_velocity=spin)
        )

    def sizes(self, parameters: InLjUnits) -> Mapping[str, float]:
        """Return the size of the ratio of impulses."""
        return OBLIQUE.sizes(parameters)


def divided(vector: Vector, unit: float) -> Vector:
    """Return a vector in a unit."""
    x, y, z = vector
    return (x / unit, y / unit, z / unit)


CASE = LjUnitsCase()
