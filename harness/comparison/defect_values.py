"""Numbers that entries of known defects name: what a defect makes of a scene's coefficients."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, get_args

from harness.model.base import Parameters, Vector
from harness.model.law import COEFFICIENTS, Law
from harness.model.scene import Scene


def check_switch(part: str, kind: type[Parameters], values: Mapping[str, Any]) -> None:
    """Raise ValueError for a field that a switch does not have, or a value that it cannot take."""
    plain = {}
    for name, value in values.items():
        if name not in kind.model_fields:
            raise ValueError(f"{part}.{name}: must be one of {', '.join(kind.model_fields)}")
        names, is_flag = _names(part, name, kind), kind.model_fields[name].annotation is bool
        if is_flag and not isinstance(value, bool):
            raise ValueError(f"{part}.{name} = {value!r}: must be true or false")
        if isinstance(value, str) and value not in names:
            raise ValueError(f"{part}.{name} = {value!r}: must be {' or '.join(names)}")
        if part == "law" and not isinstance(value, (str, int, float)):
            raise ValueError(f"{part}.{name} = {value!r}: must be a number or {' or '.join(names)}")
        if part != "law" and not isinstance(value, str):  # a law is checked in its scene
            plain[name] = value
    kind(**plain)


def _names(part: str, name: str, kind: type[Parameters]) -> list[str]:
    """Return the words of a field, and the values and coefficients that it may name."""
    words = [word for word in get_args(kind.model_fields[name].annotation) if isinstance(word, str)]
    values = [] if part == "rules" else sorted(VALUES)
    return [*words, *values, *(sorted(COEFFICIENTS) if name in COEFFICIENTS else [])]


def value_in(scene: Scene, value: Any, field: str) -> Any:
    """Return the value of a field in a scene, where it has the name of one or of a coefficient."""
    if not isinstance(value, str):
        return value
    if value in COEFFICIENTS and field in COEFFICIENTS:
        return getattr(contact_law(scene), value) or 0.0
    return VALUES[value](scene) if value in VALUES else value


def with_law(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """Return a scene with another law, whose contact its steps need not resolve."""
    laws = tuple(row._replace(law=row.law.replace(**changes)) for row in scene.laws)
    return scene.model_copy(update={"law": scene.law.replace(**changes), "laws": laws})


def contact_law(scene: Scene) -> Law:
    """Return the law of a scene's first contact."""
    types = [*(body.type for body in scene.bodies), *(wall.type for wall in scene.walls)]
    return scene.law_of(*types[:2]) if len(types) > 1 else scene.law


def _poisson_ratio(scene: Scene) -> float:
    """Return nu of the one material with E* and G* of both bodies, 0 without a material."""
    return contact_law(scene).one_material.poisson_ratio or 0.0


def _has_material(scene: Scene) -> bool:
    law = contact_law(scene)
    return law.materials is not None and law.interface == "current"


def _normal_modulus_factor(scene: Scene) -> float:
    """Return 1 + nu [-]: E / (2 (1 - nu)) over E / (2 (1 - nu^2))."""
    return 1.0 + _poisson_ratio(scene) if _has_material(scene) else 1.0


def _shear_modulus_factor(scene: Scene) -> float:
    """Return E/4 (2 - nu) (1 + nu) over 8 E/4 / ((2 - nu) (1 + nu)) [-]."""
    nu = _poisson_ratio(scene)
    return ((2.0 - nu) * (1.0 + nu)) ** 2 / 8.0 if _has_material(scene) else 1.0


def _mixed_shear_factor(scene: Scene) -> float:
    """Return G* [-] over the right one, of a body whose E is the mixed E*, nu the mixed nu."""
    law = contact_law(scene)
    if law.materials is None or law.moduli is None:
        return 1.0
    nu = math.sqrt(law.materials[0][1] * law.materials[1][1])
    return law.moduli[0] / (4.0 * (2.0 - nu) * (1.0 + nu)) / law.moduli[1]


def _mixed_normal_stiffness(scene: Scene) -> float:
    """Return the geometric mean of 4/3 E* of both bodies [N/m]."""
    materials = contact_law(scene).materials or ((1.0, 0.0),)
    return math.prod(math.sqrt(2.0 / 3.0 * e / (1.0 - nu * nu)) for e, nu in materials)


def _mixed_damping(scene: Scene) -> str:
    """Return the dashpot that takes the coefficient of the scene's: velocity for those of hertz."""
    damping = contact_law(scene).damping
    return "velocity" if damping in ("viscoelastic", "tsuji") else damping


def _mixed_dashpot(scene: Scene) -> float | None:
    """Return the coefficient [kg/s] that the dashpot takes: alpha(e) of tsuji."""
    from harness.solvers.reference import tsuji  # compiled: slow to import

    law = contact_law(scene)
    return tsuji(law.restitution or 0.0) if law.damping == "tsuji" else law.damping_coefficient


def _mixed_tangential_stiffness(scene: Scene) -> float:
    """Return the geometric mean of 8 G* of both bodies [N/m]."""
    materials = contact_law(scene).materials or ((1.0, 0.0),)
    return math.prod(math.sqrt(2.0 * e / ((2.0 - nu) * (1.0 + nu))) for e, nu in materials)


def _shear_along_x(scene: Scene) -> Vector:
    """Return the speed [m/s] of the surface of a cylinder that turns about z, along x."""
    turning = [-wall.spin[2] * (wall.radius or 0.0) for wall in scene.walls]
    return (next(filter(None, turning), 0.0), 0.0, 0.0)


def _thin_skin(scene: Scene) -> float:
    """Return half of the longest neck of JKR between the smallest bodies [m]."""
    law, least = contact_law(scene), min(body.radius for body in scene.bodies)
    if law.normal != "jkr" or law.moduli is None:
        return 0.01 * least
    cube = 9.0 * math.pi * (law.surface_energy or 0.0) * (0.5 * least) ** 2 / (4.0 * law.moduli[0])
    return min(0.01 * least, 0.5 * math.pow(cube, 2.0 / 3.0) / (1.5 * least))


VALUES: Mapping[str, Callable[[Scene], float | str | Vector | None]] = {
    "normal_modulus_factor": _normal_modulus_factor,
    "shear_modulus_factor": _shear_modulus_factor,
    "mixed_shear_factor": _mixed_shear_factor,
    "mixed_normal_stiffness": _mixed_normal_stiffness,
    "mixed_damping": _mixed_damping,
    "mixed_dashpot": _mixed_dashpot,
    "mixed_tangential_stiffness": _mixed_tangential_stiffness,
    "shear_along_x": _shear_along_x,
    "thin_skin": _thin_skin,
}
