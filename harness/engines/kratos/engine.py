"""Kratos DEM as an engine of the harness: generated scripts that any Python with Kratos runs.

Kratos is never imported into the harness's own process: it prints, and it may crash. Scenes are
run by ``run_scenes.py``. A linear contact is DEM_D_Linear_viscous_Coulomb, where k_t is at least
4/3 k_n DEM_D_Linear_Custom_Constants, one of a material DEM_D_Hertz_viscous_Coulomb, with
attraction DEM_D_Hertz_viscous_Coulomb_DMT; a wall is a rigid face. Their formulas and conventions
are those of the public source of Kratos 10.4.4 (``spheric_particle.cpp``, ``DEM_D_*_CL.cpp``,
``GeometryFunctions.h``).
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from harness.engines.base import Traits
from harness.engines.output import Provenance
from harness.engines.process import FAULTS as FATAL_SIGNALS
from harness.engines.process import Ended, last_words, signal_of
from harness.engines.registry import OF_PYTHON, ask_program, program_files, tree_files
from harness.engines.scenes import (
    SceneFileEngine,
    check_scene,
    check_stated,
    check_words,
    contact_mass,
    damping_of,
    nearest_body,
    partners,
    refuse_any,
    room,
)
from harness.engines.scripts import ASK_SECONDS
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

RELEASES = ("10.2.3", "10.4.3", "10.4.4")  # with which the scripts were tried
HELLO = """
from importlib.metadata import PackageNotFoundError, version
import KratosMultiphysics, KratosMultiphysics.DEMApplication
try:
    release = version("KratosMultiphysics")
except PackageNotFoundError:
    release = KratosMultiphysics.KratosGlobals.Kernel.Version()
