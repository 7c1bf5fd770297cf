"""Springs of rolling and twisting without any dashpot, on elastic linear springs."""

from __future__ import annotations

from harness.cases.contact_base.submodels import HOOKE, ROLLS, TWISTS, named

_ELASTIC = {**HOOKE, "tangential": "linear_history"}

ROLLING_UNDAMPED = named(
    {
        "rolling sds, linear_history, elastic": {
            **_ELASTIC,
            "rolling": "sds",
            "rolling_stiffness": 2e5 / 7.0,
            "rolling_damping": 0.0,
            "rolling_friction": 0.05,
        }
    }
)
"""As stiff as the tangential spring where a sphere rolls on a floor: some codes have no other."""

TWISTING_UNDAMPED = named(
    {
        "twisting sds, linear_history, elastic": {
            **_ELASTIC,
            "twisting": "sds",
            "twisting_stiffness": 2e1 / 7.0,
            "twisting_damping": 0.0,
            "twisting_friction": 1e-4,
        }
    }
)
"""Of k_t R*^2 where the sphere of 1 cm spins on a floor, likewise."""

TURNING_UNDAMPED = named(
    {
        "rolling sds, twisting sds, linear_history, elastic": {
            **_ELASTIC,
            **ROLLS,
            **TWISTS,
            "rolling_damping": 0.0,
            "twisting_damping": 0.0,
        }
    }
)
"""Both together, of stiffnesses of their own."""
