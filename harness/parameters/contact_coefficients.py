"""The coefficients that each submodel of a contact law takes, and what they are by default."""

from __future__ import annotations

from typing import Any

_MATERIAL = ("youngs_modulus", "poisson_ratio")
_SLIDER = ("tangential_damping", "friction")

TAKES: dict[str, dict[str, tuple[str, ...]]] = {
    "normal": {
        "hooke": ("normal_stiffness",),
        "hertz": _MATERIAL,
        "dmt": (*_MATERIAL, "surface_energy"),
        "jkr": (*_MATERIAL, "surface_energy"),
        "mdr": _MATERIAL,
    },
    "damping": {
        **dict.fromkeys(
            ("velocity", "mass_velocity", "viscoelastic", "mdr"), ("damping_coefficient",)
        ),
        **dict.fromkeys(("tsuji", "coeff_restitution"), ("restitution",)),
    },
    "tangential": {
        "linear_nohistory": _SLIDER,
        "linear_history": ("tangential_stiffness", *_SLIDER),
        "linear_history_classic": ("tangential_stiffness", *_SLIDER),
        "mindlin": _SLIDER,
        "mindlin/force": _SLIDER,
        "mindlin_rescale": _SLIDER,
        "mindlin_rescale/force": _SLIDER,
        "mindlin_classic": _SLIDER,
    },
    "rolling": {"sds": ("rolling_stiffness", "rolling_damping", "rolling_friction")},
    "twisting": {"sds": ("twisting_stiffness", "twisting_damping", "twisting_friction")},
}
"""The coefficients that each submodel takes."""

PARTNER = ("partner_youngs_modulus", "partner_poisson_ratio")
"""The material of the second body, where it is another one."""

MAY_TAKE = {
    "mdr": ("yield_stress", "surface_energy"),
    **dict.fromkeys(("hertz", "dmt", "jkr"), PARTNER),
}
"""Coefficients that a normal force takes where they are given, and has no default for."""

_DEFAULTS: dict[str, float] = {
    "normal_stiffness": 1e6,
    "youngs_modulus": 70e9,
    "poisson_ratio": 0.3,
    "surface_energy": 0.1,
    "restitution": 0.9,
    "tangential_stiffness": 2e6 / 7.0,
    "tangential_damping": 0.0,
    "friction": 0.3,
}
"""What a submodel is given where nobody says otherwise; coefficients that are not here must be."""


def default_of(name: str, models: dict[str, Any], given: dict[str, Any]) -> float | None:
    """Return the default of a coefficient beside the others; None where there is none."""
    if name == "tangential_stiffness" and given.get("normal_stiffness") is not None:
        return 2.0 * float(given["normal_stiffness"]) / 7.0  # as in _DEFAULTS, to the bit
    if name == "tangential_damping" and models["tangential"] == "linear_nohistory":
        return 1.0
    return _DEFAULTS.get(name)