print("\\nKRATOS", release)
"""
# prints where Kratos is, without importing it
WHERE = (
    'from importlib.util import find_spec; print(find_spec("KratosMultiphysics").origin, end="")'
)
FAREWELL = "Deregistering "  # how the lines begin that Kratos prints at its end, whatever it was
LINEAR, CUSTOM = "DEM_D_Linear_viscous_Coulomb", "DEM_D_Linear_Custom_Constants"
HERTZ, DMT = "DEM_D_Hertz_viscous_Coulomb", "DEM_D_Hertz_viscous_Coulomb_DMT"
TORQUE = "DEMRollingFrictionModelConstantTorque"
WORDS = {  # submodels by the normal part of a law, and of DMT
    "hooke": {
        "damping": "none velocity mass_velocity damping_ratio coeff_restitution",
        "tangential": "none linear_history",
        "rolling": "none constant",
    },
    "hertz": {
        "damping": "none coeff_restitution",
        "tangential": "none mindlin_rescale/force",
        "rolling": "none constant",
    },
}
DMT_WORDS = {"normal": "dmt", "damping": "none", "tangential": "none", "rolling": "none"}
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


class Kratos(SceneFileEngine):
    """Kratos DEM in worker processes of the Python ``program``, this one unless given."""

    name = "kratos"
    traits = Traits(
        install_hint="pip install KratosDEMApplication (extra 'kratos'), "
        "or --program kratos=PYTHON",
        versions=RELEASES,
        integrator="velocity-verlet",
        microseconds_per_step=10.0,
        digits=15,
        title="Kratos",
    )
    deciding_variables = OF_PYTHON
    options = ("-u",)

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the path of the Python that is named, or of this one."""
        return sys.executable if program is None else super().find(program)

    def installed_files(self) -> list[Path]:
        """Return the Python, and the package of Kratos that it would import."""
        reply = ask_program([self.program, "-c", WHERE], ASK_SECONDS)
        package, interpreter = (
            Path(reply.stdout if reply else ""),
            program_files(Path(self.program)),
        )
        if not package.is_absolute() or not interpreter:
            return []
        return [*interpreter, *tree_files(package.parent)]

    def ask_version(self) -> Provenance:
        """Return Kratos's version; raise EngineMissingError where this Python has none."""
        _, ended = self.ask([self.program, "-c", HELLO])
        releases = re.findall(r"^KRATOS (.+)$", ended.output, re.MULTILINE)
        if not releases or ended.code != 0:
            why = f"{self.program} has no Kratos with its DEM application"
            raise EngineMissingError(self.traits.missing(why + last_words(ended.output)))
        return Provenance(self.name, releases[-1], ("DEMApplication",), self.program, "worker")

    def error_of(self, ended: Ended, log: str) -> EngineError | None:
        """Return the error by the end of a process; Kratos's own messages are long."""
        lines = [line for line in ended.output.splitlines() if not line.startswith(FAREWELL)]
        ended = replace(ended, output="\n".join(lines))
        if ended.code and not ended.timed_out and signal_of(ended.code) not in FATAL_SIGNALS:
            reason = last_words(ended.output)
            if re.search(r"^(?:ModuleNotFound|Import)Error: ", ended.output, re.MULTILINE):
                return EngineMissingError(self.traits.missing(f"no Kratos{reason}"))
            if "is not a number" in ended.output:
                return EngineNaNError(f"Kratos met a value that is not a number{reason}")
            refusal = re.search(r"^RuntimeError: (?:Error: )?(.*)$", ended.output, re.MULTILINE)
            if refusal:
                return EngineInputError(f"Kratos refused its input: {refusal[1].strip()[:160]}")
        return super().error_of(ended, log)

    @staticmethod
    def rules(scene: Scene) -> Rules:
        """Return Kratos's conventions; raise Unsupported for a scene that it cannot run."""
        words(scene)
        return RULES.replace(**CONSTANT_TORQUE) if scene.law.rolling == "constant" else RULES

    def scene_words(self, scene: Scene) -> Mapping[str, Any]:
        """Return the law of a scene in Kratos's words."""
        return words(scene)


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
    if row:  # four spheres represent it
        scene = scene.replace(bodies=scene.bodies[:1] + scene.bodies[1:2] * 4)
    name, law, friction = _name(scene), scene.law, scene.law.friction or 0.0
    values = {
        "STATIC_FRICTION": friction,
        "DYNAMIC_FRICTION": friction,
        "FRICTION_DECAY": 0.0,
        "COEFFICIENT_OF_RESTITUTION": 0.0,
        "ROLLING_FRICTION": _rolling_friction(scene),
    }
    if name == DMT:  # of both surfaces: F = 2 pi PARTICLE_COHESION R*
        values["PARTICLE_COHESION"] = 2.0 * (law.surface_energy or 0.0)
    elif name == CUSTOM:
        values["K_NORMAL"] = law.normal_stiffness or 0.0
        values["K_TANGENTIAL"] = law.tangential_stiffness or 0.0
    young, poisson, wall_young = _material(scene, name)
    bodies, walls = scene.bodies, [None] * len(scene.walls)
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
    length, (grain, *others) = scene.period[0], scene.bodies
    if length is None:
        return None
    if grain.motion != "free" or not others or not _is_row(others, length):
        raise Unsupported("has periodic boundaries for one body on a row of equal fixed spheres")
    if scene.law.tangential != "none":
        raise Unsupported("has no friction on an endless row")
    return length / len(others)


def _is_row(spheres: Sequence[Body], length: float) -> bool:
    """Return whether spheres are fixed, equal and at equal distances along x over a length [m]."""
    pitch, (x, y, z) = length / len(spheres), spheres[0].position
    return all(
        sphere.motion != "free"
        and sphere.replace(position=ZERO) == spheres[0].replace(position=ZERO)
        and math.dist(sphere.position, (x + k * pitch, y, z)) <= SAME * pitch
        for k, sphere in enumerate(spheres)
    )


def _name(scene: Scene) -> str:
    """Return the name of Kratos's law; raise Unsupported for a law that it is not."""
    law, name = scene.law, {"hooke": LINEAR, "hertz": HERTZ}.get(scene.law.normal, DMT)
    if name == LINEAR:
        ratio = (law.tangential_stiffness or 0.0) / (law.normal_stiffness or 1.0)
        name = CUSTOM if ratio >= MOST_SHEAR else LINEAR
    check_words(law, name, **WORDS.get(law.normal, DMT_WORDS), twisting="none")
    damped, modulus = law.damping != "none", law.normal_modulus or law.tangential_modulus
    refuse_any(
        (modulus is not None, f"its {name} takes no modulus but of a material"),
        (damped and not law.clipped, "never attracts (clipped = True)"),
        (damped and law.tangential != "none",
         "has a dashpot along the surface that is tied to the normal one, and limited twice"),
    )  # fmt: skip
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
