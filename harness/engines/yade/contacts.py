"""Contacts with friction in Yade: laws and rules, read off the source."""

from __future__ import annotations

from harness.engines.contact_model import DASHPOTS, ContactModel, Values, never_attracts, takes

RULES = {
    "damping_in_cap": "sticking_only",
    "velocity_lever": "contact_point",
    "wall_lever": "height",
    "spring_spin": "mean",
}
"""ViscoelasticPM.cpp, HertzMindlin.cpp; ScGeom::rotate turns springs with the mean spin."""


def solid(values: Values) -> str:
    """Return why a contact of Mindlin's cannot be stated, or nothing where it can."""
    if values["normal"] == "dmt" and (values["damping"] != "none" or values["friction"]):
        return "has dmt without dashpot and friction only"
    if values["rolling"] == "sds" and values["rolling_damping"] != 0.0:
        return "has rolling springs without a dashpot only"
    if values["damping"] != "none" and values["motion_1"] == "prescribed" and values["planes"]:
        return "has no dashpot between a wall and a sphere that is held"
    return never_attracts(values)


CONTACTS = (
    ContactModel(
        "Law2_ScGeom_ViscElPhys_Basic",
        takes("hooke", DASHPOTS, "none linear_history linear_history_classic"),
        RULES,
        never_attracts,
    ),
    ContactModel(
        "Law2_ScGeom_MindlinPhys_Mindlin",
        takes("hertz dmt", "none coeff_restitution", "none mindlin/force", rolling="none sds"),
        RULES,
        solid,
    ),
)
