"""Scenes in Kratos's DEM application: ``run_scenes.py``, which a Python with Kratos runs.

A linear contact is DEM_D_Linear_viscous_Coulomb, where k_t is at least 4/3 k_n
DEM_D_Linear_Custom_Constants, one of a material DEM_D_Hertz_viscous_Coulomb, with attraction
DEM_D_Hertz_viscous_Coulomb_DMT; a wall is a rigid face. Their formulas and conventions are those
of the public source of Kratos 10.4.4 (``spheric_particle.cpp``, ``DEM_D_*_CL.cpp``,
``GeometryFunctions.h``).
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from harness.engines.process import FAULTS as FATAL_SIGNALS
from harness.engines.process import Ended, last_words, signal_of
from harness.engines.scene_files import (
    Outcome,
    batches_of,
    check_scene,
    check_stated,
    check_words,
    contact_mass,
    damping_of,
    nearest_body,
    partners,
    room,
    script_with,
)
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineMissingError,
    EngineNaNError,
    Unsupported,
)
from harness.model.base import ZERO
from harness.model.conventions import Faults, Rules
from harness.model.law import damping_ratio
from harness.model.scene import Body, Scene, effective_radius

SCRIPT = Path(__file__).with_name("run_scenes.py")
LINEAR, CUSTOM = "DEM_D_Linear_viscous_Coulomb", "DEM_D_Linear_Custom_Constants"
TORQUE = "DEMRollingFrictionModelConstantTorque"
HERTZ, DMT = "DEM_D_Hertz_viscous_Coulomb", "DEM_D_Hertz_viscous_Coulomb_DMT"
SAME = 1e-9  # relative difference of places on a row
MOST_SHEAR = 4.0 / 3.0  # of k_n: 2 (1 - nu) / (2 - nu) of a material is less
BETWEEN_SPHERES, AT_WALLS = 1.432 * math.pi * 0.31225, math.pi * 0.31225  # k_n over E* R*, E* r
RULES = Rules(
    velocity_lever="contact_point",
    wall_lever="height",
    spring_frame="finite_rotation",
    slip_step="turned_arms",
    rescaled_from="displacement",
    looks_set_up=False,
)
CONSTANT_TORQUE = {"rolling_axis": "whole", "rolling_lever": "shortened"}
FAULTS = Faults(small_angle_quaternion=True)  # of 10.2 to 10.4


INSTALL = "pip install KratosDEMApplication (extra 'kratos'), or --program kratos=PYTHON"
FAREWELL = "Deregistering "  # how the lines begin that Kratos prints at its end, whatever it was


def rules(scene: Scene) -> Rules:
    """Return Kratos's conventions; raise Unsupported for a scene that it cannot run."""
    words(scene)
    return RULES.replace(**CONSTANT_TORQUE) if scene.law.rolling == "constant" else RULES


def motions(executable: str, scenes: Sequence[Scene], **options: Any) -> list[Outcome]:
    """Return the motion of each scene, or the error of its run, in order.

    ``options`` are those of :meth:`harness.engines.jobs.Batches.run`. ``executable`` is a
    Python with Kratos. Raise Unsupported for a scene that Kratos cannot run.
    """
    command = [executable, "-u", str(SCRIPT)]
    batches = batches_of("Kratos", command, words, lambda ended, _: error_of(ended))
    return batches.run(scenes, **options)


def error_of(ended: Ended) -> EngineError | None:
    """Return the error by the end of a process; Kratos's own messages are long, and start alike."""
    lines = (line for line in ended.output.splitlines() if not line.startswith(FAREWELL))
    ended = replace(ended, output="\n".join(lines))
    if ended.code and not ended.timed_out and signal_of(ended.code) not in FATAL_SIGNALS:
        if re.search(r"^(?:ModuleNotFound|Import)Error: ", ended.output, re.MULTILINE):
            missing = f"no Kratos{last_words(ended.output)}; to get it: {INSTALL}"
            return EngineMissingError(missing)
        if "is not a number" in ended.output:
            words = last_words(ended.output)
            return EngineNaNError(f"Kratos met a value that is not a number{words}")
        refusal = re.search(r"^RuntimeError: (?:Error: )?(.*)$", ended.output, re.MULTILINE)
        if refusal:
            return EngineInputError(f"Kratos refused its input: {refusal[1].strip()[:160]}")
    return ended.error("Kratos")


