"""LIGGGHTS as an engine of the harness, and the contacts with friction that it states.

Models and rules of these contacts are read off the source of 3.8.0. LIGGGHTS's language is that of
LAMMPS of about 2011: no words in conditions, no formats, no ``fix halt``. It is
silent about an error where it has no log: every run writes its own.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from harness.engines.contract import Job
from harness.engines.lammps.language import LammpsLanguage
from harness.engines.liggghts import scenes
from harness.engines.process import first_words
from harness.engines.scripts import Datum, Task
from harness.engines.traits import DASHPOTS, ContactModel, ContactValues, Traits, takes
from harness.errors import EngineError, EngineMissingError
from harness.model.motion import Motion
from harness.observables.provenance import Provenance
from harness.parameters.scene import ContactScene

SAME = 1e-9
"""Relative difference of coefficients that are tied to one another."""

RULES = {
    "damping_in_cap": "sticking_only",
    "velocity_lever": "contact_point",
    "wall_lever": "contact_point",
}
"""tangential_model_history.h and surface_model_default.h."""

TURNING = {**RULES, "wall_turning": "levered"}
"""rolling_model_epsd.h, _epsd2.h and _epsd3.h, which take the spin at a wall with its lever.

They add up a torque that keeps its direction while the normal turns: with the normal it turns only
where all moves in one plane.
"""

AI = 2.25
"""Of k_n (mu_r R*)^2, the stiffness per radian: Ai et al., Powder Technol. 206, 269 (2011)."""

SPRINGS = {"rolling": ("mu_r", "N/m"), "twisting": ("mu_w", "N m")}
"""Of both kinds of springs: their limit, and the unit of their stiffness."""


def as_tangential(kind: str, values: ContactValues) -> str:
    """Return why epsd2 does not have a spring, or nothing where it has."""
    if why := _turns_aside(kind, values):
        return why
    if values[f"{kind}_damping"] != 0.0:
        return f"has {kind} springs without a dashpot only"
    stiffness = float(values["tangential_stiffness"])
    if kind == "rolling":
        tie = f"k_t = {stiffness:.6g} N/m"
    elif "radius_2" in values and values["planes"]:
        return "has twisting springs of k_t R*^2, and R* at a wall is another"
    else:
        stiffness *= _reduced_radius(values) ** 2
        tie = f"k_t R*^2 = {stiffness:.6g} N m"
    return "" if _equal(values[f"{kind}_stiffness"], stiffness) else f"has {kind} springs of {tie}"


def as_normal(kind: str, values: ContactValues) -> str:
    """Return why epsd does not have a spring, or nothing where it has."""
    return _turns_aside(kind, values) or _of_normal(kind, values, AI, AI)


def by_factor(kind: str, values: ContactValues) -> str:
    """Return why epsd3 does not have a spring, or nothing where it has.

    Its factor, in the place of 2.25, is at least 1 (global_properties.cpp).
    """
    return _turns_aside(kind, values) or _of_normal(kind, values, 1.0, math.inf)


def _of_normal(kind: str, values: ContactValues, least: float, most: float) -> str:
    """Return why a spring is not a factor of k_n times its limit squared, or nothing.

    The limit over R* is LIGGGHTS's mu; the spring of the rolling displacement is the torque's over
    R*^2, so that R* is in neither.
    """
    limit, unit = SPRINGS[kind]
    full = float(values["normal_stiffness"]) * float(values[f"{kind}_friction"]) ** 2
    stiffness = float(values[f"{kind}_stiffness"])
    if full > 0.0 and least * full * (1.0 - SAME) <= stiffness <= most * full * (1.0 + SAME):
        return ""
    more, factor = ("", f"{least:g} ") if least == most else (" or more", "")
    return f"has {kind} springs of {factor}k_n {limit}^2 = {least * full:.6g} {unit}{more}"


def _turns_aside(kind: str, values: ContactValues) -> str:
    """Return why a twisting spring, which resists rolling as well, is no other; or nothing.

    It has but a twist to resist where spheres spin about the vertical, one above another.
    """
    if kind == "rolling":
        return ""
    aside = ["gravity_x", "gravity_y"]
    for body in ("1", "2") if "radius_2" in values else ("1",):
        aside += [f"{name}_{body}" for name in ("x", "y", "vx", "vy", "wx", "wy")]
    if values["motion_1"] == "prescribed" or any(values[name] != 0.0 for name in aside):
        return "has twisting springs that resist rolling as well"
    return ""


def _reduced_radius(values: ContactValues) -> float:
    """Return R* of the pair, or of the sphere on a wall [m]."""
    radius = float(values["radius_1"])
    if "radius_2" not in values:
        return radius
    other = float(values["radius_2"])
    return radius * other / (radius + other)


def from_material(values: ContactValues) -> str:
    """Return why model hertz does not have a tangential dashpot, or nothing where it has."""
    poisson = float(values["poisson_ratio"])
    ratio = math.sqrt(2.0 * (1.0 - poisson) / (2.0 - poisson))
    if values["tangential"] == "none" or values["tangential_damping"] == 0.0:
        return ""
    if _equal(values["tangential_damping"], ratio):
        return ""
    return f"has no tangential dashpot but of {ratio:.9g} times the normal one, or none"


def _equal(value: str | float, other: str | float) -> bool:
    return math.isclose(float(value), float(other), rel_tol=SAME)


_SPRINGS = "none linear_nohistory linear_history linear_history_classic"
_SOLIDS = "none linear_nohistory mindlin mindlin_classic"
_TURNING: dict[str, Callable[[str, ContactValues], str]] = {
    "epsd2": as_tangential,
    "epsd": as_normal,
    "epsd3": by_factor,
}


def _turning(kind: str, name: str) -> ContactModel:
    """Return model hooke/stiffness with a rolling_friction, for rolling or for twisting."""
    torsion = " torsionTorque" if kind == "twisting" else ""
    return ContactModel(
        name + torsion,
        takes("hooke", DASHPOTS, _SPRINGS, **{kind: "sds"}),
        TURNING,
        partial(_TURNING[name], kind),
    )


CONTACTS = (
    ContactModel("hooke/stiffness", takes("hooke", DASHPOTS, _SPRINGS), RULES),
    *(_turning(kind, name) for kind in SPRINGS for name in _TURNING),
    ContactModel("hertz/stiffness", takes("hertz", "none viscoelastic", _SOLIDS), RULES),
    ContactModel(
        "hertz",
        takes("hertz", "coeff_restitution", "none mindlin mindlin_classic"),
        RULES,
        from_material,
    ),
)


MODEL = "hooke/stiffness"
"""The one normal model whose spring and dashpot can be stated."""

ALONE = {"OMPI_MCA_ess_singleton_isolated": "1", "OMPI_MCA_pml": "ob1", "OMPI_MCA_btl": "self"}
"""Open MPI for one process: no daemon that outlives it, no search for networks (0.3 s a start)."""

_STRETCH = re.compile(r"\n? +Step \n +\d+ \n +\d+ \nLoop time of .*\n")
"""What LIGGGHTS says of each of the short runs of a script, which cannot be turned off."""


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
    self_contained = True
    unused_values = frozenset(("interface", "surface_energy"))
    """Of contacts with friction: refused but for one value."""
    traits = Traits(
        install_hint="apt install liggghts (Debian, Ubuntu), or --program liggghts=PATH",
        versions=("LIGGGHTS-PUBLIC 3.8.0",),
        integrator="velocity-verlet",
        microseconds_per_step=2.5,
        lineage="LAMMPS",
        contact_models=CONTACTS,
        caveats=(
            "In two dimensions (dimension 2) its particles are discs of unit height: 3/2 of the "
            "mass of spheres of 1 m.",
            "Clipping the tail (limitForce) is an option, off by default.",
            "Model hooke refuses restitutions up to 0.05, and its stiffness grows with the "
            "effective mass to the power 1/5: take hooke/stiffness.",
            "Words cannot be compared in its scripts, and errors are silent without a log.",
        ),
    )

    @classmethod
    def scene_values(cls, scene: ContactScene) -> dict[str, Datum]:
        """Return the data of a scene, with its extent and the number of its stages.

        No list may be empty: one of no stages holds a zero.

        Places over a row have 15 digits, as those of LAMMPS's script, whose variables write so
        many: their rounding decides whether a grain that just touches is in contact at the start.
        """
        reach = float(abs(scene.position).max())
        values = {**super().scene_values(scene), "stages": len(scene.stages), "reach": reach}
        if scene.period is not None:
            for name, column in zip(("x", "y"), scene.position.T.tolist(), strict=True):
                values[name] = [float(f"{place:.15g}") for place in column]
        return values if scene.stages else {**values, "places": [0], "floors": [0]}

    def rules(self, scene: Scene) -> Rules:
        """Return the conventions by which a scene is run; raise Unsupported."""
        return scenes.rules(scene)

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motion of the scene of each job, or the error of its run, in order."""
        return scenes.motions(
            self.program, [self.scene_of(job) for job in jobs], workers=self.workers,
            limits=self.limits,
        )  # fmt: skip

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

    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
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
