"""An oblique impact in LAMMPS's units lj: all numbers in other units, which must change nothing.

In units lj constants of a code are 1 that are others in SI. The numbers are those of an impact in
SI units times powers of two, so that no bit of a ratio may differ.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from harness.cases.contact.motion import Motion
from harness.cases.contact.submodels import (
    COHESIVE_FRICTION,
    ROLLING,
    SLIDING,
    SYSTEMS,
    TANGENTIAL,
    Told,
)
from harness.cases.contact.surroundings import SurroundedCase, refused
from harness.cases.contact.transformations import Units
from harness.cases.oblique import CASE as OBLIQUE
from harness.cases.oblique import Oblique
from harness.engines.contract import Value
from harness.parameters.scene import ContactScene

UNITS = Units(2.0**6, 2.0**7, 2.0**9)
"""Of length, mass and time, in which the sphere's radius and mass and a contact are about 1."""


class InLjUnits(Oblique):
    """An impact at an angle to the normal, in SI units and degrees: those of the script follow."""

    def check(self) -> None:
        """Raise ValueError for values that have no meaning together."""
        refused(self, normal=("hooke", "hertz", "dmt", "jkr"), materials_as=("stated",))
        super().check()


class LjUnitsCase(SurroundedCase[InLjUnits]):
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
        """Return the impact in other units."""
        return UNITS.scene(OBLIQUE.scene(parameters))

    def surroundings(self, parameters: InLjUnits) -> Mapping[str, Value]:
        """Return the units."""
        return {"units": "lj"}

    def observed(self, parameters: InLjUnits, motion: Motion) -> Mapping[str, float]:
        """Return the ratios of an oblique impact."""
        return OBLIQUE.observed(parameters, UNITS.back(motion))

    def sizes(self, parameters: InLjUnits) -> Mapping[str, float]:
        """Return the size of the ratio of impulses."""
        return OBLIQUE.sizes(parameters)


CASE = LjUnitsCase()