def script(scene: Scene) -> str:
    """Return a script of one scene, to be run by hand; or raise Unsupported.

    It is the same as runs many scenes, with the scene in it, and writes its samples to ``0.json``.
    """
    return script_with(SCRIPT, [(scene, words(scene))])


# ---- a law in Kratos's words


def words(scene: Scene) -> dict[str, Any]:
    """Return the law of a scene in Kratos's words.

    ``law`` is its class, ``values`` those of every contact; ``young`` [Pa] and ``poisson`` are of
    the spheres, ``wall_young`` [Pa] of each wall; ``gamma`` is a row for each sphere, with a
    number for each sphere and wall. Raise Unsupported for a law or scene that it does not have.
    """
    check_scene(scene)
    check_stated(scene)
    if scene.setups:
        raise Unsupported("sets no forces up again within a run")
    row = _row(scene)
    if row:  # four spheres stand for it
        scene = scene.replace(bodies=scene.bodies[:1] + scene.bodies[1:2] * 4)
    name, law = _name(scene), scene.law
    friction = law.friction or 0.0
    values = {"STATIC_FRICTION": friction, "DYNAMIC_FRICTION": friction}
    values |= dict.fromkeys(("FRICTION_DECAY", "COEFFICIENT_OF_RESTITUTION"), 0.0)
    values["ROLLING_FRICTION"] = _rolling_friction(scene)
    if name == DMT:  # of both surfaces: F = 2 pi PARTICLE_COHESION R*
        values["PARTICLE_COHESION"] = 2.0 * (law.surface_energy or 0.0)
    elif name == CUSTOM:
        values["K_NORMAL"] = law.normal_stiffness or 0.0
        values["K_TANGENTIAL"] = law.tangential_stiffness or 0.0
    young, poisson, wall_young = _material(scene, name)
    bodies = scene.bodies
    walls = [None] * len(scene.walls)
    return {
        "law": name,
        "values": values,
        "rolling": "" if law.rolling == "none" else TORQUE,
        "young": young,
        "poisson": poisson,
        "wall_young": wall_young,
        "gamma": [[_gamma(scene, b, other) for other in (*bodies, *walls)] for b in bodies],
        "room": room(scene) if row is None else 10.0 * row,
        "row": row,
    }


def _row(scene: Scene) -> float | None:
    """Return the distance [m] of the fixed spheres of an endless row along x, None without one."""
    length, (first, *others) = scene.period[0], scene.bodies
    if length is None:
        return None
    pitch = length / max(1, len(others))
    row = others[:1] * len(others)
    places = [
        (others[0].position[0] + k * pitch, *others[0].position[1:]) for k in range(len(others))
    ]
    equal = [body.replace(position=place) for body, place in zip(row, places, strict=True)]
    alike = all(
        math.dist(body.position, other.position) <= SAME * pitch
        and body.replace(position=ZERO) == other.replace(position=ZERO)
        for body, other in zip(equal, others, strict=True)
    )
    if first.motion != "free" or not others or others[0].motion == "free" or not alike:
        raise Unsupported("has periodic boundaries for one body on a row of equal fixed spheres")
    if scene.law.tangential != "none":
        raise Unsupported("has no friction on an endless row")
    return pitch


