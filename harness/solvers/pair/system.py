"""A scene as records of bodies, planes, contacts and law, for compiled code."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from harness.errors import RequestError
from harness.parameters.law import ContactLaw
from harness.parameters.rules import Rules
from harness.parameters.scene import ContactScene
from harness.solvers.pair import friction as slider
from harness.solvers.pair import geometry, normal
from harness.solvers.pair.normal import ELASTIC, fold, swelling_depth, yield_depth
from harness.solvers.pair.records import (
    BODIES,
    CONTACTS,
    LAW,
    OF_FRICTION,
    OF_MDR,
    PLANES,
    TWIST_MARSHALL,
    TWIST_NONE,
    TWIST_SDS,
    Integers,
    Records,
    System,
)


def system_of(scene: ContactScene, rules: Rules) -> System:
    """Return the arrays of a scene; raise RequestError for a plane that moves."""
    if any(any(plane.velocity) for plane in scene.planes):
        raise RequestError("planes: the reference integration takes those at rest")
    if scene.period is not None:
        raise RequestError(f"period = {scene.period} m: the reference integration has none")
    bodies, moved = scene.bodies, not scene.segments
    free = [float(moved and not body.frozen) for body in bodies]
    gravity = np.array((*scene.gravity, 0.0)[:3], dtype=float)
    pairs = [
        (i, j)
        for i in range(len(bodies))
        for j in range(i + 1, len(bodies))
        if not (bodies[i].frozen and bodies[j].frozen and moved)
    ]
    walls = [
        (i, -1 - p)
        for i, body in enumerate(bodies)
        for p in range(len(scene.planes))
        if not (body.frozen and moved)
    ]
    law = law_of(scene.law, rules)
    if (law["yields"] or law["bulk"]) and len(pairs + walls) > 1:
        raise RequestError(
            f"bodies: normal = mdr with yield or a bulk response takes one contact, not "
            f"{len(pairs + walls)}: its radius and its surface are those of all contacts of a body"
        )
    return System(
        bodies=_records(
            BODIES,
            (
                (body.radius, moves / body.mass, moves / body.inertia, moves * gravity)
                for body, moves in zip(bodies, free, strict=True)
            ),
        ),
        planes=_records(PLANES, ((plane.point, plane.direction) for plane in scene.planes)),
        contacts=_records(
            CONTACTS,
            (
                (
                    *(i, j, _curvature(scene, i, j), _mass(scene, rules, i, j), 1.0, 1.0),
                    *_depths(law, bodies[i].radius, 2.0 if j >= 0 else 1.0),
                    *(bodies[i].radius, bodies[j if j >= 0 else i].radius),
                    rules.pair_factor if j >= 0 else 1.0,
                )
                for i, j in pairs + walls
            ),
        ),
        law=law,
    )


def _depths(
    law: Records, radius: float, flats: float
) -> tuple[float, float, int, float, float, float]:
    """Return the six fields of a contact of mdr on its flat, from ``onset`` on; 0 for any other."""
    if law["normal"] != normal.MDR:
        return 0.0, 0.0, ELASTIC, 0.0, 0.0, 0.0
    modulus, onset, swells = 2.0 * float(law["stiffness"]), 0.0, 0.0
    if law["yields"]:
        onset = yield_depth(modulus, float(law["yield_stress"]), radius)
        swells = swelling_depth(law, onset, radius)
    least, last = fold(modulus, float(law["surface"]), radius)
    return onset, swells, ELASTIC, 0.0, flats * last, least


def _records(kind: np.dtype[Any], rows: Iterable[tuple[Any, ...]]) -> Records:
    return np.array([*rows], dtype=kind)


def law_of(law: ContactLaw, rules: Rules) -> Records:
    """Return the law and its rules as numbers."""
    modulus, shear = effective_moduli(law)
    modulus, shear = modulus * rules.modulus_factor, shear * rules.shear_factor
    kinds = {
        "hooke": normal.HOOKE,
        "hertz": normal.HERTZ,
        "dmt": normal.DMT,
        "jkr": normal.JKR,
        "mdr": normal.MDR,
    }
    sticky = (law.surface_energy or 0.0) > 0.0
    mindlin = "mindlin" in law.tangential
    factor = 2.0 / 3.0 if rules.mindlin_factor == "2/3" else 1.0
    turning = bool(law.rolling_friction) or _twisting(law) != TWIST_NONE
    values = {
        "normal": kinds[law.normal] if sticky or law.normal in ("hooke", "mdr") else normal.HERTZ,
        "stiffness": law.normal_stiffness or modulus,
        "surface": law.surface_energy or 0.0,
        "fold": rules.pull_off == "fold",
        "wall_magnified": law.normal == "mdr" and rules.wall_force == "magnified",
        **_branches(law),
        "damping": normal.KINDS[law.damping],
        "damping_coefficient": normal.coefficient(law, rules),
        "clipped": law.clipped,
        "tangential": bool(law.friction),
        "tangential_stiffness": 8.0 * shear * factor
        if mindlin
        else law.tangential_stiffness or 0.0,
        "by_radius": mindlin,
        "hertzian": law.normal == "mdr"
        and rules.mdr_friction == "hertz"
        and (mindlin or law.twisting == "marshall"),
        "by_force": law.tangential.endswith("/force"),
        "rescaled": "rescale" in law.tangential,
        "tangential_damping": law.tangential_damping or 0.0,
        "friction": law.friction or 0.0,
        "pull_loads": rules.cohesive_load == "with_pull_off",
        "rolling": bool(law.rolling_friction),
        "rolling_coefficients": _three(
            law.rolling_stiffness, law.rolling_damping, law.rolling_friction
        ),
        "twisting": _twisting(law),
        "twisting_coefficients": _three(
            law.twisting_stiffness, law.twisting_damping, law.twisting_friction
        ),
        "marshall_by_radius": mindlin and rules.marshall_stiffness == "spring",
        "cut_back": rules.cap == "cut_back",
        "damping_in_cap": slider.IN_CAP[rules.damping_in_cap],
        "torque_lever": geometry.KINDS[rules.torque_lever],
        "velocity_lever": geometry.KINDS[rules.velocity_lever],
        "wall_lever": geometry.KINDS[rules.wall_lever],
        "levered": rules.wall_turning == "levered" and turning,
        "mean_spin": rules.spring_spin == "mean",
        "turns": rules.spring_frame == "contact",
    }
    if not (values["tangential"] or values["rolling"] or values["twisting"]):
        values |= dict.fromkeys(OF_FRICTION, 0)
    return _records(LAW, [tuple(values[name] for name in LAW.names or ())])[0]


def _branches(law: ContactLaw) -> dict[str, float | bool]:
    """Return what mdr needs of a material beyond E*: K and G [Pa], nu, and the yield stress."""
    if not law.lags:
        return dict.fromkeys(OF_MDR, 0.0)
    young, poisson = law.youngs_modulus or 0.0, law.poisson_ratio or 0.0
    return {
        # from the first touch on the bulk takes what is displaced: no pressure is left that yields
        "yields": law.yield_stress is not None and not law.bulk_response,
        "yield_stress": law.yield_stress or 0.0,
        "bulk": law.bulk_response,
        "bulk_modulus": young / (3.0 * (1.0 - 2.0 * poisson)),
        "shear_modulus": young / (2.0 * (1.0 + poisson)),
        "poisson": poisson,
    }


def effective_moduli(law: ContactLaw) -> tuple[float, float]:
    """Return E* and G* [Pa] of a contact: compliances of both bodies add up. 0 without a material.

    1/E* is the sum of (1 - nu^2) / E and 1/G* that of (2 - nu) / G, with G = E / (2 (1 + nu)):
    Johnson (1985), equations 4.3 and 7.43; twice that of one where both are equal.
    """
    if law.materials is None:
        return 0.0, 0.0
    if not law.two_materials:
        young, poisson = law.materials[0]
        shear = young / (2.0 * (1.0 + poisson))
        return young / (2.0 * (1.0 - poisson**2)), shear / (2.0 * (2.0 - poisson))
    normal = sum((1.0 - nu**2) / young for young, nu in law.materials)
    along = sum((2.0 - nu) * 2.0 * (1.0 + nu) / young for young, nu in law.materials)
    return 1.0 / normal, 1.0 / along


def first_modes(system: System) -> Integers:
    """Return the modes of contacts that are open: closed, sign, three sliders, unloading."""
    return np.tile(
        np.array([0, 1, slider.OFF, slider.OFF, slider.OFF, 0]), (len(system.contacts), 1)
    )


def _curvature(scene: ContactScene, i: int, j: int) -> float:
    radius = scene.bodies[i].radius
    return radius if j < 0 else radius * scene.bodies[j].radius / (radius + scene.bodies[j].radius)


def _mass(scene: ContactScene, rules: Rules, i: int, j: int) -> float:
    """Return m*: 1/m* is the sum over both, 0 for a wall and, as a rule, a frozen body."""
    both = [scene.bodies[k] for k in (i, j) if k >= 0]
    moving = [b for b in both if not b.frozen or rules.frozen_mass == "own" or scene.segments]
    return 1.0 / sum(1.0 / body.mass for body in moving)


def _twisting(law: ContactLaw) -> int:
    if law.twisting == "marshall":
        return TWIST_MARSHALL if law.friction else TWIST_NONE
    return TWIST_SDS if law.twisting_friction else TWIST_NONE


def _three(*values: float | None) -> tuple[float, float, float]:
    stiffness, dashpot, friction = (value or 0.0 for value in values)
    return stiffness, dashpot, friction
