"""The submodels that the cases go through, and the systems of bodies: rows of the matrix."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from typing import Any

from harness.cases.contact_base.presets import Told

SYSTEMS: Told = {
    "wall": {"partner": "wall", "partner_radius": None},
    "two spheres": {"partner": "sphere", "partner_radius": None},
    "unequal spheres": {"partner": "sphere", "partner_radius": 0.02},
    "frozen sphere": {"partner": "frozen", "partner_radius": None},
}
"""What the first sphere, of 1 cm radius, meets, by name."""

_STIFFER = {"partner_youngs_modulus": 4e8, "partner_poisson_ratio": 0.1}
_DENSER = {"partner": "sphere", "partner_radius": None, "partner_density": 5000.0, **_STIFFER}

TWO_MATERIALS: Told = {
    "two materials, stated": {**_DENSER, "materials_as": "stated"},
    "two materials, mixed": {**_DENSER, "materials_as": "mixed"},
    "wall of another material": {"partner": "wall", "partner_radius": None, **_STIFFER},
}
"""Of another modulus, Poisson's ratio and density, for submodels that take a material."""


@dataclass(frozen=True)
class Submodel:
    """A choice of submodels by its name, as changes of a case's law.

    ``systems`` names those that it goes through, all unless given; those of ``TWO_MATERIALS`` only
    where it is said to have ``two_materials``. ``quick``: at every level.
    """

    name: str
    law: Mapping[str, Any] = field(hash=False)
    systems: tuple[str, ...] = ()
    quick: bool = True
    two_materials: bool = False

    def stated_in(self, name: str, system: Mapping[str, Any]) -> bool:
        """Return whether it goes through a system."""
        if name in TWO_MATERIALS:
            return self.two_materials
        return not self.systems or name in self.systems


@dataclass(frozen=True)
class Trial:
    """A submodel of a case in a system, and its parameters."""

    submodel: str
    system: str
    parameters: Any


def named(
    laws: Told, *, quick: bool = True, two_materials: Container[str] = ()
) -> tuple[Submodel, ...]:
    """Return submodels by their names."""
    return tuple(
        Submodel(name, law, quick=quick, two_materials=name in two_materials)
        for name, law in laws.items()
    )


PLAIN = {
    "normal": "hooke",
    "damping": "none",
    "tangential": "none",
    "rolling": "none",
    "twisting": "none",
    "clipped": False,
    "interface": "current",
}
"""What a submodel does not name."""

MATERIAL = {"youngs_modulus": 1e8, "poisson_ratio": 0.3}
HOOKE = {"normal": "hooke", "normal_stiffness": 1e5}
HERTZ = {"normal": "hertz", **MATERIAL}
MDR = {"normal": "mdr", **MATERIAL}
STICKY = {**MATERIAL, "surface_energy": 0.5}
SLOW = {"damping": "velocity", "damping_coefficient": 2.0}
MASSIVE = {"damping": "mass_velocity", "damping_coefficient": 400.0}
VISCOUS = {"damping": "viscoelastic", "damping_coefficient": 4e5}
CONSTANT = {"damping": "coeff_restitution", "restitution": 0.5}
OLD = {"interface": "old"}

NORMAL = named(
    {
        "hooke": HOOKE,
        "hooke, velocity": {**HOOKE, **SLOW},
        "hooke, velocity, clipped": {**HOOKE, **SLOW, "clipped": True},
        "hooke, mass_velocity": {**HOOKE, **MASSIVE},
        "hooke, viscoelastic": {**HOOKE, **VISCOUS},
        "hooke, coeff_restitution": {**HOOKE, **CONSTANT},
        "hertz": HERTZ,
        "hertz, velocity": {**HERTZ, **SLOW},
        "hertz, mass_velocity": {**HERTZ, **MASSIVE},
        "hertz, viscoelastic": {**HERTZ, **VISCOUS},
        "hertz, viscoelastic, clipped": {**HERTZ, **VISCOUS, "clipped": True},
        "hertz, tsuji": {**HERTZ, "damping": "tsuji", "restitution": 0.5},
        "hertz, coeff_restitution": {**HERTZ, **CONSTANT},
        "mdr": MDR,
        "mdr, velocity": {**MDR, **SLOW},
    },
    two_materials=("hertz", "hertz, viscoelastic", "hertz, coeff_restitution"),
)
"""Normal forces and dampings."""