def _name(scene: Scene) -> str:
    law = scene.law
    if law.normal == "hooke":
        ratio = (law.tangential_stiffness or 0.0) / (law.normal_stiffness or 1.0)
        name = CUSTOM if ratio >= MOST_SHEAR else LINEAR
        check_words(law, name,
                    damping="none velocity mass_velocity damping_ratio coeff_restitution",
                    tangential="none linear_history", rolling="none constant",
                    twisting="none")  # fmt: skip
    elif law.normal == "hertz":
        name = HERTZ
        check_words(law, name, damping="none coeff_restitution",
                    tangential="none mindlin_rescale/force", rolling="none constant",
                    twisting="none")  # fmt: skip
    else:
        name = DMT
        check_words(law, name, normal="dmt", damping="none", tangential="none", rolling="none",
                    twisting="none")  # fmt: skip
    if law.normal_modulus is not None or law.tangential_modulus is not None:
        raise Unsupported(f"its {name} takes no modulus but of a material")
    if law.damping != "none" and not law.clipped:
        raise Unsupported("never attracts (clipped = True)")
    if law.damping != "none" and law.tangential != "none":
        raise Unsupported(
            "has a dashpot along the surface that is tied to the normal one, and limited twice"
        )
    return name


def _material(scene: Scene, name: str) -> tuple[float, float, list[float]]:
    """Return the modulus [Pa] and Poisson's ratio of the spheres, and the moduli of the walls [Pa].

    2 (1 - nu) / (2 - nu) is k_t / k_n of both laws of a material.
    """
    law, bodies, walls = scene.law, scene.bodies, scene.walls
    if name in (HERTZ, DMT):
        young = law.youngs_modulus or 0.0
        return young, law.poisson_ratio or 0.0, [young] * len(walls)
    normal, ratio = law.normal_stiffness or 0.0, 1.0
    if law.tangential != "none" and name == LINEAR:
        ratio = (law.tangential_stiffness or 0.0) / normal
    poisson = (2.0 - 2.0 * ratio) / (2.0 - ratio)
    modulus = (1.0 - poisson**2) * normal  # E* R* of a contact, but for its factor
    if len(bodies) > 2 and len({body.radius for body in bodies}) > 1 and name == LINEAR:
        raise Unsupported(f"its {LINEAR} has one k_n for contacts of equal R* only")
    young = 2.0 * modulus / AT_WALLS / bodies[0].radius
    if len(bodies) > 1:
        young = 2.0 * modulus / BETWEEN_SPHERES * (1.0 / bodies[0].radius + 1.0 / bodies[1].radius)
    both = [modulus / AT_WALLS / nearest_body(scene, wall).radius for wall in walls]
    return young, poisson, [1.0 / (1.0 / pair - 1.0 / young) for pair in both]


def _rolling_friction(scene: Scene) -> float:
    """Return Kratos's coefficient of rolling, whose arm is the radius of each sphere, not R*."""
    if scene.law.rolling == "none":
        return 0.0
    pairs = partners(scene)
    shares = {effective_radius(first, second) / first.radius for first, second in pairs}
    if len(shares) > 1 or any(second and second.radius != first.radius for first, second in pairs):
        raise Unsupported("has opposite torques of rolling for spheres of one size, or at walls")
    return (scene.law.rolling_friction or 0.0) * min(shares)


def _gamma(scene: Scene, first: Body, second: Body | None) -> float:
    """Return Kratos's gamma of a contact: its dashpot is 2 gamma sqrt(m k).

    m has the own mass of a fixed sphere. Hertz's k is the tangent, 3/2 of force over overlap.
    """
    law, mass = scene.law, contact_mass(scene, first, second)
    if law.damping == "none":
        return 0.0
    masses = [body.mass for body in (first, second) if body]
    reduced = math.prod(masses) / (sum(masses) if second else 1.0)
    if law.normal == "hertz":
        return math.sqrt(5.0 / 6.0 * mass / reduced) * damping_ratio(law.restitution or 1.0)
    return damping_of(law, mass) / 2.0 / math.sqrt(reduced * (law.normal_stiffness or 1.0))
