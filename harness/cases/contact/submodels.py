"""Tables of the contact cases: submodels, systems of bodies, and presets of the literature.

A submodel is the law of a row of the matrix, a system the bodies of its column. The shortest level
leaves out submodels in which several parts act together.

Sources of the presets. ``CO``: Chung and Ooi, Granular Matter 13, 643 (2011), tests 1 to 8, each
with two materials, with the values of three public restatements: Kratos (KratosMultiphysics/Kratos,
applications/DEMApplication/tests, DEM3D_chung_ooi_tests, and its DEM_benchmarks), Yade (its
benchmarks Test1.py to Test4.py of Angelidakis, Chareyre and Caulk) and PySPH (examples of its
discontinuous DEM). A rigid wall is stated by twice the modulus of the sphere, in both bodies: that
makes E* and G* those of a sphere on a rigid plane. ``MFiX``: MFiX 21.3.2,
tests/dem/DEM01 to DEM05, files mfix.dat and particle_input.dat. Kharaz, Gorham and Salman, Powder
Technology 120, 281 (2001): aluminium oxide on glass, two materials.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from typing import Any

Told = Mapping[str, Mapping[str, Any]]
"""Values of parameters, by the name of what they state."""

SLIDING = {"tangential": "linear_history", "friction": 0.3}
"""A linear contact that slides and sticks."""


def _solid(modulus: float, poisson: float, density: float, radius: float) -> dict[str, Any]:
    return {
        "normal": "hertz",
        "youngs_modulus": modulus,
        "poisson_ratio": poisson,
        "density": density,
        "radius": radius,
    }


def _spring(stiffness: float, density: float, radius: float) -> dict[str, Any]:
    return {
        "normal": "hooke",
        "normal_stiffness": stiffness,
        "density": density,
        "radius": radius,
    }


def _restitution(e: float) -> dict[str, Any]:
    return {"damping": "coeff_restitution", "restitution": e}


def _made_of(modulus: float, poisson: float, density: float) -> dict[str, Any]:
    return {"youngs_modulus": modulus, "poisson_ratio": poisson, "density": density}


_SPHERE = {"partner": "sphere"}
_OXIDE = _solid(2 * 380e9, 0.23, 4000.0, 2.5e-3)  # CO 3, 4: Kratos, Materials4.json
_ALLOY = _solid(70e9, 0.33, 2700.0, 0.1)  # CO 6 to 8: PySPH, tests 6 and 8
_SLIDES = {"tangential": "mindlin_rescale", "tangential_damping": 0.0}
_MFIX_GRAVITY = 9.80665  # MFiX: the default of SI units

SOURCES = {
    "chung-ooi": "Chung and Ooi, Granular Matter 13, 643 (2011), the test of this number",
    "kharaz": "Kharaz, Gorham and Salman, Powder Technology 120, 281 (2001)",
    "mfix-dem": "MFiX-DEM's verification, the test of this number",
}
"""Where presets were published, by the start of their names."""

HEAD_ON: Told = {
    # CO 1: Kratos, Materials1.json; each sphere at 10 m/s
    "chung-ooi-1": {**_solid(48e9, 0.2, 2800.0, 0.01), **_SPHERE, "speed": 20.0},
    # CO 2: 0.2 m/s on a rigid wall
    "chung-ooi-2": {**_solid(2 * 70e9, 0.3, 2699.0, 0.1), "speed": 0.2},
    # CO 3: restitution 0 to 1, one of them
    "chung-ooi-3": {**_OXIDE, **_restitution(0.5), "speed": 3.9},
}
HEAD_ON = {
    **HEAD_ON,
    # the second materials: Yade, Test1.py to Test3.py
    "chung-ooi-1-limestone": {**HEAD_ON["chung-ooi-1"], **_made_of(20e9, 0.25, 2500.0)},
    "chung-ooi-2-magnesium": {**HEAD_ON["chung-ooi-2"], **_made_of(2 * 40e9, 0.35, 1800.0)},
    "chung-ooi-3-iron": {**HEAD_ON["chung-ooi-3"], **_made_of(2 * 100e9, 0.25, 7000.0)},
}

OBLIQUE: Told = {
    # CO 4: Kratos, Materials4.json; 3.9 m/s at 5 to 85 degrees, one of them
    "chung-ooi-4": {
        **_OXIDE,
        **_SLIDES,
        **_restitution(0.98),
        "friction": 0.092,
        "speed": 3.9,
        "angle": 30.0,
    },
    # Kharaz et al.: 5 mm of aluminium oxide on an anvil of soda-lime glass, E 70 GPa and nu 0.25;
    # mu and e as measured there. Chung and Ooi's test 4 takes the anvil as rigid
    "kharaz": {
        **_solid(380e9, 0.23, 4000.0, 2.5e-3),
        "partner_youngs_modulus": 70e9,
        "partner_poisson_ratio": 0.25,
        **_SLIDES,
        **_restitution(0.98),
        "friction": 0.092,
        "speed": 3.9,
        "angle": 30.0,
    },
    # CO 5: PySPH, test 5, steel: E 208 GPa, nu 0.3, 7850 kg/m3, 10 um, elastic, mu 0.3; 5 m/s along
    # the normal (Kratos, class Benchmark5, too) at any angle, here 45 degrees
    "chung-ooi-5": {
        **_solid(2 * 208e9, 0.3, 7850.0, 1e-5),
        **_SLIDES,
        "friction": 0.3,
        "speed": 7.0710678118654755,
        "angle": 45.0,
    },
    # MFiX DEM05, LSD: KN 1.72e7, KT_FAC 1.48/1.72, e 1, MEW_W 0.092, D_p0 5 mm, RO_s0 4000;
    # particle_input.dat: 3.9 m/s at 0 to 65 degrees, one of them. Its Hertzian variant has two
    # materials, which are not stated here
    "mfix-dem05": {
        **_spring(1.72e7, 4000.0, 2.5e-3),
        "tangential": "linear_history",
        "tangential_stiffness": 1.48e7,
        "friction": 0.092,
        "speed": 3.9,
        "angle": 30.0,
    },
}
OBLIQUE = {
    **OBLIQUE,
    # the second materials: Yade, Test4.py (an aluminium alloy), and PySPH, test 5
    "chung-ooi-4-alloy": {**OBLIQUE["chung-ooi-4"], **_made_of(2 * 70e9, 0.33, 2700.0)},
    "chung-ooi-5-polyethylene": {**OBLIQUE["chung-ooi-5"], **_made_of(2 * 1e9, 0.4, 1400.0)},
}

# CO 6 to 8: mu 0.4, e 0.5, 0.2 m/s (Kratos, classes Benchmark6 to 8; PySPH), spins of 0.175 to
# 22 rad/s (PySPH), one of them
_ROLLS = {**_SLIDES, **_restitution(0.5), "friction": 0.4, "speed": 0.2, "spin": 10.0}

SPIN: Told = {
    # CO 6: a rigid plane
    "chung-ooi-6": {**_ALLOY, "youngs_modulus": 2 * 70e9, **_ROLLS},
    # CO 7: both spheres at 0.2 m/s, their spins opposite: nothing slips (PySPH prints 7e11 Pa here
    # and 7e10 in its tests 6 and 8)
    "chung-ooi-7": {**_ALLOY, **_ROLLS, **_SPHERE, "speed": 0.4, "partner_spin": -10.0},
    # CO 8: PySPH: the second is 5 times as large and 1000 times as dense: as good as fixed
    "chung-ooi-8": {**_ALLOY, **_ROLLS, "partner": "frozen", "partner_radius": 0.5},
}
SPIN = {
    **SPIN,
    # the second materials: PySPH, tests 6 to 8
    "chung-ooi-6-nylon": {**SPIN["chung-ooi-6"], **_made_of(2 * 2.5e9, 0.4, 1000.0)},
    "chung-ooi-7-copper": {**SPIN["chung-ooi-7"], **_made_of(120e9, 0.35, 8900.0)},
    "chung-ooi-8-nylon": {**SPIN["chung-ooi-8"], **_made_of(2.5e9, 0.4, 1000.0)},
}

BOUNCE: Told = {
    # MFiX DEM01: KN_W 1e4, DES_EN_WALL_INPUT 0.9, D_p0 0.2, RO_s0 2600; falls from 0.5 m
    # (POST_POS.dat), its centre
    "mfix-dem01": {
        **_spring(1e4, 2600.0, 0.1),
        **_restitution(0.9),
        "height": 0.4,
        "gravity": _MFIX_GRAVITY,
    },
}
# MFiX DEM02: KN_W 5e4, restitution 1 to 0.5 (POST_HEIGHT.dat), one of them
BOUNCE = {**BOUNCE, "mfix-dem02": {**BOUNCE["mfix-dem01"], "normal_stiffness": 5e4}}

STACKED: Told = {
    # MFiX DEM03: KN 5e4, e 1, D_p0 1 mm, RO_s0 2e4 below and 1e4 above, YLENGTH 1.8 mm;
    # particle_input.dat: centres at 0.45 and 1.35 mm
    "mfix-dem03": {
        **_spring(5e4, 2e4, 5e-4),
        **_SPHERE,
        "upper_density": 1e4,
        "squeeze": 0.1,
        "offset": 1.0 / 30.0,
        "upper_offset": -1.0 / 30.0,
        "gravity": _MFIX_GRAVITY,
    },
}

SLIP_TO_ROLL: Told = {
    # MFiX DEM04: KN_W 1e4, KT_W_FAC 1, e 1, MEW_W 0.2 to 1, one of them, D_p0 1 mm, RO_s0 1e4;
    # particle_input.dat: 0.1 m/s
    "mfix-dem04": {
        **_spring(1e4, 1e4, 5e-4),
        "tangential": "linear_history",
        "tangential_stiffness": 1e4,
        "friction": 0.2,
        "speed": 0.1,
        "gravity": _MFIX_GRAVITY,
    },
}


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

    def row_name(self, case: str, engine: str) -> str:
        """Return how the names of its rows begin, in a case and an engine of these names."""
        return f"{case}, {self.system}: {self.submodel}, {engine}"


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


STIFF = {"damping": "mdr", "damping_coefficient": 0.25}
YIELDS = {**MDR, "yield_stress": 1e6}
RESPONDS = {**MDR, "bulk_response": True}
_ONE_FLAT = ("wall", "two spheres", "frozen sphere")

BRANCHES = (
    Submodel("mdr, mdr damping", {**MDR, **STIFF}, _ONE_FLAT, quick=False),
    Submodel("mdr, yield", YIELDS, _ONE_FLAT),
    Submodel("mdr, bulk", RESPONDS, _ONE_FLAT, quick=False),
)
"""What mdr has beside its elastic branch, of one contact, and the dashpot that goes with it."""

TOGETHER = (
    Submodel("mdr, yield, velocity", {**YIELDS, **SLOW}, _ONE_FLAT, quick=False),
    Submodel("mdr, yield, mdr damping", {**YIELDS, **STIFF}, _ONE_FLAT, quick=False),
    Submodel("mdr, bulk, velocity", {**RESPONDS, **SLOW}, _ONE_FLAT, quick=False),
    Submodel("mdr, yield, bulk", {**YIELDS, "bulk_response": True}, _ONE_FLAT, quick=False),
)
"""Branches of mdr together and with its dashpots.

