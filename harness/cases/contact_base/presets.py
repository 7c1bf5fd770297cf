"""Sets of parameters that the literature of verification knows, as those of the cases.

``CO``: Chung and Ooi, Granular Matter 13, 643 (2011), tests 1 to 8, with the values of two public
restatements: Kratos (KratosMultiphysics/Kratos, applications/DEMApplication/tests,
DEM3D_chung_ooi_tests, and its DEM_benchmarks) and PySPH (examples of its discontinuous DEM). A
rigid wall is stated by twice the modulus of the sphere, in both bodies: that makes E* and G* those
of a sphere on a rigid plane. ``MFiX``: MFiX 21.3.2, tests/dem/DEM01 to DEM05, files mfix.dat and
particle_input.dat. Kharaz, Gorham and Salman, Powder Technology 120, 281
(2001): aluminium oxide on glass, two materials.
"""

from __future__ import annotations

from collections.abc import Mapping
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


_SPHERE = {"partner": "sphere"}
_OXIDE = _solid(2 * 380e9, 0.23, 4000.0, 2.5e-3)  # CO 3, 4: Kratos, Materials4.json
_ALLOY = _solid(70e9, 0.33, 2700.0, 0.1)  # CO 6 to 8: PySPH, tests 6 and 8
_SLIDES = {"tangential": "mindlin_rescale", "tangential_damping": 0.0}
_MFIX_GRAVITY = 9.80665  # MFiX: the default of SI units

HEAD_ON: Told = {
    # CO 1: Kratos, Materials1.json; each sphere at 10 m/s
    "chung-ooi-1": {**_solid(48e9, 0.2, 2800.0, 0.01), **_SPHERE, "speed": 20.0},
    # CO 2: 0.2 m/s on a rigid wall
    "chung-ooi-2": {**_solid(2 * 70e9, 0.3, 2699.0, 0.1), "speed": 0.2},
    # CO 3: restitution 0 to 1, one of them
    "chung-ooi-3": {**_OXIDE, **_restitution(0.5), "speed": 3.9},
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
    # the normal (Kratos, class Benchmark5, too) at any angle, here 45 degrees. Polyethylene: 1 GPa,
    # 0.4, 1400 kg/m3
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

# CO 6 to 8: mu 0.4, e 0.5, 0.2 m/s (Kratos, classes Benchmark6 to 8; PySPH), spins of 0.175 to
# 22 rad/s (PySPH), one of them
_ROLLS = {**_SLIDES, **_restitution(0.5), "friction": 0.4, "speed": 0.2, "spin": 10.0}

SPIN: Told = {
    # CO 6: a rigid plane. Nylon: 2.5 GPa, 0.4, 1000 kg/m3
    "chung-ooi-6": {**_ALLOY, "youngs_modulus": 2 * 70e9, **_ROLLS},
    # CO 7: both spheres at 0.2 m/s, their spins opposite: nothing slips (PySPH prints 7e11 Pa here
    # and 7e10 in its tests 6 and 8)
    "chung-ooi-7": {**_ALLOY, **_ROLLS, **_SPHERE, "speed": 0.4, "partner_spin": -10.0},
    # CO 8: PySPH: the second is 5 times as large and 1000 times as dense: as good as fixed
    "chung-ooi-8": {**_ALLOY, **_ROLLS, "partner": "frozen", "partner_radius": 0.5},
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
