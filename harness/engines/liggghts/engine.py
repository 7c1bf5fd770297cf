"""LIGGGHTS as an engine of the harness; scenes by a plain script of some 40 lines for each.

LIGGGHTS's language is that of LAMMPS of about 2011: no words in conditions, no formats, no
``fix halt``. It is silent about an error where it has no log: every run writes its own. Models and
conventions are those of the public source of LIGGGHTS-PUBLIC 3.8.0
(``tangential_model_history.h``, ``surface_model_default.h``, ``rolling_model_epsd*.h``).
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from harness.engines.base import Job, Traits
from harness.engines.lammps_language import LammpsLanguage, runs_of
from harness.engines.output import Provenance, read_dump
from harness.engines.process import first_words, text_of
from harness.engines.registry import program_files
from harness.engines.scenes import (
    check_omitted_pairs,
    check_scene,
    check_stated,
    check_words,
    contact_mass,
    damping_of,
    kind,
    motion_of_table,
    partners,
    room,
)
from harness.engines.scripts import Task, rendered
from harness.errors import EngineMissingError, Unsupported
from harness.model.conventions import Rules
from harness.model.law import Law
from harness.model.scene import LOOK, Body, Motion, Scene, Wall, effective_radius

MODEL = "hooke/stiffness"  # the one normal model whose spring and dashpot can be given
TEMPLATES = Path(__file__).with_name("templates")
SAMPLES, STAGES = "samples.dump", "samples.stages"
SAME = 1e-9  # relative difference of coefficients that are tied to one another
AI = 2.25  # of k_n (mu_r R*)^2: Ai et al., Powder Technol. 206, 269 (2011)
FRAME = "ITEM: TIMESTEP\n"
# Open MPI for one process: no daemon that outlives it, no search for networks (0.3 s a start)
ALONE = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self"}
RULES = Rules(
    damping_in_cap="sticking_only",
    velocity_lever="contact_point",
    wall_lever="contact_point",
    wall_spin="levered",
    spring_frame="projected",
    torsion_frame="room",
    wall_touches_at_zero=True,
)
CONSTANT_TORQUE = {"rolling_axis": "projected", "rolling_load": "elastic"}  # rolling friction cdt
# LIGGGHTS's message on each of the short runs of a script, which cannot be turned off
_STRETCH = re.compile(r"\n? +Step \n +\d+ \n +\d+ \nLoop time of .*\n")


class Liggghts(LammpsLanguage):
    """LIGGGHTS-PUBLIC's executable, by default ``liggghts`` on PATH, or ``program``.

    It is started without an MPI launcher. ``workers`` processes run in parallel, by default as
    many as there are cores. Raise RequestError for a program that is not there,
    EngineMissingError where none was named and there is none.
    """

    name = "liggghts"
    command_name = "liggghts"
    words_compare = False
    programs = ("liggghts",)
    traits = Traits(
        install_hint="apt install liggghts (Debian, Ubuntu), or --program liggghts=PATH",
        versions=("LIGGGHTS-PUBLIC 3.8.0",),
        integrator="velocity-verlet",
        microseconds_per_step=2.5,
        lineage="LAMMPS",
    )

    def ask_version(self) -> Provenance:
        """Return the version that ``liggghts -help`` names.

        Raise EngineMissingError when it is not LIGGGHTS, or lacks the contact model.
        """
        output, _ = self.ask([self.program, "-log", "none", "-help"])
        version = re.search(r"^LIGGGHTS \(Version ([^,)\n]+)", output, re.MULTILINE)
        program = f"--program liggghts={self.program}"
        if version is None:
            raise EngineMissingError(
                f"{program} is not LIGGGHTS: its -help names no version{first_words(output)}"
            )
        if MODEL not in output.split():
            raise EngineMissingError(
                f"{program} ({version[1]}) was built without the contact model {MODEL}"
            )
        return Provenance("liggghts", version[1], (), self.program, "executable")

    def installed_files(self) -> list[Path]:
        """Return the program and its libraries."""
        return program_files(Path(self.program))

    def command(self, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run ``batch.in``.

        Its screen is a file: without one it crashes as it reports the triangles that it reads.
        """
        return [self.program, "-in", "batch.in", "-log", "none", "-screen", "screen.txt"]

    def environment(self, folder: Path) -> Mapping[str, str]:
        """Return the environment of a process.

        Open MPI keeps its session files in TMPDIR, and leaves them when it is killed.
        """
        return {**os.environ, **ALONE, "TMPDIR": str(folder)}

    def log_of(self, folder: Path, index: int) -> str:
        """Return the log of a task without the messages of each short run."""
        return _STRETCH.sub("", super().log_of(folder, index))

    # ---- scenes

    @staticmethod
    def rules(scene: Scene) -> Rules:
        """Return LIGGGHTS's conventions; raise Unsupported for a scene that it cannot run."""
        words(scene)
        return RULES.replace(**CONSTANT_TORQUE) if scene.law.rolling == "constant" else RULES

    def scene_script(self, job: Job) -> str:
        """Return the plain script of a job's scene."""
        return script(self.scene_of(job))

    def read_samples(self, folder: Path, scene: Scene) -> Motion:
        """Return the motion of a dump; forces on frozen bodies, which LIGGGHTS sets to 0, are NaN.

        Raise EngineOutputError for other columns or bodies, EngineNaNError for what is not finite.
        """
        frames: dict[str, str] = {}
        for frame in text_of(folder / SAMPLES).split(FRAME)[1:]:
            # the end of a segment is written again as the start of the next
            frames.setdefault(frame.partition("\n")[0], FRAME + frame)
        table, stages = read_dump("".join(frames.values()), self.title), None
        if scene.stages:  # step, x, y, vx, vy and wz of the first body
            lines = text_of(folder / STAGES).splitlines()
            rows = [[float(word) for word in line.split()] for line in lines]
            stages = np.array([[row[0], row[0] * scene.step, *row[1:]] for row in rows])
        motion = motion_of_table(self.title, scene, table, stages)
        check_omitted_pairs(self.title, scene, motion)
        for k, body in enumerate(scene.bodies if not scene.segments else ()):
            if body.motion == "free":  # the dump has the weight too
                motion.force[:, k] -= body.mass * np.array(scene.gravity)
            elif body.motion == "frozen":
                motion.force[:, k] = motion.torque[:, k] = np.nan
        return motion