A bulk that responds from the first touch on takes all that is displaced: beside it nothing yields.
"""

_SPRING = {"tangential": "linear_history", "tangential_stiffness": 5e4}
_SOLID = {"tangential": "mindlin"}

RUBBING = (
    Submodel("mdr, linear_history", {**MDR, **_SPRING}, quick=False),
    Submodel("mdr, mindlin", {**MDR, **_SOLID}, quick=False),
    Submodel(
        "mdr, mindlin_rescale/force", {**MDR, "tangential": "mindlin_rescale/force"}, quick=False
    ),
    Submodel(
        "mdr, velocity, linear_history",
        {**MDR, **SLOW, **_SPRING, "tangential_damping": 0.5},
        quick=False,
    ),
    Submodel("mdr, yield, linear_history", {**YIELDS, **_SPRING}, _ONE_FLAT, quick=False),
    Submodel("mdr, yield, mindlin", {**YIELDS, **_SOLID}, _ONE_FLAT, quick=False),
    Submodel("mdr, bulk, mindlin", {**RESPONDS, **_SOLID}, _ONE_FLAT, quick=False),
)
"""Friction beside mdr: elastic, with a dashpot, yielding, and under the load of its bulk."""

STICKING_FLAT = Submodel("mdr, adhesion", {**MDR, "surface_energy": 0.5}, _ONE_FLAT, quick=False)
"""mdr's adhesion."""


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
    each
    for each in (*ROLLING, *ROLLING_BESIDE)
    if each.name in ("rolling sds, linear_history", "rolling sds, linear_history, of Ai")
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
