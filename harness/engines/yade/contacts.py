"""Contacts with friction in Yade: laws and rules, read off the source."""

from __future__ import annotations

from harness.engines.contact_model import (
    DASHPOTS,
    PLANES,
    ContactModel,
    States,
    Values,
    never_attracts,
    takes,
)

RULES = {
    "damping_in_cap": "sticking_only",
    "velocity_lever": "contact_point",
    "wall_lever": "height",
    "spring_spin": "mean",
}
"""ViscoelasticPM.cpp, HertzMindlin.cpp; ScGeom::rotate turns springs with the mean spin."""

TURNING_RULES = {
    "velocity_lever": "contact_point",
    "wall_lever": "contact_point",
    "spring_spin": "mean",
}
"""CohesiveFrictionalContactLaw.cpp; a box, Ig2_Box_Sphere_ScGeom, touches at half the overlap."""


GROWS = (1.0,)
"""ScGeom::rotate adds what is across a spring: each step's angle a lengthens it by a^2 / 2."""


def solid(values: Values) -> str:
    """Return why a contact of Mindlin's cannot be stated, or nothing where it can."""
    if values["normal"] == "dmt" and (values["damping"] != "none" or values["friction"]):
        return "has dmt without dashpot and friction only"
    if values["rolling"] == "sds" and values["rolling_damping"] != 0.0:
        return "has rolling springs without a dashpot only"
    if values["damping"] != "none" and values["motion_1"] == "prescribed" and values["planes"]:
        return "has no dashpot between a wall and a sphere that is held"
    return never_attracts(values)


def springs(values: Values) -> str:
    """Return why springs of rolling and twisting cannot be stated, or nothing where they can."""
    for kind in ("rolling", "twisting"):
        if values[kind] == "sds" and values[f"{kind}_damping"] != 0.0:
            return f"has {kind} springs without a dashpot only"
    if values[PLANES] and "radius_2" in values:
        return (
            "has springs of one stiffness and limit only: of a sphere on walls, or of two spheres"
        )
    return ""


def _told(states: States, *names: str) -> States:
    """Return states with some before the others: what is refused first is what is told."""
    return {name: states[name] for name in dict.fromkeys((*names, *states))}


_TURNS = "hooke", "none", "linear_history linear_history_classic"
TURNING = "Law2_ScGeom6D_CohFrictPhys_CohesionMoment"

CONTACTS = (
    ContactModel(
        "Law2_ScGeom_ViscElPhys_Basic",
        _told(
            takes("hooke", DASHPOTS, "none linear_history linear_history_classic"),
            *("normal", "rolling", "twisting"),
        ),
        RULES,
        never_attracts,
        GROWS,
    ),
    ContactModel(
        TURNING,
        _told(
            takes(*_TURNS, rolling="sds", twisting="none sds"),
            *("normal", "rolling", "twisting", "tangential"),
        ),
        TURNING_RULES,
        springs,
        GROWS,
    ),
    ContactModel(
        TURNING,
        _told(takes(*_TURNS, twisting="sds"), "normal", "twisting", "rolling", "tangential"),
        TURNING_RULES,
        springs,
        GROWS,
    ),
    ContactModel(
        "Law2_ScGeom_MindlinPhys_Mindlin",
        takes("hertz dmt", "none coeff_restitution", "none mindlin/force", rolling="none sds"),
        RULES,
        solid,
        GROWS,
    ),
)