COHESIVE = named(
    {
        "dmt": {**STICKY, "normal": "dmt"},
        "dmt, viscoelastic": {**STICKY, "normal": "dmt", **VISCOUS},
        "jkr": {**STICKY, "normal": "jkr"},
        "jkr, viscoelastic": {**STICKY, "normal": "jkr", **VISCOUS},
    },
    two_materials=("dmt", "jkr"),
)
"""Normal forces with attraction."""

OLD_NORMAL = named(
    {
        "old hooke": {**HOOKE, **MASSIVE, **OLD},
        "old hooke, no damping": {**HOOKE, **OLD},
        "old hertz/history": {**HERTZ, **VISCOUS, "tangential": "mindlin_classic", **OLD},
    }
)
"""The earlier interface, head-on."""

SPRING = {**HOOKE, **SLOW, "tangential_damping": 0.5}
SOLID = {**HERTZ, **VISCOUS, "tangential_damping": 0.5}

TANGENTIAL = named(
    {
        **{
            name: {**SPRING, "tangential": name}
            for name in ("linear_nohistory", "linear_history", "linear_history_classic")
        },
        **{
            name: {**SOLID, "tangential": name}
            for name in (
                "mindlin",
                "mindlin/force",
                "mindlin_rescale",
                "mindlin_rescale/force",
                "mindlin_classic",
            )
        },
    },
    two_materials=("mindlin", "mindlin_rescale/force"),
)
"""Tangential forces, with friction."""

_OLD_SPRING = {**SPRING, **MASSIVE, **OLD}

OLD_TANGENTIAL = named(
    {
        "old hooke": {**_OLD_SPRING, "tangential": "linear_nohistory"},
        "old hooke/history": {**_OLD_SPRING, "tangential": "linear_history_classic"},
        "old hertz/history": {**SOLID, "tangential": "mindlin_classic", **OLD},
    }
)
"""The earlier interface, with friction."""

STICKING = {**SPRING, "tangential": "linear_history"}
SOLID_STICKING = {**SOLID, "tangential": "mindlin"}
ROLLS = {
    "rolling": "sds",
    "rolling_stiffness": 2e4,
    "rolling_damping": 0.5,
    "rolling_friction": 0.05,
}
TWISTS = {
    "twisting": "sds",
    "twisting_stiffness": 1.0,
    "twisting_damping": 5e-5,
    "twisting_friction": 1e-4,
}

ROLLING = named(
    {
        "rolling sds, linear_history": {**STICKING, **ROLLS},
        "rolling sds, mindlin": {**SOLID_STICKING, **ROLLS},
    },
    two_materials=("rolling sds, mindlin",),
)
"""Rolling resistance, beside friction that keeps the sphere rolling."""

TWISTING = named(
    {
        "twisting sds, linear_history": {**STICKING, **TWISTS},
        "twisting sds, mindlin": {**SOLID_STICKING, **TWISTS},
        "twisting marshall, linear_history": {
            **{**STICKING, "damping_coefficient": 20.0},
            "twisting": "marshall",
        },
        "twisting marshall, mindlin": {**SOLID_STICKING, "twisting": "marshall"},
    },
    two_materials=("twisting marshall, mindlin",),
)
"""Twisting resistance."""

_ALIKE = (2.0 * (1.0 - 0.3) / (2.0 - 0.3)) ** 0.5
"""x_t of the same share of critical damping along and across, 2 sqrt(m* k): sqrt(4 G*/E*)."""

