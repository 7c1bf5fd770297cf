"""Yade as an engine of the harness: generated scripts that it runs in its own Python.

A script takes its runs as a list in a JSON file, and writes the results of each; scenes are run by
``run_scenes.py``. A linear contact is Law2_ScGeom_ViscElPhys_Basic, with resistance to rolling or
twisting Law2_ScGeom6D_CohFrictPhys_CohesionMoment without cohesion, one of a material
Law2_ScGeom_MindlinPhys_Mindlin. Their formulas and conventions are those of the public source of
Yade 2023.02a (``ViscoelasticPM.cpp``, ``CohesiveFrictionalContactLaw.cpp``, ``HertzMindlin.cpp``,
``ScGeom.cpp``).
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from harness.engines.base import Traits
from harness.engines.output import Provenance
from harness.engines.process import first_text, first_words
from harness.engines.registry import OF_PYTHON, program_files, tree_files, with_libraries
from harness.engines.scenes import (
    SceneFileEngine,
    check_scene,
    check_words,
    contact_mass,
    damping_of,
    kind,
    nearest_body,
    partners,
    refuse_any,
)
from harness.errors import EngineMissingError, Unsupported
from harness.model.conventions import Rules
from harness.model.law import damping_ratio
from harness.model.scene import Scene, effective_radius

WALL_RADIUS = 1e8  # [radius of a sphere] of a wall in Hertz's law; Yade's walls have a radius
ELASTIC, TURNING, SOLID = "ViscElPhys", "CohFrictPhys", "MindlinPhys"
# of Yade, which must have a Python of its own and would take itself for a rank of our launcher
FOREIGN = ("PYTHON", "OMPI_", "PMI_", "PMIX_", "DISPLAY", "XDG_CONFIG_HOME")
_COMMON = Rules(
    velocity_lever="contact_point",
    looks_set_up=False,
    spring_frame="rotated",
    torsion_frame="rotated",
    wall_touches_at_zero=True,
    bodies_touch_at_zero=True,
)
RULES = {
    ELASTIC: _COMMON.replace(damping_in_cap="sticking_only", wall_lever="height"),
    TURNING: _COMMON.replace(wall_lever="contact_point"),  # a box touches at half the overlap
}
RULES[SOLID] = RULES[ELASTIC].replace(wall_curvature=1.0 / WALL_RADIUS)
TWO_MATERIALS = {"restitution_mean": "arithmetic", "friction_mean": "least"}
CONSTANT_TORQUE = {"rolling_axis": "whole"}


class Yade(SceneFileEngine):
    """Yade as packaged: a process runs its share of the jobs of a script, one after the other."""

    name = "yade"
    traits = Traits(
        install_hint="apt install yade (Debian, Ubuntu), or --program yade=PATH",
        versions=("2023.02a",),
        integrator="velocity-verlet",
        microseconds_per_step=5.0,
        title="Yade",
    )
    programs = ("yade",)
    command_name = "yade -n -x"
    options = ("-n", "-x")  # without a window, and to end after a script
    deciding_variables = (*OF_PYTHON, "YADE_PREFIX")

    def installed_files(self) -> list[Path]:
        """Return the program, a script of Python, the libraries that it names, and theirs."""
        program = Path(self.program)
        text = first_text(program, 10_000)
        named = re.search(r"^sys\.path\.insert\(1, *'(/[^']+)/py'\)", text, re.MULTILINE)
        python = re.match(r"#!(/\S+)$", text, re.MULTILINE)
        if not (named and python and (library := Path(named[1], "libyade.so")).exists()):
            return []
        loaded, interpreter = with_libraries(library), program_files(Path(python[1]))
        if not loaded or not interpreter:
            return []
        return [program, *interpreter, *tree_files(library.parent), *loaded]

    def ask_version(self) -> Provenance:
        """Return the version that the program names."""
        output, _ = self.ask([self.program, "--version"])
        named = re.search(r"^Yade version: (\S+)", output, re.MULTILINE)
        if named is None:
            raise EngineMissingError(
                f"{self.program} is not Yade: it names no version{first_words(output)}"
            )
        return Provenance(self.name, named[1], (), self.program, "executable")

    def environment(self, folder: Path) -> Mapping[str, str]:
        """Return an environment of Yade's own Python, which writes to the folder only.

        Yade does not start without a HOME, and makes folders in it.
        """
        kept = {name: text for name, text in os.environ.items() if not name.startswith(FOREIGN)}
        return {**kept, "HOME": str(folder)}

    @staticmethod
    def rules(scene: Scene) -> Rules:
        """Return Yade's conventions; raise Unsupported for a scene that it cannot run."""
        law, changes = scene.law, dict[str, str]()
        if law.two_materials:
            changes |= TWO_MATERIALS
        if law.rolling == "constant":
            changes |= CONSTANT_TORQUE
        return RULES[words(scene)["law"]].replace(**changes)

    def scene_words(self, scene: Scene) -> Mapping[str, Any]:
        """Return the law of a scene in Yade's words."""
        return words(scene)


# ---- a law in Yade's words


