"""Contacts with friction in Yade: laws and rules, read off the source."""

from __future__ import annotations

from harness.engines.contact_model import ContactModel, Values, never_attracts

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
        {
            "normal": ("hooke",),
            "damping": ("none", "velocity", "mass_velocity", "coeff_restitution"),
            "tangential": ("none", "linear_history", "linear_history_classic"),
            "rolling": ("none",),
            "twisting": ("none",),
            "interface": ("current",),
        },
        RULES,
        never_attracts,
    ),
    ContactModel(
        "Law2_ScGeom_MindlinPhys_Mindlin",
        {
            "normal": ("hertz", "dmt"),
            "damping": ("none", "coeff_restitution"),
            "tangential": ("none", "mindlin/force"),
            "rolling": ("none", "sds"),
            "twisting": ("none",),
            "interface": ("current",),
        },
        RULES,
        solid,
    ),
)