STICKS_AT_TOUCH = 0.6
"""Friction with which impacts at 45 degrees begin to stick: more than x_t times v_t / v_n.

At touch dashpots grow as overlap^(1/4), the elastic force as overlap^(3/2). Sliding, Coulomb's
limit leaves a spring of eta_n (x_t v_t - mu v_n) / (8 G* a), as overlap^(-1/4): beyond all bounds,
so that the first step decides, however short. A spring that holds the force (mindlin/force) has no
a below it; sliding without a dashpot, x_t = 0, leaves one that vanishes at touch.
"""

PULLS_LITTLE = 0.9
"""Restitution that leaves a limit to 1e-4 where a dashpot pulls at the end of an impact.

As the force passes zero Coulomb's limit does, and cuts the spring back to the limit of the next
step. The pull is 2 zeta e of the largest force at most (as in a linear contact): of the velocity
2 zeta e mu pi/2 (1 + e) / n is left, n the steps: 7e-5 at level default, 1.2e-4 for 0.8.
"""

_RETURNED = {**HERTZ, **CONSTANT, "clipped": True}
_SOFT = {"tangential": "linear_history", "tangential_stiffness": 2e5 / 7.0}

NORMAL_BESIDE = named({"hertz, coeff_restitution, clipped": _RETURNED})
"""Normal forces that codes state which have none that attracts."""

TANGENTIAL_BESIDE = named(
    {
        "linear_history, elastic": {**HOOKE, "tangential": "linear_history"},
        "linear_history, 2/7, elastic": {**HOOKE, **_SOFT},
        "linear_history, 2/7": {**SPRING, **_SOFT},
        "linear_history, clipped": {**SPRING, "tangential": "linear_history", "clipped": True},
        "mindlin, elastic": {**HERTZ, "tangential": "mindlin"},
        "mindlin/force, elastic": {**HERTZ, "tangential": "mindlin/force"},
        "mindlin_rescale/force, elastic": {**HERTZ, "tangential": "mindlin_rescale/force"},
        "mindlin, coeff_restitution": {
            **{**HERTZ, **CONSTANT, "restitution": PULLS_LITTLE},
            **{"tangential": "mindlin", "tangential_damping": 0.5, "friction": STICKS_AT_TOUCH},
        },
        "mindlin, coeff_restitution, clipped": {**_RETURNED, "tangential": "mindlin"},
        "mindlin/force, coeff_restitution, clipped": {
            **_RETURNED,
            "tangential": "mindlin/force",
            "tangential_damping": _ALIKE,
        },
    },
    two_materials=(
        *("mindlin, elastic", "mindlin/force, elastic", "mindlin_rescale/force, elastic"),
        "mindlin, coeff_restitution, clipped",
    ),
)
"""Friction beside these normal forces, and without dissipation."""

_TIED = {"rolling_stiffness": 2e5 / 7.0, "rolling_damping": 0.0, "rolling_friction": 0.05}

_AI = {**_TIED, "rolling_stiffness": 2.25 * 1e5 * 0.05**2, "rolling_damping": 0.5}
"""Stiffness 2.25 k_n mu_r^2: Ai, Chen, Rotter and Ooi, Powder Technol. 206, 269 (2011)."""

ROLLING_BESIDE = named(
    {
        "rolling sds, linear_history, tied": {**STICKING, "rolling": "sds", **_TIED},
        "rolling sds, mindlin/force, elastic": {
            **HERTZ,
            "tangential": "mindlin/force",
            "rolling": "sds",
            **_TIED,
        },
        "rolling sds, linear_history, of Ai": {**STICKING, "rolling": "sds", **_AI},
    }
)
"""Rolling springs as stiff as the tangential one, without a dashpot, and one tied to k_n."""

TWISTING_BESIDE = named(
    {
        "twisting sds, linear_history, tied": {
            **STICKING,
            "twisting": "sds",
            "twisting_stiffness": 2e1 / 7.0,
            "twisting_damping": 0.0,
            "twisting_friction": 1e-4,
        }
    }
)
"""A twisting spring without a dashpot, of k_t R*^2 for the sphere of 1 cm on a plane."""
