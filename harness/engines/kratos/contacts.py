"""Contacts with friction in Kratos DEM: laws and rules, read off the source of 10.4.4."""

from __future__ import annotations

from harness.engines.contact_model import DASHPOTS, ContactModel, Values, never_attracts, takes

RULES = {"velocity_lever": "contact_point", "wall_lever": "height"}
"""spheric_particle.cpp: arms end at half the overlap of two spheres, at a wall in its plane."""


def dashpot(values: Values) -> str:
    """Return why a dashpot cannot be stated, or nothing where it can."""
    reason = never_attracts(values)
    if not reason and values["damping"] != "none" and values["tangential"] != "none":
        return "has a dashpot along the surface that is tied to the normal one, and limited twice"
    return reason


def springs(values: Values) -> str:
    """Return why linear springs cannot be stated, or nothing where they can."""
    if values["tangential"] != "none" and not of_a_material(values):
        return "has k_t of less than 4/3 k_n: it is 2 (1 - nu) / (2 - nu) of it"
    return dashpot(values)


def of_a_material(values: Values) -> bool:
    """Return whether linear springs are those of a material, with a Poisson's ratio above -1."""
    return float(values["tangential_stiffness"]) < 4.0 / 3.0 * float(values["normal_stiffness"])


CONTACTS = (
    ContactModel(
        "DEM_D_Linear_viscous_Coulomb",
        takes("hooke", DASHPOTS, "none linear_history"),
        RULES,
        springs,
    ),
    ContactModel(
        "DEM_D_Linear_Custom_Constants",
        takes("hooke", DASHPOTS, "none linear_history"),
        RULES,
        dashpot,
    ),
    ContactModel(
        "DEM_D_Hertz_viscous_Coulomb",
        takes("hertz", "none coeff_restitution", "none mindlin_rescale/force"),
        RULES,
        dashpot,
    ),
    ContactModel("DEM_D_Hertz_viscous_Coulomb_DMT", takes("dmt", "none", "none"), RULES),
)
