"""Tables of the contact cases: laws, the rows of the matrix, and systems, its columns.

A law is a change of a case's default parameters. Level quick leaves out laws in which several parts
act together, and takes the others in turns through the systems.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from typing import Any

Changes = Mapping[str, Any]
Systems = Mapping[str, Changes]


@dataclass(frozen=True)
class LawRow:
    """Changes of the default parameters that make a law.

    ``systems`` names those that it goes through, all unless given; those of two materials only
    with ``two_materials``. ``quick``: also at level quick.
    """

    law: Changes = field(hash=False)
    systems: tuple[str, ...] = ()
    quick: bool = True
    two_materials: bool = False

    def goes_with(self, system: str) -> bool:
        """Return whether the law goes through a system."""
        if system in TWO_MATERIALS:
            return self.two_materials
        return not self.systems or system in self.systems


Laws = Mapping[str, LawRow]


def table(
    laws: Mapping[str, Changes],
    systems: tuple[str, ...] = (),
    *,
    quick: bool = True,
    two_materials: Container[str] = (),
) -> dict[str, LawRow]:
    """Return laws as rows, by name."""
    return {name: LawRow(law, systems, quick, name in two_materials) for name, law in laws.items()}


def pick(laws: Laws, *names: str, systems: tuple[str, ...] | None = None) -> dict[str, LawRow]:
    """Return some laws by name, in this order, perhaps in other ``systems``."""
    rows = {name: laws[name] for name in names}
    if systems is None:
        return rows
    return {name: LawRow(row.law, systems, row.quick) for name, row in rows.items()}


SLIDING = {"tangential": "linear_history", "friction": 0.3}
PLAIN = {
    "normal": "hooke", "damping": "none", "tangential": "none", "rolling": "none",
    "twisting": "none", "clipped": False, "interface": "current",
}  # fmt: skip

# ---- systems: the first sphere has a radius of 1 cm

SYSTEMS: Systems = {
    "wall": {"partner": "wall", "partner_radius": None},
    "two spheres": {"partner": "sphere", "partner_radius": None},
    "unequal spheres": {"partner": "sphere", "partner_radius": 0.02},
    "frozen sphere": {"partner": "frozen", "partner_radius": None},
}
_STIFFER = {"partner_youngs_modulus": 4e8, "partner_poisson_ratio": 0.1}
_DENSER = {**SYSTEMS["two spheres"], "partner_density": 5000.0, **_STIFFER}
TWO_MATERIALS: Systems = {
    "two materials, stated": {**_DENSER, "materials_as": "stated"},
    "two materials, mixed": {**_DENSER, "materials_as": "mixed"},
    "wall of another material": {**SYSTEMS["wall"], **_STIFFER},
}
SLOW_SYSTEMS = ("unequal spheres", "frozen sphere", "two spheres, turned", *TWO_MATERIALS)

# ---- normal forces and dashpots

MATERIAL = {"youngs_modulus": 1e8, "poisson_ratio": 0.3}
HOOKE = {"normal": "hooke", "normal_stiffness": 1e5}
HERTZ = {"normal": "hertz", **MATERIAL}
DMT = {"normal": "dmt", **MATERIAL, "surface_energy": 0.5}
JKR = {**DMT, "normal": "jkr"}
MDR = {"normal": "mdr", **MATERIAL}
VELOCITY = {"damping": "velocity", "damping_coefficient": 2.0}
MASS = {"damping": "mass_velocity", "damping_coefficient": 400.0}
VISCOUS = {"damping": "viscoelastic", "damping_coefficient": 4e5}
CONSTANT = {"damping": "coeff_restitution", "restitution": 0.5}
OLD = {"interface": "old"}

NORMAL = table(
    {
        "hooke": HOOKE,
        "hooke, velocity": {**HOOKE, **VELOCITY},
        "hooke, velocity, clipped": {**HOOKE, **VELOCITY, "clipped": True},
        "hooke, mass_velocity": {**HOOKE, **MASS},
        "hooke, viscoelastic": {**HOOKE, **VISCOUS},
        "hooke, coeff_restitution": {**HOOKE, **CONSTANT},
        "hertz": HERTZ,
        "hertz, velocity": {**HERTZ, **VELOCITY},
        "hertz, mass_velocity": {**HERTZ, **MASS},
        "hertz, viscoelastic": {**HERTZ, **VISCOUS},
        "hertz, viscoelastic, clipped": {**HERTZ, **VISCOUS, "clipped": True},
        "hertz, tsuji": {**HERTZ, "damping": "tsuji", "restitution": 0.5},
        "hertz, coeff_restitution": {**HERTZ, **CONSTANT},
        "mdr": MDR,
        "mdr, velocity": {**MDR, **VELOCITY},
    },
    two_materials=("hertz", "hertz, viscoelastic", "hertz, coeff_restitution"),
)
RETURNED = {**HERTZ, **CONSTANT, "clipped": True}
CLIPPED_NORMAL = table({"hertz, coeff_restitution, clipped": RETURNED})
COHESIVE = table(
    {
        "dmt": DMT,
        "dmt, viscoelastic": {**DMT, **VISCOUS},
        "jkr": JKR,
        "jkr, viscoelastic": {**JKR, **VISCOUS},
    },
    two_materials=("dmt", "jkr"),
)
OLD_NORMAL = table(
    {
        "old hooke": {**HOOKE, **MASS, **OLD},
        "old hooke, no damping": {**HOOKE, **OLD},
        "old hertz/history": {**HERTZ, **VISCOUS, "tangential": "mindlin_classic", **OLD},
    }
)
OLD_CLIPPED = table(
    {
        f"{name}, clipped": {**OLD_NORMAL[name].law, "clipped": True}
        for name in ("old hooke", "old hertz/history")
    },
    quick=False,
)

# ---- mdr: branches of one contact; a bulk that takes all that is displaced lets nothing yield

_ONE_SIZE = ("wall", "two spheres", "frozen sphere")
_STIFF = {"damping": "mdr", "damping_coefficient": 0.25}
_YIELD = {**MDR, "yield_stress": 1e6}
_BULK = {**MDR, "bulk_response": True}
_SPRING = {"tangential": "linear_history", "tangential_stiffness": 5e4}
MDR_BRANCHES = {
    **table({"mdr, mdr damping": {**MDR, **_STIFF}}, _ONE_SIZE, quick=False),
    **table({"mdr, yield": _YIELD}, _ONE_SIZE),
    **table({"mdr, bulk": _BULK}, _ONE_SIZE, quick=False),
}
MDR_TOGETHER = table(
    {
        "mdr, yield, velocity": {**_YIELD, **VELOCITY},
        "mdr, yield, mdr damping": {**_YIELD, **_STIFF},
        "mdr, bulk, velocity": {**_BULK, **VELOCITY},
        "mdr, yield, bulk": {**_YIELD, "bulk_response": True},
    },
    _ONE_SIZE,
    quick=False,
)
MDR_ADHESION = table({"mdr, adhesion": {**MDR, "surface_energy": 0.5}}, _ONE_SIZE, quick=False)
MDR_FRICTION = {
    **table(
        {
            "mdr, linear_history": {**MDR, **_SPRING},
            "mdr, mindlin": {**MDR, "tangential": "mindlin"},
            "mdr, mindlin_rescale/force": {**MDR, "tangential": "mindlin_rescale/force"},
            "mdr, velocity, linear_history": {
                **MDR, **VELOCITY, **_SPRING, "tangential_damping": 0.5,
            },
        },
        quick=False,
    ),
    **table(
        {
            "mdr, yield, linear_history": {**_YIELD, **_SPRING},
            "mdr, yield, mindlin": {**_YIELD, "tangential": "mindlin"},
            "mdr, bulk, mindlin": {**_BULK, "tangential": "mindlin"},
        },
        _ONE_SIZE,
        quick=False,
    ),
}  # fmt: skip

# ---- friction

SPRING = {**HOOKE, **VELOCITY, "tangential_damping": 0.5}
SOLID = {**HERTZ, **VISCOUS, "tangential_damping": 0.5}
STICKING = {**SPRING, "tangential": "linear_history"}
STICKING_SOLID = {**SOLID, "tangential": "mindlin"}
_LINEAR = ("linear_nohistory", "linear_history", "linear_history_classic")
_MINDLIN = (
    "mindlin", "mindlin/force", "mindlin_rescale", "mindlin_rescale/force", "mindlin_classic",
)  # fmt: skip
TANGENTIAL = table(
    {
        **{name: {**SPRING, "tangential": name} for name in _LINEAR},
        **{name: {**SOLID, "tangential": name} for name in _MINDLIN},
    },
    two_materials=("mindlin", "mindlin_rescale/force"),
)
_OLD_SPRING = {**SPRING, **MASS, **OLD}
OLD_TANGENTIAL = table(
    {
        "old hooke": {**_OLD_SPRING, "tangential": "linear_nohistory"},
        "old hooke/history": {**_OLD_SPRING, "tangential": "linear_history_classic"},
        "old hertz/history": {**SOLID, "tangential": "mindlin_classic", **OLD},
    }
)
# x_t of one share of critical damping along and across, 2 sqrt(m* k): sqrt(4 G*/E*)
_ALIKE = (2.0 * (1.0 - 0.3) / (2.0 - 0.3)) ** 0.5
_ELASTIC = {**HOOKE, "tangential": "linear_history"}
_SOFT = {"tangential": "linear_history", "tangential_stiffness": 2e5 / 7.0}
# friction beside normal forces that codes state which have none that attracts, and elastic ones
FURTHER_TANGENTIAL = table(
    {
        "linear_history, elastic": _ELASTIC,
        "linear_history, 2/7, elastic": {**HOOKE, **_SOFT},
        "linear_history, 2/7": {**SPRING, **_SOFT},
        "linear_history, clipped": {**STICKING, "clipped": True},
        "mindlin, elastic": {**HERTZ, "tangential": "mindlin"},
        "mindlin/force, elastic": {**HERTZ, "tangential": "mindlin/force"},
        "mindlin_rescale/force, elastic": {**HERTZ, "tangential": "mindlin_rescale/force"},
        "mindlin, coeff_restitution": {
            **HERTZ, **CONSTANT, "restitution": 0.9, "tangential": "mindlin",
            "tangential_damping": 0.5, "friction": 0.6,
        },
        "mindlin, coeff_restitution, clipped": {**RETURNED, "tangential": "mindlin"},
        "mindlin/force, coeff_restitution, clipped": {
            **RETURNED, "tangential": "mindlin/force", "tangential_damping": _ALIKE,
        },
    },
    two_materials=(
        "mindlin, elastic", "mindlin/force, elastic", "mindlin_rescale/force, elastic",
        "mindlin, coeff_restitution, clipped",
    ),
)  # fmt: skip
FRICTION = {**TANGENTIAL, **OLD_TANGENTIAL}
_STICKIER = {**STICKING_SOLID, "surface_energy": 5.0}  # pull-off is 8 % of the prescribed load
COHESIVE_FRICTION = table(
    {
        "mindlin, dmt": {**_STICKIER, "normal": "dmt"},
        "mindlin, jkr": {**_STICKIER, "normal": "jkr"},
    },
    quick=False,
    two_materials=("mindlin, jkr",),
)

# ---- rolling and twisting

ROLLS = {
    "rolling": "sds", "rolling_stiffness": 2e4, "rolling_damping": 0.5, "rolling_friction": 0.05,
}  # fmt: skip
TWISTS = {
    "twisting": "sds", "twisting_stiffness": 1.0, "twisting_damping": 5e-5,
    "twisting_friction": 1e-4,
}  # fmt: skip
ROLLING = table(
    {
        "rolling sds, linear_history": {**STICKING, **ROLLS},
        "rolling sds, mindlin": {**STICKING_SOLID, **ROLLS},
    },
    two_materials=("rolling sds, mindlin",),
)
# springs as stiff as the tangential one, without a dashpot, which some codes tie to it
_TIED = {**ROLLS, "rolling_stiffness": 2e5 / 7.0, "rolling_damping": 0.0}
# 2.25 k_n mu_r^2: Ai, Chen, Rotter and Ooi, Powder Technol. 206, 269 (2011)
_OF_AI = {**_TIED, "rolling_stiffness": 2.25 * 1e5 * 0.05**2, "rolling_damping": 0.5}
FURTHER_ROLLING = table(
    {
        "rolling sds, linear_history, tied": {**STICKING, **_TIED},
        "rolling sds, mindlin/force, elastic": {**HERTZ, "tangential": "mindlin/force", **_TIED},
        "rolling sds, linear_history, of Ai": {**STICKING, **_OF_AI},
    }
)
UNDAMPED_ROLLING = table({"rolling sds, linear_history, elastic": {**_ELASTIC, **_TIED}})
FLOOR_ROLLING = pick(
    {**ROLLING, **FURTHER_ROLLING},
    "rolling sds, linear_history", "rolling sds, linear_history, of Ai",
)  # fmt: skip
TWISTING = table(
    {
        "twisting sds, linear_history": {**STICKING, **TWISTS},
        "twisting sds, mindlin": {**STICKING_SOLID, **TWISTS},
        "twisting marshall, linear_history": {
            **STICKING, "damping_coefficient": 20.0, "twisting": "marshall",
        },
        "twisting marshall, mindlin": {**STICKING_SOLID, "twisting": "marshall"},
    },
    two_materials=("twisting marshall, mindlin",),
)  # fmt: skip
_TIED_TWIST = {**TWISTS, "twisting_stiffness": 2e1 / 7.0, "twisting_damping": 0.0}
FURTHER_TWISTING = table({"twisting sds, linear_history, tied": {**STICKING, **_TIED_TWIST}})
UNDAMPED_TWISTING = table({"twisting sds, linear_history, elastic": {**_ELASTIC, **_TIED_TWIST}})
UNDAMPED = {"rolling_damping": 0.0, "twisting_damping": 0.0}
UNDAMPED_TURNING = table(
    {
        "rolling sds, twisting sds, linear_history, elastic": {
            **_ELASTIC, **ROLLS, **TWISTS, **UNDAMPED,
        }
    }
)  # fmt: skip
TURNING = table(
    {
        "rolling sds, twisting sds, linear_history": {**STICKING, **ROLLS, **TWISTS},
        "rolling sds, twisting marshall, mindlin": {
            **STICKING_SOLID, **ROLLS, "twisting": "marshall",
        },
        "rolling sds, twisting sds, mindlin, jkr": {
            **_STICKIER, "normal": "jkr", **ROLLS, **TWISTS,
        },
    },
    quick=False,
)  # fmt: skip
