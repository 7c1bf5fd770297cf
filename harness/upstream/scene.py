"""A LAMMPS run read as a contact scene: its law from the commands, its bodies from a dump.

LAMMPS says what it was given: with ``-echo log`` each command stands in the log as typed, then
with its variables filled in, and a dump has place, motion, radius and mass of each body. So any
script of a few spheres and flat walls can be read, whatever its variables and conditions. What
the contact law here does not describe is refused, with the command.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.scene import Body, ContactScene, Plane, Segment, Vector

MOVERS = ("nve/sphere", "nve/noforce")
"""Fixes that move spheres: by their forces, or on as they are."""

READ_STYLES = frozenset((*MOVERS, "gravity", "wall/gran", "print", "ave/time"))
"""Fixes that a scene describes, or that act on nothing."""

CHANGES = frozenset(("read_restart", "clear", "unfix", "delete_atoms", "displace_atoms"))
"""Commands after which it is another system."""
AXES: Mapping[str, Vector] = {
    "xplane": (1.0, 0.0, 0.0),
    "yplane": (0.0, 1.0, 0.0),
    "zplane": (0.0, 0.0, 1.0),
}

Words = Sequence[str]
Floats = NDArray[np.float64]


class NotReadError(RequestError):
    """A run that is no scene of a few spheres and flat walls under one law."""


def scene_of(log: str, state: Mapping[str, Floats], steps: int, timestep: float) -> ContactScene:
    """Return the scene of a run: log with echoed commands, and its dump before the first step.

    Raise NotReadError for a command, or a contact law, that a scene does not describe.
    """
    styles, pair, coefficients = _commands(log)
    if not steps:
        raise NotReadError("it takes no step, and moves nothing")
    bodies = _bodies(state)
    if not bodies:
        raise NotReadError("it has no sphere at the start")
    planes, laws = [], []
    gravity: Vector = (0.0, 0.0, 0.0)
    for group, style, *rest in styles.values():
        if style not in READ_STYLES:
            raise NotReadError(f"fix {style}: acts on the spheres, and is no part of a scene")
        if style in MOVERS and group != "all":
            raise NotReadError(f"fix {style} of group {group}: moves some of the spheres alone")
        if style == "gravity":
            gravity = _gravity(rest)
        if style == "wall/gran":
            law, walls = _walls(rest)
            laws.append(law)
            planes += walls
    if len(bodies) > 1:
        laws.append(_pair_law(pair, coefficients, state["type"]))
    if not laws:
        raise NotReadError("it has neither a wall nor a second sphere")
    if any(law != laws[0] for law in laws):
        raise NotReadError("its contacts have several laws")
    held = (
        ()
        if any(style == "nve/sphere" for _, style, *_ in styles.values())
        else (Segment(steps, tuple(b.velocity for b in bodies), tuple(b.omega for b in bodies)),)
    )
    return ContactScene(bodies, tuple(planes), laws[0], timestep, steps, steps, gravity, held)


def _commands(log: str) -> tuple[dict[str, Words], Words, dict[tuple[str, ...], Words]]:
    """Return the fixes by name, the pair style, and coefficients by pair of types.

    Each stands in the log as typed, then with its variables filled in: the last one counts.
    """
    styles: dict[str, Words] = {}
    coefficients: dict[tuple[str, ...], Words] = {}
    pair: Words = ()
    for line in log.splitlines():
        words = line.split("#")[0].split()
        command = words[0] if words else ""
        if command == "fix" and len(words) > 3:
            styles[words[1]] = words[2:]
        elif command == "pair_style":
            pair = words[1:]
        elif command == "pair_coeff":
            coefficients[tuple(words[1:3])] = words[3:]
        elif command in CHANGES:
            raise NotReadError(f"{command}: the system changes as it runs")
    return styles, pair, coefficients


def _bodies(state: Mapping[str, Floats]) -> tuple[Body, ...]:
    def vectors(*names: str) -> list[Vector]:
        columns = (state[name].tolist() for name in names)
        return [(x, y, z) for x, y, z in zip(*columns, strict=True)]

    places, speeds = vectors("x", "y", "z"), vectors("vx", "vy", "vz")
    spins = vectors("omegax", "omegay", "omegaz")
    masses = zip(state["radius"], state["mass"], strict=True)
    return tuple(
        Body(float(radius), float(mass), place, speed, spin)
        for (radius, mass), place, speed, spin in zip(masses, places, speeds, spins, strict=True)
    )


def _gravity(words: Words) -> Vector:
    size, kind, *rest = words
    if kind != "vector" or len(rest) != 3:
        raise NotReadError(f"fix gravity {kind}: must be a vector to be read")
    direction = np.array([float(word) for word in rest])
    x, y, z = float(size) * direction / np.linalg.norm(direction)
    return float(x), float(y), float(z)


def _walls(words: Words) -> tuple[ContactLaw, list[Plane]]:
    place = next((i for i, word in enumerate(words) if word in AXES), None)
    if place is None or len(words) != place + 3:
        raise NotReadError(
            f"fix wall/gran {' '.join(words[-4:])}: must be a flat wall at rest to be read"
        )
    style, *numbers = words[:place]
    law = granular_law(numbers) if style == "granular" else old_law(style, numbers)
    axis = AXES[words[place]]
    planes = []
    for word, sign in zip(words[place + 1 :], (1.0, -1.0), strict=True):
        if word != "NULL":
            point = tuple(float(word) * a for a in axis)
            planes.append(Plane(point, tuple(sign * a for a in axis)))  # type: ignore[arg-type]
    return law, planes


def _pair_law(
    style: Words, coefficients: Mapping[tuple[str, ...], Words], types: Floats
) -> ContactLaw:
    """Return the law between two spheres; of two materials as that of both."""
    if style[0] != "granular":
        return old_law(style[0].removeprefix("gran/"), style[1:])
    first, second = (str(int(kind)) for kind in (types[0], types[-1]))
    for pair in ((first, second), (second, first), ("*", "*")):
        if pair in coefficients:
            return granular_law(coefficients[pair])
    if not {(first, first), (second, second)} <= set(coefficients):
        raise NotReadError(
            "pair_coeff: must be that of all types, or those of both spheres, to be read"
        )
    laws = [granular_law(coefficients[kind, kind]) for kind in (first, second)]
    settings, partner_settings = ({**dict(law), **dict.fromkeys(MATERIAL)} for law in laws)
    if settings != partner_settings or laws[0].youngs_modulus is None:
        raise NotReadError("pair_coeff: types that differ by more than their material are not read")
    modulus, poisson = laws[1].youngs_modulus, laws[1].poisson_ratio
    return laws[0].replace(partner_youngs_modulus=modulus, partner_poisson_ratio=poisson)


MATERIAL = ("youngs_modulus", "poisson_ratio")

NORMAL = {"hooke": 2, "hertz": 2, "hertz/material": 3, "dmt": 4, "jkr": 4}
"""Numbers of coefficients of a normal model."""

TANGENTIAL = {
    "linear_nohistory": 2,
    **dict.fromkeys(
        (
            "linear_history",
            "linear_history_classic",
            "mindlin",
            "mindlin/force",
            "mindlin_rescale",
            "mindlin_rescale/force",
            "mindlin_classic",
        ),
        3,
    ),
}
SDS = 3


def granular_law(words: Words) -> ContactLaw:
    """Return the law of the words of ``pair_style granular``; raise NotReadError for another.

    ``hertz`` with k_n and ``mindlin`` with k_t are stated by the material that has them.
    """
    rest = list(words)
    normal = rest.pop(0)
    if normal not in NORMAL:
        raise NotReadError(f"normal model {normal}: must be one of {', '.join(NORMAL)}")
    numbers = [rest.pop(0) for _ in range(NORMAL[normal])]
    damping, tangential = "viscoelastic", ["linear_nohistory", "1.0", "0.0"]
    parts: dict[str, list[str]] = {"rolling": ["none"], "twisting": ["none"]}
    clipped = False
    while rest:
        word = rest.pop(0)
        if word == "damping":
            damping = rest.pop(0)
        elif word == "tangential":
            model = rest.pop(0)
            if model not in TANGENTIAL:
                raise NotReadError(f"tangential model {model}: is not known")
            tangential = [model, *(rest.pop(0) for _ in range(TANGENTIAL[model]))]
        elif word in parts:
            model = rest.pop(0)
            count = SDS if model == "sds" else 0
            parts[word] = [model, *(rest.pop(0) for _ in range(count))]
        elif word == "limit_damping":
            clipped = True
        else:
            raise NotReadError(f"{word}: is no part of a contact law here")
    values = _normal(normal, numbers, tangential)
    values |= _damping(damping, float(numbers[1]))
    values |= _tangential(tangential)
    for name, (model, *coefficients) in parts.items():
        values[name] = model
        names = (f"{name}_stiffness", f"{name}_damping", f"{name}_friction")
        values |= dict(zip(names, map(float, coefficients), strict=False))
    return _law(**values, clipped=clipped)


def old_law(style: str, words: Words) -> ContactLaw:
    """Return the law of ``hooke``, ``hooke/history`` or ``hertz/history`` and its numbers."""
    if style not in ("hooke", "hooke/history", "hertz/history") or len(words) < 6:
        raise NotReadError(f"{style}: its law is not known")
    normal, tangential, damping, sideways, friction, acts = words[:6]
    stiffness, eta = float(normal), float(damping)
    along = 0.0 if acts == "0" else 0.5 * eta if sideways == "NULL" else float(sideways)
    share = along / eta if eta else 0.0
    values: dict[str, float | str | bool] = {"clipped": "limit_damping" in words}
    if style == "hertz/history":
        k_t = stiffness * 2.0 / 7.0 if tangential == "NULL" else float(tangential)
        values |= {**_material(stiffness, k_t), "damping": "viscoelastic"}
        values |= {"tangential": "mindlin"}
    else:
        values |= {"normal": "hooke", "normal_stiffness": stiffness, "damping": "mass_velocity"}
        if style == "hooke/history":
            k_t = stiffness * 2.0 / 7.0 if tangential == "NULL" else float(tangential)
            values |= {"tangential": "linear_history", "tangential_stiffness": k_t}
        else:
            values |= {"tangential": "linear_nohistory"}
    values |= {"damping_coefficient": eta, "tangential_damping": share, "friction": float(friction)}
    if not eta:
        values["damping"] = "none"
        del values["damping_coefficient"]
    if not float(friction) or (values["tangential"] == "linear_nohistory" and not along):
        values = {n: v for n, v in values.items() if not n.startswith(("tangential", "friction"))}
    return _law(**values)


def _normal(model: str, numbers: Words, tangential: Words) -> dict[str, float | str]:
    if model == "hooke":
        return {"normal": "hooke", "normal_stiffness": float(numbers[0])}
    if model == "hertz":
        k_n = float(numbers[0])
        mindlin = tangential[0].startswith("mindlin") and tangential[1] != "NULL"
        # without friction along the surface Poisson's ratio has no effect: that of k_t/k_n = 3/2, 0
        return _material(k_n, float(tangential[1]) if mindlin else 1.5 * k_n)
    values: dict[str, float | str] = {
        "normal": "hertz" if model == "hertz/material" else model,
        "youngs_modulus": float(numbers[0]),
        "poisson_ratio": float(numbers[2]),
    }
    if model in ("dmt", "jkr"):
        values["surface_energy"] = float(numbers[3])
    if tangential[0].startswith("mindlin") and tangential[1] != "NULL":
        k_t = 2.0 * float(numbers[0]) / ((2.0 - float(numbers[2])) * (1.0 + float(numbers[2])))
        if not math.isclose(k_t, float(tangential[1]), rel_tol=1e-9):
            raise NotReadError(
                f"tangential {tangential[0]} {tangential[1]}: is not 8 G* of the material"
            )
    return values


def _material(k_n: float, k_t: float) -> dict[str, float | str]:
    """Return the material with 4/3 E* = k_n and 8 G* = k_t, both [Pa]."""
    ratio = k_t / k_n  # 3 (1 - nu) / (2 - nu)
    poisson = (3.0 - 2.0 * ratio) / (3.0 - ratio)
    if not -1.0 < poisson <= 0.5:
        raise NotReadError(f"k_t/k_n = {ratio:g}: no material has it (must be from 1 to 2)")
    modulus = 1.5 * k_n * (1.0 - poisson**2)
    return {"normal": "hertz", "youngs_modulus": modulus, "poisson_ratio": poisson}


def _damping(model: str, coefficient: float) -> dict[str, float | str]:
    if model in ("tsuji", "coeff_restitution"):
        if model == "coeff_restitution" and coefficient == 1.0:
            return {"damping": "none"}
        return {"damping": model, "restitution": coefficient}
    if model not in ("velocity", "mass_velocity", "viscoelastic"):
        raise NotReadError(f"damping {model}: is not known")
    if not coefficient:
        return {"damping": "none"}
    return {"damping": model, "damping_coefficient": coefficient}


def _tangential(words: Words) -> dict[str, float | str]:
    model, *numbers = words
    damping, friction = map(float, numbers[-2:])
    if not friction or (model == "linear_nohistory" and not damping):
        return {"tangential": "none"}
    values: dict[str, float | str] = {
        "tangential": model,
        "tangential_damping": damping,
        "friction": friction,
    }
    if model.startswith("linear_history"):
        values["tangential_stiffness"] = float(numbers[0])
    return values


def _law(**values: float | str | bool) -> ContactLaw:
    try:
        return ContactLaw(**values)
    except RequestError as error:
        raise NotReadError(f"its law is not one that is integrated here: {error}") from None