# ---- the script of a scene


def script(scene: Scene) -> str:
    """Return the script of a scene, which writes its samples to a dump, and its stages to a file.

    Raise Unsupported for a scene that LIGGGHTS cannot run.
    """
    code, law, kinds = words(scene), scene.law, {kind(body): body for body in scene.bodies}
    sides = [*kinds.values(), None]
    pairs = [_coefficients(scene, code, side, other) for side in sides for other in sides]
    boundary, box = _box(scene)
    groups: dict[str, list[int]] = {}
    for k, body in enumerate(scene.bodies, 1):
        groups.setdefault("led" if scene.segments else body.motion, []).append(k)
    values = {
        "scene": scene,
        "words": code,
        "kinds": [*kinds],
        "kind": kind,
        "density": lambda body: body.mass / (4.0 / 3.0 * math.pi * body.radius**3),
        "boundary": boundary,
        "box": box,
        "coefficients": {name: [pair[name] for pair in pairs] for name in pairs[0]},
        "material": {
            "youngsModulus": law.youngs_modulus or 1e7,
            "poissonsRatio": law.poisson_ratio or 0.0,
        },
        # without a period one list of all pairs: what it keeps of a pair must not hang on its age
        "skin": room(scene) if boundary == "f f f" else 0.5 * min(b.radius for b in scene.bodies),
        "groups": groups,
        "weight": math.hypot(*scene.gravity),
        "runs": [*runs_of(scene)],
        "samples": SAMPLES,
        "stages": STAGES,
        "look": LOOK,
        "text": _text,
        "plane": _plane,
        "zip": zip,
    }
    return rendered([TEMPLATES], "scene.in.j2", values)


