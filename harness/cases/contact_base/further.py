"""Submodels that the shortest level leaves out: parts that act together, old styles clipped."""

from __future__ import annotations

from harness.cases.contact_base.submodels import (
    HERTZ,
    HOOKE,
    MASSIVE,
    OLD,
    ROLLING,
    ROLLING_BESIDE,
    ROLLS,
    SOLID_STICKING,
    STICKING,
    STICKY,
    TWISTS,
    VISCOUS,
    named,
)

_STICKIER = {**SOLID_STICKING, **STICKY, "surface_energy": 5.0}
"""Its pull-off force is some 8 % of the load in prescribed motion: the limit feels twice that."""

COHESIVE_FRICTION = named(
    {
        "mindlin, dmt": {**_STICKIER, "normal": "dmt"},
        "mindlin, jkr": {**_STICKIER, "normal": "jkr"},
    },
    quick=False,
    two_materials=("mindlin, jkr",),
)
"""Friction that attraction loads: at most mu (F + 2 F_pull-off), F the elastic force."""

TURNING = named(
    {
        "rolling sds, twisting sds, linear_history": {**STICKING, **ROLLS, **TWISTS},
        "rolling sds, twisting marshall, mindlin": {
            **SOLID_STICKING,
            **ROLLS,
            "twisting": "marshall",
        },
        "rolling sds, twisting sds, mindlin, jkr": {
            **_STICKIER,
            "normal": "jkr",
            **ROLLS,
            **TWISTS,
        },
    },
    quick=False,
)
"""Rolling and twisting resistance of one contact, also under the load of attraction."""

ROLLING_ON = tuple(
    one
    for one in (*ROLLING, *ROLLING_BESIDE)
    if one.name in ("rolling sds, linear_history", "rolling sds, linear_history, of Ai")
)
"""Rolling resistance of linear springs beside friction that slides as well."""

OLD_CLIPPED = named(
    {
        "old hooke, clipped": {**HOOKE, **MASSIVE, **OLD, "clipped": True},
        "old hertz/history, clipped": {
            **HERTZ,
            **VISCOUS,
            "tangential": "mindlin_classic",
            **OLD,
            "clipped": True,
        },
    },
    quick=False,
)
"""The earlier interface with limit_damping, head-on."""
