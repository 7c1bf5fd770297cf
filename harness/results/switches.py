"""Switches of the reference: values in a scene, unknowns that are fitted, passing conventions.

An entry of a known defect may give a number by name where it depends on the scene: another
coefficient of the scene's law, or a value of :data:`VALUES`. The step at which a spring changes its
sign, or a torque of memory that was never set, cannot be known beforehand: one number is taken from
the first sample that shows it, so that all others remain a test.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any, get_args

import numpy as np

from harness.errors import EngineNaNError, RequestError
from harness.model.base import Parameters, Vector
from harness.model.conventions import Faults, Rules
from harness.model.law import COEFFICIENTS, Law
from harness.model.scene import Motion, Scene

Reference = Callable[..., Motion | None]  # with the unknown by its name
Judge = Callable[[Motion], bool]  # whether a run passes against a motion of the reference
DETECTION_LIMIT = 1e-9  # [-] of the largest value: smaller differences show no unknown
WINDOWS = 3  # sample intervals with reversals that are fitted, one after the other


def switched_motion(
    scene: Scene,
    rules: Rules,
    switches: Mapping[str, Mapping[str, Any]],
    fitted: Mapping[str, Any] | None = None,
) -> Motion | None:
    """Return the motion of the reference with switches, None where it has none.

    ``switches`` are fields of ``faults``, ``rules`` and ``law``; ``fitted`` are more of ``faults``.
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


def passing_rules(scene: Scene, rules: Rules, holds: Judge) -> list[str]:
    """Return the single conventions, as ``wall_lever = height``, under which a run would pass."""
    passing = []
    for name, field in Rules.model_fields.items():
        words = (True, False) if field.annotation is bool else get_args(field.annotation)
        for word in words:
            if word == getattr(rules, name):
                continue
            motion = switched_motion(scene, rules, {"faults": {}, "rules": {name: word}, "law": {}})
            if motion is not None and holds(motion):
                passing.append(f"{name} = {word}")
    return passing


def check_switch(part: str, kind: type[Parameters], values: Mapping[str, Any]) -> None:
    """Raise ValueError for a field that a switch does not have, or a value that it cannot take."""
    plain = {}
    for name, value in values.items():
        if name not in kind.model_fields:
            raise ValueError(f"{part}.{name}: must be one of {', '.join(kind.model_fields)}")
        annotation = kind.model_fields[name].annotation
        words = [word for word in get_args(annotation) if isinstance(word, str)]
        words += [] if part == "rules" else sorted(VALUES)
        words += sorted(COEFFICIENTS) if name in COEFFICIENTS else []
        text = f"{part}.{name} = {value!r}: must be"
        if annotation is bool and not isinstance(value, bool):
            raise ValueError(f"{text} true or false")
        if isinstance(value, str) and value not in words:
            raise ValueError(f"{text} {' or '.join(words)}")
        if part == "law" and not isinstance(value, (str, int, float)):
            raise ValueError(f"{text} a number or {' or '.join(words)}")
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


# ---- unknowns


def holds_with_setup_torque(reference: Reference, _: Scene, observed: Motion, holds: Judge) -> bool:
    """Return whether a run passes with the setup torque [N m] that its first sample shows."""
    plain = reference()
    if plain is None:
        return False
    torque = tuple((observed.torque[0, 0] - plain.torque[0, 0]).tolist())
    if not all(map(math.isfinite, torque)):
        return False
    fitted = reference(setup_torque=torque)
    return fitted is not None and holds(fitted)


def holds_with_reversals(
    reference: Reference, scene: Scene, observed: Motion, holds: Judge
) -> bool:
    """Return whether a run passes with steps at which torsional springs change their sign.

    Each interval between two samples is fitted on the first sample after it that differs. Where
    that fails, and the motion is prescribed, each body may have a copy of the spring of its own.
    """
    steps: tuple[int, ...] = ()
    current = reference()
    for _ in range(WINDOWS):
        sample = 0 if current is None else first_difference(scene, observed, current)
        if current is None or sample >= len(observed):
            break
        agreed, current = sample, None
        for chosen in _reversals_before(sample, scene):
            trial = reference(torsion_reversed_at=(*steps, *chosen))
            if trial is None:
                continue
            if holds(trial):
                return True
            first = first_difference(scene, observed, trial)
            if first > agreed:
                agreed, current, best = first, trial, chosen
        steps = (*steps, *best) if current is not None else ()
    return bool(scene.segments) and _holds_with_copies(reference, scene, observed, holds)


def _reversals_before(sample: int, scene: Scene) -> Iterator[tuple[int, ...]]:
    """Yield steps before a sample: one, or two where a contact goes to a neighbour and back."""
    window = range(max(1, (sample - 1) * scene.every), sample * scene.every)
    yield from combinations(window, 1)
    yield from combinations(window, 2)


def _holds_with_copies(reference: Reference, scene: Scene, observed: Motion, holds: Judge) -> bool:
    """Return whether each sample of each body is that of one of the copies of a spring.

    Of a contact over a boundary both sides compute one, without newton, and each side turns its
    copy round at a step of its own; where both bodies are on one side again, one copy remains. The
    others are fitted on the first sample of a body that is not of the first one.
    """
    plain = reference()
    if plain is None:
        return False
    copies = [plain]
    for body in range(len(scene.bodies)):
        sample = first_difference(scene, observed, plain, body)
        if sample < len(observed):
            runs = (reference(torsion_reversed_at=s) for s in _reversals_before(sample, scene))
            solved = [run for run in runs if run is not None]
            copies.append(max(solved, key=lambda m: first_difference(scene, observed, m, body)))
    torques = np.stack([copy.torque for copy in copies])  # (copies, samples, bodies, 3)
    errors = np.abs(torques - observed.torque).max(axis=3)
    nearest = errors.argmin(axis=0)[None, :, :, None]
    torque = np.take_along_axis(torques, nearest, axis=0)[0]
    return holds(replace(plain, torque=torque))


FITS: Mapping[str, Callable[[Reference, Scene, Motion, Judge], bool]] = {
    "torsion_reversed_at": holds_with_reversals,
    "setup_torque": holds_with_setup_torque,
}


def first_difference(
    scene: Scene, observed: Motion, reference: Motion, body: int | None = None
) -> int:
    """Return the first sample that differs, of all bodies or one; their number where none does.

    Velocities of a free motion, forces of a prescribed one; angular parts on the scale of the
    largest radius.
    """
    radius = max(body.radius for body in scene.bodies)
    if scene.segments:
        parts = {"force": 1.0, "torque": 1.0 / radius}
    else:
        parts = {"velocity": 1.0, "angular_velocity": radius}
    size = max(k * float(np.abs(getattr(reference, name)).max()) for name, k in parts.items())
    first = len(observed)
    for name, k in parts.items():
        difference = k * np.abs(getattr(observed, name) - getattr(reference, name))
        difference = difference if body is None else difference[:, body]
        largest = np.nan_to_num(difference).reshape(len(difference), -1).max(axis=1)
        seen = np.flatnonzero(largest > DETECTION_LIMIT * (size or 1.0))
        first = min([first, *seen[:1].tolist()])
    return first