def words(scene: Scene) -> dict[str, Any]:
    """Return the law of a scene in Yade's words: its name, materials and options of functors.

    ``materials`` are those of the bodies, then of the walls. Raise Unsupported for a law or scene
    that Yade does not have.
    """
    check_scene(scene)
    law = scene.law
    if scene.setups:
        raise Unsupported("sets no forces up again within a run")
    if law.damping != "none" and not law.clipped:
        raise Unsupported("never attracts (clipped = True)")
    if law.normal != "hooke":
        return _solid(scene)
    turns = law.rolling == "sds" or law.twisting != "none"
    return _turning(scene) if turns else _elastic(scene)


def _elastic(scene: Scene) -> dict[str, Any]:
    law = scene.law
    check_words(law, "Law2_ScGeom_ViscElPhys_Basic",
                damping="none velocity mass_velocity damping_ratio coeff_restitution",
                tangential="none linear_history")  # fmt: skip
    if law.partner_restitution is not None:
        return {"law": ELASTIC, "materials": _restitutions(scene), "physics": {}, "options": {}}
    resists = {} if law.rolling == "none" else {"mR": _rolling_arm(scene), "mRtype": 1}
    materials = [
        {
            "kn": 2.0 * (law.normal_stiffness or 0.0),
            "cn": eta,
            "ks": 2.0 * (law.tangential_stiffness or 0.0),
            "cs": eta * (law.tangential_damping or 0.0),
            "frictionAngle": angle,
            **resists,
        }
        for eta, angle in zip(_dashpots(scene), _friction_angles(scene), strict=True)
    ]
    return {"law": ELASTIC, "materials": materials, "physics": {}, "options": {}}


def _restitutions(scene: Scene) -> list[dict[str, float]]:
    """Return materials by restitution and contact time, of which Yade takes the mean of both.

    k = m* (pi^2 + ln^2 e) / tc^2, with the own mass of a frozen sphere too.
    """
    law, (first, *others) = scene.law, scene.bodies
    two = not scene.walls and [body.motion for body in scene.bodies] == ["free", "free"]
    if law.tangential != "none" or not two:
        name = "Ip2_ViscElMat_ViscElMat_ViscElPhys"
        raise Unsupported(f"its {name} mixes restitutions of two free spheres without friction")
    both = [side.restitution or 1.0 for side in law.of_each]
    mass = contact_mass(scene, first, others[0])
    stiffness = law.normal_stiffness or 1.0
    time = math.hypot(math.pi, math.log(sum(both) / 2.0)) * math.sqrt(mass / stiffness)
    return [{"tc": time, "en": e, "et": 1.0, "frictionAngle": 0.0} for e in both]


def _rolling_arm(scene: Scene) -> float:
    """Return mu_r R* [m] of all contacts: Zhou and others, Physica A 269, 536 (1999)."""
    radii = {effective_radius(*pair) for pair in partners(scene)}
    if len(radii) > 1:
        raise Unsupported("has a constant torque of rolling for contacts of one R*")
    return (scene.law.rolling_friction or 0.0) * min(radii)


def _friction_angles(scene: Scene) -> list[float]:
    """Return the angles of friction [rad] of bodies and walls, the smaller of which acts."""
    first, second = scene.law.of_each
    count = len(scene.bodies) + len(scene.walls)
    if scene.law.partner_friction is not None and count > 2:
        raise Unsupported("gets a friction of each body here, of two alone")
    return [math.atan(law.friction or 0.0) for law in (first, *[second] * (count - 1))]


def _dashpots(scene: Scene) -> list[float]:
    """Return the dashpots [kg/s] of bodies and walls, which Yade puts in series in a contact.

    It leaves out one of 0, as if that side were rigid.
    """
    law, bodies, walls = scene.law, scene.bodies, scene.walls
    if law.damping == "none":
        return [0.0] * (len(bodies) + len(walls))
    frozen = [body.motion == "frozen" and not scene.segments for body in bodies]
    if law.damping == "mass_velocity":
        factor = law.damping_coefficient or 0.0
        etas = [0.0 if f else factor * b.mass for f, b in zip(frozen, bodies, strict=True)]
        return etas + [0.0] * len(walls)
    needed = [damping_of(law, nearest_body(scene, wall).mass) for wall in walls]
    pairs = {
        frozenset((kind(first), kind(second))): damping_of(law, contact_mass(scene, first, second))
        for first, second in partners(scene)
        if second is not None
    }
    if len({*pairs.values()}) < 2:
        base = 2.0 * next(iter(pairs.values()), damping_of(law, bodies[0].mass))
        return [base] * len(bodies) + [_in_series(eta, base) for eta in needed]
    moving = {kind(body) for body in bodies if scene.segments or body.motion == "free"}
    if len(moving) > 1:
        raise Unsupported("its Law2_ScGeom_ViscElPhys_Basic has this dashpot for equal bodies")
    base = 2.0 * pairs.get(frozenset(moving), max(pairs.values()))
    fixed = {kind(body) for body in bodies} - moving
    of_kind = {k: _in_series(pairs[frozenset(moving | {k})], base) for k in fixed}
    etas = [of_kind.get(kind(body), base) for body in bodies]
    return etas + [_in_series(eta, base) for eta in needed]


