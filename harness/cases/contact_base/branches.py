"""What LAMMPS's mdr has beside its plain elastic branch, as submodels of the contact cases."""

from __future__ import annotations

from harness.cases.contact_base.submodels import MDR, SLOW, Submodel

STIFF = {"damping": "mdr", "damping_coefficient": 0.25}
YIELDS = {**MDR, "yield_stress": 1e6}
RESPONDS = {**MDR, "bulk_response": True}
_ONE_FLAT = ("wall", "two spheres", "frozen sphere")

BRANCHES = (
    Submodel("mdr, mdr damping", {**MDR, **STIFF}, _ONE_FLAT, quick=False),
    Submodel("mdr, yield", YIELDS, _ONE_FLAT),
    Submodel("mdr, bulk", RESPONDS, _ONE_FLAT, quick=False),
)
"""What mdr has beside its elastic branch, of one contact, and the dashpot that goes with it."""

TOGETHER = (
    Submodel("mdr, yield, velocity", {**YIELDS, **SLOW}, _ONE_FLAT, quick=False),
    Submodel("mdr, yield, mdr damping", {**YIELDS, **STIFF}, _ONE_FLAT, quick=False),
    Submodel("mdr, bulk, velocity", {**RESPONDS, **SLOW}, _ONE_FLAT, quick=False),
    Submodel("mdr, yield, bulk", {**YIELDS, "bulk_response": True}, _ONE_FLAT, quick=False),
)
"""Branches of mdr together and with its dashpots.

A bulk that responds from the first touch on takes all that is displaced: beside it nothing yields.
"""

_SPRING = {"tangential": "linear_history", "tangential_stiffness": 5e4}
_SOLID = {"tangential": "mindlin"}

RUBBING = (
    Submodel("mdr, linear_history", {**MDR, **_SPRING}, quick=False),
    Submodel("mdr, mindlin", {**MDR, **_SOLID}, quick=False),
    Submodel(
        "mdr, mindlin_rescale/force", {**MDR, "tangential": "mindlin_rescale/force"}, quick=False
    ),
    Submodel(
        "mdr, velocity, linear_history",
        {**MDR, **SLOW, **_SPRING, "tangential_damping": 0.5},
        quick=False,
    ),
    Submodel("mdr, yield, linear_history", {**YIELDS, **_SPRING}, _ONE_FLAT, quick=False),
    Submodel("mdr, yield, mindlin", {**YIELDS, **_SOLID}, _ONE_FLAT, quick=False),
    Submodel("mdr, bulk, mindlin", {**RESPONDS, **_SOLID}, _ONE_FLAT, quick=False),
)
"""Friction beside mdr: elastic, with a dashpot, yielding, and under the load of its bulk."""

STICKING_FLAT = Submodel("mdr, adhesion", {**MDR, "surface_energy": 0.5}, _ONE_FLAT, quick=False)
"""mdr's adhesion."""