def _box(scene: Scene) -> tuple[str, str]:
    """Return the boundaries: of a periodic row a quarter of a diameter before its first body."""
    side, length = _text(room(scene)), scene.period[0]
    if length is None:
        return "f f f", " ".join([f"-{side} {side}"] * 3)
    largest = max(body.radius for body in scene.bodies)
    first = min(body.position[0] for body in scene.bodies) - 0.5 * largest
    across = [body.position[1] for body in scene.bodies]
    ends = (first, first + length, min(across) - 2.0 * largest, max(across) + 4.0 * largest)
    return "p s f", _text(*ends, -2.0 * largest, 2.0 * largest)


def _plane(wall: Wall) -> str:
    axis = wall.axis or 0  # of a scene that LIGGGHTS takes
    return f"{'xyz'[axis]}plane {_text(wall.point[axis])}"


def _text(*values: float) -> str:
    return " ".join(f"{value:.17g}" for value in values)


# ---- the law in LIGGGHTS's words


class Words(NamedTuple):
    """A law in LIGGGHTS's words, and the factor of its rolling spring."""

    models: str
    settings: str
    dashpot: str  # name of the normal dashpot
    factor: float


def words(scene: Scene) -> Words:
    """Return the law of a scene in LIGGGHTS's words.

    Raise Unsupported for a law or a scene that LIGGGHTS does not have.
    """
    check_scene(scene)
    check_stated(scene)
    law = scene.law
    sliding = {"none": "off", "linear_nohistory": "no_history"}.get(law.tangential, "history")
    model, settings, dashpot = _normal_words(law)
    rolling, turning, factor = _rolling_words(scene)
    models = f"model {model} tangential {sliding} rolling_friction {rolling}"
    limit = f"limitForce {'on' if law.clipped else 'off'}"
    return Words(models, f"{settings} {limit} {turning}".rstrip(), dashpot, factor)


def _normal_words(law: Law) -> tuple[str, str, str]:
    if law.normal == "hooke":
        dampings = "none velocity mass_velocity damping_ratio coeff_restitution"
        check_words(law, "hooke/stiffness", damping=dampings, twisting="none sds")
        return "hooke/stiffness", "absolute_damping on tangential_damping on", "gamman_abs"
    check_words(law, "hertz", normal="hertz", rolling="none constant", twisting="none")
    if law.damping != "coeff_restitution":
        tangentials = "none linear_nohistory mindlin mindlin_classic"
        check_words(law, "hertz/stiffness", damping="none viscoelastic", tangential=tangentials)
        return "hertz/stiffness", "tangential_damping on", "gamman"
    check_words(law, "hertz", tangential="none mindlin mindlin_classic")
    if law.poisson_ratio is None or law.tangential_modulus is not None:
        raise Unsupported("its hertz takes youngs_modulus and poisson_ratio, and no other modulus")
    ratio = math.sqrt(2.0 * (1.0 - law.poisson_ratio) / (2.0 - law.poisson_ratio))
    damping = 0.0 if law.tangential == "none" else law.tangential_damping or 0.0
    if damping and not _equal(damping, ratio):
        raise Unsupported(
            f"its hertz has no tangential dashpot but of {ratio:.9g} times the normal one, or none"
        )
    return "hertz", f"tangential_damping {'on' if damping else 'off'}", "gamman"