def _in_series(eta: float, other: float) -> float:
    """Return the dashpot that gives ``eta`` [kg/s] in series with another, 0 for a rigid one."""
    return 0.0 if eta == other else 1.0 / (1.0 / eta - 1.0 / other)


def _turning(scene: Scene) -> dict[str, Any]:
    """Return springs also of rolling and twisting.

    Yade takes the harmonic mean of k_n, k_t / k_n and alpha of both materials; k_n is young times
    the radius, the stiffness of rolling or twisting alpha k_t r_1 r_2; the torques are at most
    the smaller eta times radius, times the normal force.
    """
    law, first, last = scene.law, scene.bodies[0], scene.bodies[-1]
    name = "Law2_ScGeom6D_CohFrictPhys_CohesionMoment"
    check_words(law, name, damping="none", tangential="none linear_history", rolling="none sds",
                twisting="none sds")  # fmt: skip
    count, radii = len(scene.bodies), {body.radius for body in scene.bodies}
    several = (scene.walls and count > 1) or (count > 2 and len(radii) > 1)
    refuse_any(
        (law.rolling_damping, "has rolling springs without a dashpot only"),
        (law.twisting_damping, "has twisting springs without a dashpot only"),
        (several, f"its {name} has one R*: of a sphere on walls, or of equal spheres"),
    )
    reduced = effective_radius(first, last if count > 1 else None)
    normal = law.normal_stiffness or 0.0
    shear = law.tangential_stiffness or normal
    turning = shear * first.radius * last.radius
    materials = [
        {
            "young": normal / body.radius,
            "poisson": shear / normal,
            "frictionAngle": angle,
            "alphaKr": (law.rolling_stiffness or 0.0) * reduced**2 / turning,
            "etaRoll": (law.rolling_friction or 0.0) * reduced / body.radius,
            "alphaKtw": (law.twisting_stiffness or 0.0) / turning,
            "etaTwist": (law.twisting_friction or 0.0) / body.radius,
            "momentRotationLaw": True,
        }
        for body, angle in zip(
            [*scene.bodies, *[first] * len(scene.walls)], _friction_angles(scene), strict=True
        )
    ]
    # only by increments do the springs forget what the limits cut back
    options = {"always_use_moment_law": True, "useIncrementalForm": True}
    return {"law": TURNING, "materials": materials, "physics": {}, "options": options}


def _solid(scene: Scene) -> dict[str, Any]:
    """Return Hertz's and Mindlin's law of a material, with rolling.

    betan is the share of critical damping by the tangent stiffness: sqrt(5/6) of the damping ratio
    of a linear contact gives the same restitution at every speed.
    """
    law, bodies = scene.law, scene.bodies
    _check_solid(scene)
    physics, nu = {"gamma": law.surface_energy or 0.0}, law.poisson_ratio or 0.0
    if law.damping != "none":
        physics["betan"] = math.sqrt(5.0 / 6.0) * damping_ratio(law.restitution or 1.0)
        ratio = math.sqrt(2.0 * (1.0 - nu) / (2.0 - nu))  # of critical dampings
        physics["betas"] = physics["betan"] * (law.tangential_damping or 0.0) / ratio
    if law.rolling != "none":
        second = bodies[1].radius if len(bodies) > 1 else WALL_RADIUS * bodies[0].radius
        reduced = bodies[0].radius * second / (bodies[0].radius + second)
        physics["krot"] = (law.rolling_stiffness or 0.0) * reduced**2
        limit = (law.rolling_friction or 0.0) * reduced
        physics["eta"] = limit / (0.5 * (bodies[0].radius + second))
    options = {"includeAdhesion": law.normal == "dmt", "includeMoment": law.rolling != "none"}
    materials = [
        {"young": law.youngs_modulus, "poisson": nu, "frictionAngle": angle}
        for angle in _friction_angles(scene)
    ]
    return {"law": SOLID, "materials": materials, "physics": physics, "options": options}


def _check_solid(scene: Scene) -> None:
    law, name = scene.law, "Law2_ScGeom_MindlinPhys_Mindlin"
    check_words(law, name, normal="hertz dmt", damping="none coeff_restitution",
                tangential="none mindlin/force", rolling="none sds", twisting="none")  # fmt: skip
    material = law.youngs_modulus is not None and law.tangential_modulus is None
    bare = law.damping == law.tangential == "none"
    several = len(scene.bodies) + bool(scene.walls) > 2
    driven = bool(scene.segments and scene.walls and law.damping != "none")
    refuse_any(
        (not material, f"its {name} takes no modulus but of a material"),
        (law.normal == "dmt" and not bare,
         f"its {name} has dmt without dashpot and friction only"),
        (law.partner_restitution, f"its {name} gets the restitution of each pair, and mixes none"),
        (law.rolling_damping, f"its {name} has rolling springs without a dashpot only"),
        (law.rolling != "none" and several, f"its {name} has rolling springs of one R*"),
        (driven, f"its {name} has no dashpot between a wall and a sphere that is held"),
    )  # fmt: skip
