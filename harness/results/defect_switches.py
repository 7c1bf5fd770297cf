"""Switches of the reference: their values in a scene, and conventions under which a run holds.

An entry of a known defect may give a number by name where it depends on the scene: another
coefficient of the scene's law, or a value of :data:`VALUES`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, get_args

from harness.errors import EngineNaNError, RequestError
from harness.model.base import Parameters, Vector
from harness.model.conventions import Faults, Rules
from harness.model.law import COEFFICIENTS, Law
from harness.model.motion import Motion
from harness.model.scene import Scene


def switched_motion(
    scene: Scene,
    rules: Rules,
    switches: Mapping[str, Mapping[str, Any]],
    fitted: Mapping[str, Any] | None = None,
) -> Motion | None:
    """Return the motion of the reference with switches, None where it has none.

    ``switches`` are the fields of an entry's ``faults``, ``rules`` and ``law``; ``fitted`` are
    further fields of the faults.
    """
    from harness.solvers import reference  # compiled: slow to import

    values = {
        part: {name: value_in(scene, value, name) for name, value in fields.items()}
        for part, fields in switches.items()
    }
    try:
        altered = _with_law(scene, values["law"]) if values["law"] else scene
        faults = Faults(**values["faults"], **(fitted or {}))
        return reference.run(altered, rules.replace(**values["rules"]), faults)
    except (RequestError, EngineNaNError):
        return None


def passing_rules(scene: Scene, rules: Rules, holds: Callable[[Motion], bool]) -> list[str]:
    """Return the single conventions, as ``wall_lever = height``, under which a run holds."""
    found = []
    for name, field in Rules.model_fields.items():
        words = (True, False) if field.annotation is bool else get_args(field.annotation)
        for word in words:
            if word == getattr(rules, name):
                continue
            switches = {"faults": {}, "rules": {name: word}, "law": {}}
            motion = switched_motion(scene, rules, switches)
            if motion is not None and holds(motion):
                found.append(f"{name} = {word}")
    return found


def check_switch(part: str, kind: type[Parameters], values: Mapping[str, Any]) -> None:
    """Raise ValueError for a field that a switch does not have, or a value that it cannot take."""
    plain = {}
    for name, value in values.items():
        if name not in kind.model_fields:
            raise ValueError(f"{part}.{name}: must be one of {', '.join(kind.model_fields)}")
        words = _words(part, name, kind)
        if kind.model_fields[name].annotation is bool and not isinstance(value, bool):
            raise ValueError(f"{part}.{name} = {value!r}: must be true or false")
        if isinstance(value, str) and value not in words:
            raise ValueError(f"{part}.{name} = {value!r}: must be {' or '.join(words)}")
        if part == "law" and not isinstance(value, (str, int, float)):
            raise ValueError(f"{part}.{name} = {value!r}: must be a number or {' or '.join(words)}")
        if part != "law" and not isinstance(value, str):  # a law is checked in its scene
            plain[name] = value
    kind(**plain)


def value_in(scene: Scene, value: Any, field: str) -> Any:
    """Return the value of a field in a scene, computed where it is given by name."""
    if not isinstance(value, str):
        return value
    if value in COEFFICIENTS and field in COEFFICIENTS:
        return getattr(_first_law(scene), value) or 0.0
    return VALUES[value](scene) if value in VALUES else value


def _words(part: str, name: str, kind: type[Parameters]) -> list[str]:
    """Return the words of a field, and the values and coefficients that it may name."""
    words = [word for word in get_args(kind.model_fields[name].annotation) if isinstance(word, str)]
    values = [] if part == "rules" else sorted(VALUES)
    return [*words, *values, *(sorted(COEFFICIENTS) if name in COEFFICIENTS else [])]


def _with_law(scene: Scene, changes: Mapping[str, Any]) -> Scene:
    """Return a scene with another law, without the check that its steps resolve the contact."""
    laws = tuple(entry._replace(law=entry.law.replace(**changes)) for entry in scene.laws)
    return scene.model_copy(update={"law": scene.law.replace(**changes), "laws": laws})


def _first_law(scene: Scene) -> Law:
    """Return the law between the first two bodies, or the first body and wall."""
    types = [*(body.type for body in scene.bodies), *(wall.type for wall in scene.walls)]
    return scene.law_of(*types[:2]) if len(types) > 1 else scene.law


# ---- values by name. E* and G* are those of Johnson (1985), equations 4.3 and 7.43.


def _poisson_ratio(scene: Scene) -> float | None:
    """Return nu of the one material with E* and G* of both bodies, None without a material."""
    law = _first_law(scene)
    current = law.materials is not None and law.interface == "current"
    return (law.one_material.poisson_ratio or 0.0) if current else None


def normal_modulus_factor(scene: Scene) -> float:
    """Return E / (2 (1 - nu)) over E / (2 (1 - nu^2)) = 1 + nu [-], 1 without a material."""
    nu = _poisson_ratio(scene)
    return 1.0 if nu is None else 1.0 + nu


def shear_modulus_factor(scene: Scene) -> float:
    """Return E/4 (2 - nu) (1 + nu) over 8 E/4 / ((2 - nu) (1 + nu)) [-], 1 without a material."""
    nu = _poisson_ratio(scene)
    return 1.0 if nu is None else ((2.0 - nu) * (1.0 + nu)) ** 2 / 8.0


def mixed_shear_factor(scene: Scene) -> float:
    """Return the G* [-], over the right one, of two bodies with E = E* and the mixed nu."""
    law = _first_law(scene)
    if law.materials is None or law.moduli is None:
        return 1.0
    nu = math.sqrt(law.materials[0][1] * law.materials[1][1])
    return law.moduli[0] / (4.0 * (2.0 - nu) * (1.0 + nu)) / law.moduli[1]


def mixed_normal_stiffness(scene: Scene) -> float:
    """Return the geometric mean of 4/3 E* of both materials, each with itself, as N/m."""
    materials = _first_law(scene).materials or ((1.0, 0.0),)
    return math.prod(math.sqrt(2.0 / 3.0 * e / (1.0 - nu * nu)) for e, nu in materials)


def mixed_tangential_stiffness(scene: Scene) -> float:
    """Return the geometric mean of 8 G* of both materials, each with itself, as N/m."""
    materials = _first_law(scene).materials or ((1.0, 0.0),)
    return math.prod(math.sqrt(2.0 * e / ((2.0 - nu) * (1.0 + nu))) for e, nu in materials)


def mixed_damping(scene: Scene) -> str:
    """Return the dashpot that takes the coefficient of a dashpot of hertz: that of velocity."""
    damping = _first_law(scene).damping
    return "velocity" if damping in ("viscoelastic", "tsuji") else damping


def mixed_dashpot(scene: Scene) -> float | None:
    """Return the coefficient that this dashpot takes, as kg/s: alpha(e) of tsuji, else its own."""
    from harness.solvers.reference import tsuji  # compiled: slow to import

    law = _first_law(scene)
    return tsuji(law.restitution or 0.0) if law.damping == "tsuji" else law.damping_coefficient


def shear_along_x(scene: Scene) -> Vector:
    """Return the speed [m/s] of the surface of a cylinder that turns about z, along x."""
    turning = [-wall.spin[2] * (wall.radius or 0.0) for wall in scene.walls]
    return (next(filter(None, turning), 0.0), 0.0, 0.0)


def thin_skin(scene: Scene) -> float:
    """Return half of the longest neck of jkr between the smallest bodies [m].

    The neck at the largest tension of equal spheres is a^2 / (3 R*) with
    a^3 = 9 pi gamma R*^2 / (4 E*) at that tension (Johnson, Kendall and Roberts 1971).
    """
    law, radius = _first_law(scene), min(body.radius for body in scene.bodies)
    if law.normal != "jkr" or law.moduli is None:
        return 0.01 * radius
    cube = 9.0 * math.pi * (law.surface_energy or 0.0) * (0.5 * radius) ** 2 / (4.0 * law.moduli[0])
    return min(0.01 * radius, 0.5 * math.pow(cube, 2.0 / 3.0) / (1.5 * radius))


_FUNCTIONS: Sequence[Callable[[Scene], float | str | Vector | None]] = (
    normal_modulus_factor, shear_modulus_factor, mixed_shear_factor, mixed_normal_stiffness,
    mixed_tangential_stiffness, mixed_damping, mixed_dashpot, shear_along_x, thin_skin,
)  # fmt: skip
VALUES = {function.__name__: function for function in _FUNCTIONS}
