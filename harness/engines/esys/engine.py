"""ESyS-Particle as an engine of the harness: a process for each model, under an MPI launcher.

One rank, the master, reads the script; the other one computes. A second model in the same process
waits for ever. It runs under Open MPI, whose launcher, environment and words stand here.

Contacts with friction, read off the source of 2.3 (``RotFricInteraction.cpp``): a linear spring
without a dashpot; the force of the tangential one is summed up in space, and does not turn with
the contact; it acts where the distance of the centres is parted as the radii are. Its walls have
no friction.
"""

from __future__ import annotations

import json
import math
import os
import re
import shlex
import shutil
from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

from harness.engines.contract import Job, finished
from harness.engines.output import Output
from harness.engines.process import FAULTS, Ended, Limits, last_words, signal_of
from harness.engines.programs import (
    OF_PYTHON,
    RUNS,
    ScriptedEngine,
    digest,
    launcher_words,
    program_files,
    tree_files,
)
from harness.engines.scripts import Datum, Task
from harness.engines.traits import (
    CLIPPED_ALONE,
    PLANES,
    RESISTANCES,
    ContactModel,
    States,
    Traits,
    never_attracts,
    takes,
)
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineMissingError,
    EngineOutputError,
    EngineTimeoutError,
    RequestError,
)
from harness.observables.provenance import Provenance
from harness.parameters.law import PLASTIC, contact_of, contact_values, fewest_steps_per_contact
from harness.parameters.scene import ContactScene

LAUNCHERS = ("mpirun.openmpi", "mpirun")
"""Debian's ESyS-Particle belongs to Open MPI, whose launcher has this name there."""

RANKS = ("-np", "2")

OPEN_MPI = {
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}
"""Runs go side by side on few cores: a rank that waits gives way, and none is bound to a core."""

TEMPORARY = ("OMPI_MCA_orte_tmpdir_base", "OMPI_MCA_btl_vader_backing_directory")
"""Where Open MPI keeps its files; a process that is killed leaves them, in its folder here."""

AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
"""In a container there is nobody else."""


def environment(folder: Path) -> Mapping[str, str]:
    """Return the environment of an Open MPI that keeps its files in a folder."""
    root = hasattr(os, "geteuid") and os.geteuid() == 0
    temporary = dict.fromkeys(TEMPORARY, str(folder))
    return {**os.environ, **OPEN_MPI, **temporary, **(AS_ROOT if root else {})}


def without_frame(output: str) -> str:
    """Return a process's output without the launcher's frame of dashed lines."""
    return "".join(f"{line}\n" for line in output.splitlines() if line.strip("-"))


def find_launcher(words: str | None) -> list[str]:
    """Return the launcher's words, its program as a path."""
    if words is not None:
        return launcher_words(words)
    if path := next(filter(None, map(shutil.which, LAUNCHERS)), None):
        return [path]
    raise EngineMissingError(
        "ESyS-Particle needs the launcher of Open MPI, mpirun.openmpi: apt install openmpi-bin"
    )


RULES = {"torque_lever": "share", "velocity_lever": "share", "spring_frame": "room"}

_MOVES: States = {"motion_1": ("free",), "motion_2": ("free", "frozen")}
_SPHERES: States = {PLANES: (0,), **_MOVES}

CONTACTS = (
    ContactModel("RotElastic", takes("hooke", "none", "none") | _MOVES),
    ContactModel("RotFriction", takes("hooke", "none", "linear_history") | _SPHERES, RULES),
    ContactModel("HertzianElastic", takes("hertz", "none", "none") | _SPHERES),
    ContactModel(
        "HertzianViscoElastic",
        takes("hertz", "viscoelastic", "none") | _SPHERES,
        needs=never_attracts,
    ),
)


GREETING = """from esys.lsm import LsmMpi
sim = LsmMpi(numWorkerProcesses=1, mpiDimList=[1, 1, 1])
print("RESULT version =", sim.getLsmVersion())
sim.exit()
"""