def _rolling_words(scene: Scene) -> tuple[str, str, float]:
    """Return rolling model, its setting and the factor of its spring.

    cdt has a constant torque; epsd2 the tangential spring and no dashpot; epsd 2.25 k_n mu_r^2;
    epsd3 any factor from 1 on (``global_properties.cpp``). ``torsionTorque`` has mu_w in the place
    of mu_r.
    """
    law = scene.law
    if law.rolling == law.twisting == "none":
        return "off", "", 1.0
    if law.rolling == "constant" and law.twisting == "none":
        return "cdt", "", 1.0
    if "none" not in (law.rolling, law.twisting):
        raise Unsupported("its rolling models resist rolling or twisting, not both")
    name, power, turning = "rolling", 0, ""
    if law.twisting != "none":
        name, power, turning = "twisting", 2, "torsionTorque on"
        _check_upright(scene)
    spring, damping = getattr(law, f"{name}_stiffness"), getattr(law, f"{name}_damping")
    radii = [effective_radius(*pair) for pair in partners(scene)]
    tied = [(law.tangential_stiffness or 0.0) * radius**power for radius in radii]
    if not damping and all(_equal(spring, stiffness) for stiffness in tied):
        return "epsd2", turning, 1.0
    full = (law.normal_stiffness or 0.0) * getattr(law, f"{name}_friction") ** 2
    if _equal(spring, AI * full):
        return "epsd", turning, AI
    if not 0.0 < (1.0 - SAME) * full <= spring:
        limit = f"k_n mu_{name[0]}^2 = {full:.6g}"
        raise Unsupported(f"has {name} springs of {limit} or more, or of k_t without a dashpot")
    return "epsd3", turning, max(spring / full, 1.0)


def _check_upright(scene: Scene) -> None:
    """Raise Unsupported where anything but a spin about the vertical line of centres happens."""
    aside = [*scene.gravity[:2]]
    for body in scene.bodies:
        aside += [*body.position[:2], *body.velocity[:2], *body.angular_velocity[:2]]
    if scene.segments or any(aside):
        raise Unsupported("has twisting springs that resist rolling as well")


def _coefficients(
    scene: Scene, words: Words, first: Body | None, second: Body | None
) -> dict[str, float]:
    """Return the coefficients of a contact by LIGGGHTS's names; None is a wall."""
    law = scene.law
    if first is None:
        first, second = second or scene.bodies[0], None
    eta, shear = law.damping_coefficient or 0.0, law.tangential_stiffness or 0.0
    if law.normal == "hooke":
        eta = damping_of(law, contact_mass(scene, first, second))
    elif law.moduli or law.tangential_modulus:
        shear = law.tangential_modulus or 8.0 * (law.moduli[1] if law.moduli else 0.0)
    limit, share = _rolling_coefficients(law, first, second)
    return {
        "kn": law.normal_stiffness or law.stiffness(1.0, 1.0) / 1.5,
        "kt": shear,
        words.dashpot: eta,
        words.dashpot.replace("gamman", "gammat"): eta * (law.tangential_damping or 0.0),
        "coefficientFriction": law.friction or 0.0,
        "coefficientRestitution": law.restitution or 1.0,
        "coefficientRollingFriction": limit,
        "coefficientRollingViscousDamping": share,
    }


def _rolling_coefficients(law: Law, first: Body, second: Body | None) -> tuple[float, float]:
    """Return the limit over R* and the share of critical damping of rolling or twisting.

    LIGGGHTS's moment of inertia, 7/5 m r^2, counts a frozen sphere with its own mass.
    """
    radius, power = effective_radius(first, second), 0 if law.rolling == "sds" else 1
    name = "twisting" if power else "rolling"
    spring = getattr(law, f"{name}_stiffness")
    if spring is None:
        return law.rolling_friction or 0.0, 0.0
    moments = [1.4 * body.mass * body.radius**2 for body in (first, second) if body]
    moment = 1.0 / sum(1.0 / value for value in moments)
    damping = getattr(law, f"{name}_damping") * radius ** (1 - power)
    limit = getattr(law, f"{name}_friction") / radius**power
    return limit, damping / 2.0 / math.sqrt(moment * spring)


def _equal(value: float, other: float) -> bool:
    return math.isclose(value, other, rel_tol=SAME)
