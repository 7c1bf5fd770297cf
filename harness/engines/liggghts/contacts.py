"""Contacts with friction in LIGGGHTS: models and rules, read off the source of 3.8.0."""

from __future__ import annotations

import math

from harness.engines.contact_model import DASHPOTS, ContactModel, Values, takes

SAME = 1e-9
"""Relative difference of coefficients that are tied to one another."""

RULES = {
    "damping_in_cap": "sticking_only",
    "velocity_lever": "contact_point",
    "wall_lever": "contact_point",
}
"""tangential_model_history.h and surface_model_default.h."""


def tied(values: Values) -> str:
    """Return why a rolling or twisting spring cannot be stated, or nothing where it can."""
    if values["rolling"] == "sds" == values["twisting"]:
        return "has one limit for rolling and twisting together"
    if values["rolling"] == "sds" and not (
        values["rolling_damping"] == 0.0
        and _equal(values["rolling_stiffness"], values["tangential_stiffness"])
    ):
        return "has rolling springs (epsd2) as stiff as the tangential one, without a dashpot"
    why = _twisting(values) if values["twisting"] == "sds" else ""
    return f"has twisting springs (epsd2, torsionTorque) {why}" if why else ""


def _twisting(values: Values) -> str:
    """Return which twisting springs are the only ones, or nothing for one of them."""
    if values["twisting_damping"] != 0.0:
        return "without a dashpot only"
    radius, pair = float(values["radius_1"]), "radius_2" in values
    # the limit is told over R*, and the script has one for all contacts
    if pair and (values["planes"] or not _equal(radius, values["radius_2"])):
        return "with one R* only: of a sphere on walls, or of two equal spheres"
    own = float(values["tangential_stiffness"]) * (radius / 2.0 if pair else radius) ** 2
    if _equal(values["twisting_stiffness"], own):
        return ""
    here = "half the radius between two spheres" if pair else "the radius on a wall"
    return f"of k_t R*^2 = {own:.6g} N m, R* {here}"


def from_material(values: Values) -> str:
    """Return why model hertz does not have a tangential dashpot, or nothing where it has."""
    poisson = float(values["poisson_ratio"])
    own = math.sqrt(2.0 * (1.0 - poisson) / (2.0 - poisson))
    if values["tangential"] == "none" or values["tangential_damping"] == 0.0:
        return ""
    if _equal(values["tangential_damping"], own):
        return ""
    return f"has no tangential dashpot but of {own:.9g} times the normal one, or none"


def _equal(one: str | float, other: str | float) -> bool:
    return math.isclose(float(one), float(other), rel_tol=SAME)


_SPRINGS = "none linear_nohistory linear_history linear_history_classic"
_SOLIDS = "none linear_nohistory mindlin mindlin_classic"

CONTACTS = (
    ContactModel(
        "hooke/stiffness",
        takes("hooke", DASHPOTS, _SPRINGS, rolling="none sds", twisting="none sds"),
        RULES,
        tied,
    ),
    ContactModel("hertz/stiffness", takes("hertz", "none viscoelastic", _SOLIDS), RULES),
    ContactModel(
        "hertz",
        takes("hertz", "coeff_restitution", "none mindlin mindlin_classic"),
        RULES,
        from_material,
    ),
)
