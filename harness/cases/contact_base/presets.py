"""Sets of parameters that the literature of verification knows, as those of the cases.

Chung and Ooi, Granular Matter 13, 643 (2011), tests 1 to 8: a rigid wall is stated by twice the
modulus of the sphere, as both bodies are of one material here; their spheres of tests 6 to 8 are
of the aluminium alloy. MFiX: its verification manual, DEM01 to DEM05. Kharaz, Gorham and Salman,
Powder Technology 120, 281 (2001): aluminium oxide on glass.
"""

from __future__ import annotations

from typing import Any

Told = dict[str, dict[str, Any]]


def _solid(modulus: float, poisson: float, density: float, radius: float) -> dict[str, Any]:
    return {
        "normal": "hertz",
        "youngs_modulus": modulus,
        "poisson_ratio": poisson,
        "density": density,
        "radius": radius,
    }


_SPHERE = {"partner": "sphere"}
_ALLOY = _solid(2 * 70e9, 0.3, 2699.0, 0.1)
_OXIDE = _solid(2 * 380e9, 0.23, 4000.0, 2.5e-3)
_SLIDES = {"tangential": "mindlin_rescale", "tangential_damping": 0.0}
_HALF = {"damping": "coeff_restitution", "restitution": 0.5}

HEAD_ON: Told = {
    "chung-ooi-1": {**_solid(48e9, 0.2, 2800.0, 0.01), **_SPHERE, "speed": 20.0},
    "chung-ooi-2": {**_ALLOY, "speed": 0.2},
    "chung-ooi-3": {**_OXIDE, **_HALF, "speed": 3.9},
}

OBLIQUE: Told = {
    "chung-ooi-4": {
        **_OXIDE,
        **_SLIDES,
        "damping": "coeff_restitution",
        "restitution": 0.98,
        "friction": 0.092,
        "speed": 3.9,
        "angle": 30.0,
    },
    "chung-ooi-5": {
        **_solid(2 * 208e9, 0.3, 7850.0, 1e-5),
        **_SLIDES,
        "friction": 0.3,
        "speed": 7.0710678118654755,
        "angle": 45.0,
    },
    "mfix-dem04": {
        "normal": "hooke",
        "normal_stiffness": 1e7,
        "tangential": "linear_history",
        "friction": 0.4,
        "speed": 5.0,
        "angle": 45.0,
        "radius": 0.05,
        "density": 2600.0,
    },
}
OBLIQUE["kharaz"] = OBLIQUE["chung-ooi-4"]

_ROLLS = {**_SLIDES, **_HALF, "friction": 0.4, "speed": 0.2, "spin": 10.0}

SPIN: Told = {
    "chung-ooi-6": {**_solid(2 * 70e9, 0.33, 2700.0, 0.1), **_ROLLS},
    "chung-ooi-7": {**_solid(70e9, 0.33, 2700.0, 0.1), **_ROLLS, **_SPHERE},
    "chung-ooi-8": {
        **_solid(70e9, 0.33, 2700.0, 0.1),
        **_ROLLS,
        **_SPHERE,
        "partner_radius": 0.2,
    },
}

BOUNCE: Told = {
    "mfix-dem01": {
        "normal": "hooke",
        "normal_stiffness": 1e4,
        **_HALF,
        "radius": 0.1,
        "density": 2600.0,
        "height": 0.4,
    },
}
BOUNCE["mfix-dem02"] = {**BOUNCE["mfix-dem01"], "normal_stiffness": 5e4, "height": 0.4}