DAMPED = frozenset({"steps_per_contact", *contact_values(PLASTIC)})
"""Values of a job whose contacts have a dashpot, which bounds the step."""

START = ("x", "y", "vx", "vy")
"""Of the spheres of a scene; runs that differ in those of the first one share a model."""


class Esys(ScriptedEngine):
    """ESyS-Particle with Hertz's contact where it is damped, linear springs where it is not.

    ``launcher`` is the command that starts ``program`` on two ranks (Open MPI's
    ``mpirun.openmpi``, or ``mpirun``, by default). Runs over a row that differ by the
    grain's start only share a model.
    """

    name = "esys"
    traits = Traits(
        install_hint="apt install esys-particle (Debian), or --program esys=PATH",
        versions=("2.3.4",),
        integrator="mfix-euler",
        microseconds_per_step=32.0,
        frictionless=CLIPPED_ALONE,
        spring="Hertz",
        force_from_velocity=True,
        title="ESyS-Particle",
        contact_models=CONTACTS,
        # velocities first, by the forces at the start of a step
        contact_powers=(1.0,),
        caveats=(
            "LinearDashpot brakes along the tangent too: it cannot state a frictionless contact.",
            "setParticleNonDynamic takes a tag, and says nothing when it is given an id.",
            "An exception in the script leaves the worker waiting for ever.",
            "getForce of a particle crashes, and so does getParticleList before the first step.",
            "RotElasticPrms takes scaling=False and forgets it: its stiffness is multiplied by the "
            "mean radius of the two spheres; that of a wall always by pi times the radius.",
            "HertzMindlinViscoPrms keeps no tangential spring from step to step.",
            "Field savers append to the files of an earlier run, and write six digits.",
        ),
    )
    programs = ("esysparticle",)
    deciding_variables = OF_PYTHON
    unused_values = frozenset(
        {"interface", "surface_energy", "restitution", "tangential_damping"} | RESISTANCES
    )
    """Of contacts: what no interaction takes."""
    jinja: ClassVar[Mapping[str, bool]] = {"trim_blocks": False, "keep_trailing_newline": False}

    def __init__(
        self,
        program: str | None = None,
        launcher: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
    ) -> None:
        path = self.find(program)
        self._launcher = find_launcher(launcher)
        super().__init__(path, workers, limits)
        self.opened_with["launcher"] = shlex.join(self._launcher)

    @classmethod
    def installed_files(cls, program: Path) -> list[Path]:
        """Return the program, its libraries, and its Python modules."""
        prefix = program.resolve().parent.parent
        modules = [*prefix.glob("lib/python3*/*-packages/esys")]
        loaded = program_files(program)
        return [*loaded, *(f for module in modules for f in tree_files(module))] if modules else []

    @classmethod
    def deciding(cls, **options: Any) -> Mapping[str, str]:
        """Return the launcher, with a digest of its program."""
        words = find_launcher(options.get("launcher"))
        return {"launcher": f"{shlex.join(words)} {digest(Path(words[0]))}"}

    def ask_version(self) -> Provenance:
        """Return the version that a short run names.

        Raise EngineMissingError when there is none, as with another MPI's launcher.
        """
        words = [*self._launcher, *RANKS, self.program, "version.py"]
        output, ended = self.ask(words, {"version.py": GREETING})
        versions = re.findall(r"^RESULT version = (.*)$", output, re.MULTILINE)
        if len(versions) != 1:
            reason = "it gave no answer" if ended.timed_out else f"exit status {ended.code}"
            raise EngineMissingError(
                f"{shlex.join(self._launcher)} does not run {self.program}: {reason}"
                f"{last_words(without_frame(ended.said))}; it needs the launcher of the Open MPI "
                "that it was built with"
            )
        how = Path(self._launcher[0]).name
        return Provenance(self.name, versions[0], (), self.program, how)

    def refuses(self, job: Job) -> str:
        """Return why it cannot run a job: besides the rules, a step that is not stable."""
        reason = super().refuses(job)
        if reason or not set(job.values) >= DAMPED:
            return reason
        contact, steps = contact_of(job.values), float(job.values["steps_per_contact"])
        fewest = fewest_steps_per_contact(contact)
        if steps > fewest:
            return ""
        return (
            f"steps_per_contact = {steps:g} is unstable in {self.title} at damping ratio "
            f"{contact.zeta:.4g}: must be greater than {fewest:.3f}"
        )

    @classmethod
    def scene_values(cls, scene: ContactScene) -> dict[str, Datum]:
        """Return the data of a scene, with K and A of Hertz's contact in the place of a dashpot.

        An undamped impact at the scene's speed reaches the overlap that it reaches with the
        stiffness k, and there the dashpot's coefficient is 2 zeta sqrt(k m_eff). Without a speed
        there is no such overlap: raise RequestError. Where forces are sampled the spring is linear.
        """
        k, mass = scene.stiffness, float(scene.mass[0])
        effective = 0.5 * mass if scene.effective_mass == "half" else mass
        overlap = scene.hertz_speed * math.sqrt(mass / k)
        if not scene.forces and overlap == 0.0:
            raise RequestError("speed = 0.0 m/s: a Hertz contact needs a speed or gravity above 0")
        coefficient = 0.0 if scene.forces else 1.25 * k / math.sqrt(overlap)
        relaxation = 1.6 * scene.damping_ratio * math.sqrt(effective / k)
        dashpot = {"coefficient": coefficient, "relaxation": relaxation}
        return {**super().scene_values(scene), **dashpot}

    def shares(self, tasks: Sequence[Task]) -> list[list[int]]:
        """Return the indices of the tasks of each model."""
        models: dict[str, list[int]] = {}
        for index, task in enumerate(tasks):
            rest: dict[str, Any] = {**task.values, "script": task.script.sha256}
            if task.values.get("period") and not task.values["forces"]:
                rest |= {name: task.values[name][1:] for name in START}
            else:
                rest["alone"] = index
            models.setdefault(json.dumps(rest), []).append(index)
        return list(models.values())

    def run_batch(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks in one model; where that fails, run each in a model of its own."""
        outcomes = super().run_batch(tasks)
        outputs = [outcome for outcome in outcomes if isinstance(outcome, Output)]
        if len(tasks) == 1 or len(outputs) == len(outcomes) == len(tasks):
            return outcomes
        if isinstance(outcomes[-1], EngineTimeoutError):
            return [copy(outcomes[-1]) for _ in tasks]
        return [outcome for task in tasks for outcome in self.run_batch([task])]

    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run one model."""
        return [*self._launcher, *RANKS, self.program, tasks[0].script.name, RUNS]

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again by hand."""
        return f"mpirun {shlex.join(RANKS)} {super().command_line(task)}"

    def environment(self, folder: Path) -> Mapping[str, str]:
        """Return the environment of an Open MPI that keeps its files in the folder."""
        return environment(folder)

    def error_of(self, ended: Ended, log: str) -> EngineError | None:  # noqa: ARG002
        """Return the error by the end of a process, or None where it ended well."""
        ended = replace(ended, said=without_frame(ended.said))
        raised = re.findall(r"^(\w*(?:Error|Exception)\b.*)$", ended.said, re.MULTILINE)
        crashed = ended.timed_out or signal_of(ended.code) in FAULTS
        if raised and not crashed and "MemoryError" not in ended.said:
            return EngineInputError(f"{self.title} refused its input: {raised[-1][:160]}")
        died = ended.error(self.title)
        if died is None and not finished(ended.said):
            return EngineOutputError(f"{self.title} ended without a result{last_words(ended.said)}")
        return died
