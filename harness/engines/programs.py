"""Engines that run script files through a program: find it, read its version, run it.

A program is identified by its content: a modified release may print the same version.

To make such an engine, subclass :class:`ScriptedEngine` next to a folder ``templates`` with a file
``<template>.<extension>.j2`` for each template of a case that the code can run, and give

- ``name``, ``traits`` (whose ``title`` messages write), ``programs`` (names on PATH, the first
  that is there is taken), ``extension`` of script files;
- ``ask_version``: who the program is, from :meth:`~ProgramEngine.ask`;
- ``command``: the words that run a batch of tasks in a folder.

A script declares the values it takes and prints ``RESULT name = value``, ``RESULT verdict = ...``
last. By default it has a dictionary ``PARAMETERS``, takes the runs of a batch from a JSON list and
writes the lines of run i to ``<i>.txt`` when it is over, and its series to ``<i>.csv``. Override
the other methods and class attributes of :class:`ScriptedEngine` for another form.
"""

from __future__ import annotations

import hashlib
import json
import os
import shlex
import shutil
import subprocess
import sys
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from harness.engines.base import Engine, Job
from harness.engines.jobs import Batches, cores, dealt
from harness.engines.output import SERIES, Output, Table, finished, read_csv, read_dump, results_in
from harness.engines.process import Ended, Limits, Processes, first_text, fresh_folder, text_of
from harness.engines.provenance import Provenance
from harness.engines.scripts import Script, ScriptSource, Task
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMissingError,
    EngineNaNError,
    RequestError,
)

if TYPE_CHECKING:
    from harness.model.conventions import Rules
    from harness.model.motion import Motion
    from harness.model.scene import Scene

ASK_SECONDS, LOADER_SECONDS = 60.0, 10.0
RUNS = "runs.json"
# variables that decide which code runs, and likewise in a program that imports modules
ENVIRONMENT = ("LD_LIBRARY_PATH", "LD_PRELOAD", "DYLD_LIBRARY_PATH")
OF_PYTHON = (*ENVIRONMENT, "PYTHONPATH", "PYTHONHOME", "PYTHONUSERBASE")


# ---- programs by name


def find_program(option: str, name: str) -> str:
    """Return the absolute path of a program, on PATH or next to this Python.

    Raise RequestError naming the option, such as ``lmp`` or ``program NAME=``.
    """
    path = shutil.which(name) or shutil.which(name, path=str(Path(sys.executable).parent))
    if path is None:
        option += "" if option.endswith("=") else " "
        raise RequestError(
            f"--{option}{name!r}: no such executable; give a path, or a name found on PATH"
        )
    return str(Path(path).absolute())


def program_of_python(name: str) -> str:
    """Return the path of a program next to this Python, else its name, to be found on PATH."""
    path = Path(sys.executable).with_name(name)
    return str(path) if path.exists() else name


def program_words(option: str, command: str) -> list[str]:
    """Return the words of a command: the absolute path of its program, then its arguments.

    A file that exists, or a name on PATH, is taken whole, blanks included. Raise RequestError for
    a command that cannot be split into words, or whose program is not there.
    """
    with suppress(RequestError):
        return [find_program(option, command)]
    try:
        program, *arguments = shlex.split(command) or [""]
    except ValueError as error:
        raise RequestError(f"--{option} {command!r} cannot be read: {error}") from None
    return [find_program(option, program), *arguments]


def launcher_of(ranks: int, program: str | None = None) -> str:
    """Return a command that starts ranks of MPI: of the program's installation, else on PATH.

    Another MPI's launcher would start as many runs of one rank. Without a program that is a path,
    the installation is that of this Python.
    """
    path = program if program and Path(program).name != program else sys.executable
    mpirun = Path(path).with_name("mpirun")
    return f"{shlex.quote(str(mpirun)) if mpirun.exists() else 'mpirun'} -n {ranks}"


# ---- programs by content


def facts(
    engine: str,
    how: str,
    files: Sequence[Path],
    environment: Sequence[str] = ENVIRONMENT,
    options: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Return the identity of an engine, JSON-ready, by the contents of its files, program first.

    ``options`` are those of the engine that no job has and that decide a result.
    """
    return {
        "engine": engine,
        "how": how,
        "program": str(files[0]),
        "files": sorted({f"{digest(path)} {path.name}" for path in files}),
        "options": dict(options or {}),
        "environment": {name: os.environ[name] for name in environment if name in os.environ},
    }


def tree_files(folder: Path) -> list[Path]:
    """Return the files below a folder, in order, but for byte code, which follows from them."""
    paths = (path for path in folder.rglob("*") if "__pycache__" not in path.parts)
    return sorted(path for path in paths if path.is_file())


def program_files(program: Path) -> list[Path]:
    """Return a program and all that the loader gives it; nothing for a script."""
    with program.open("rb") as stream:
        is_script = stream.read(2) == b"#!"
    libraries = [] if is_script else with_libraries(program.resolve())
    return [program, *libraries] if libraries else []


@cache  # the fingerprint of an engine is needed with every batch of runs
def with_libraries(program: Path, *more: Path) -> list[Path]:
    """Return a program or library, what the loader gives it, and ``more``; nothing on failure."""
    done = ask_program(["ldd", str(program)], LOADER_SECONDS)
    if done is None:
        return []
    if done.returncode != 0 and "not a dynamic executable" not in done.stderr + done.stdout:
        return []
    # as in "libm.so.6 => /lib/libm.so.6 (0x7f...)"
    lines = [line.split() for line in done.stdout.splitlines()]
    paths = [Path(next((w for w in words if w.startswith("/")), "")) for words in lines]
    return [program, *(path for path in paths if path.is_file()), *more]


def ask_program(words: Sequence[str], seconds: float) -> subprocess.CompletedProcess[str] | None:
    """Return the output and exit status of a program within so many seconds of wall time.

    None where it cannot be started or takes longer. It has no input.
    """
    with suppress(OSError, subprocess.TimeoutExpired):
        return subprocess.run(
            words,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            errors="surrogateescape",  # as in the names of files
            timeout=seconds,
            check=False,
        )
    return None


@cache
def digest(path: Path) -> str:
    """Return the BLAKE2 digest of a file, half the time of SHA-256 for 40 MB of library."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, lambda: hashlib.blake2b(digest_size=32)).hexdigest()


class ProgramEngine(Engine):
    """The part of an engine that is its ``program``, by default the first of ``programs`` on PATH.

    ``workers`` processes run in parallel, by default as many as there are cores.
    ``self_contained`` means that a result depends on the program and its libraries alone, else
    ``installed_files`` may name the other files: runs are cached under their contents, and the
    ``deciding_variables`` of the environment. Raise RequestError for no worker and a named program
    that is not there, EngineMissingError where none is named and there is none.
    """

    programs: ClassVar[tuple[str, ...]] = ()
    self_contained: ClassVar[bool] = False
    deciding_variables: ClassVar[tuple[str, ...]] = ENVIRONMENT

    def __init__(
        self, program: str | None = None, workers: int | None = None, limits: Limits | None = None
    ) -> None:
        if workers is not None and workers < 1:
            raise RequestError(f"workers = {workers!r}: must be at least 1")
        self.program = self.find(program)
        self.opened_with: dict[str, Any] = {"program": self.program}
        """The options by which :meth:`fingerprint_of` knows this engine."""
        self.limits = limits or Limits()
        self.workers = workers or cores()
        self.processes = Processes()
        self._logs: dict[str, str] = {}

    @abstractmethod
    def ask_version(self) -> Provenance:
        """Return who the program is; raise EngineMissingError where it is another, or broken."""

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the absolute path of the program that is named, or of a known one."""
        if program is not None:
            return find_program(f"program {cls.name}=", program)
        for name in cls.programs:
            with suppress(RequestError):
                return find_program("program", name)
        raise EngineMissingError(cls.traits.missing(f"no {' or '.join(cls.programs)} on PATH"))

    def environment(self, folder: Path) -> Mapping[str, str] | None:  # noqa: ARG002
        """Return the environment of a process that works in a folder; None: the harness's own."""
        return None

    def identify(self) -> Provenance:
        """Return version and executable, read once."""
        return self._identity

    @cached_property
    def _identity(self) -> Provenance:
        identity = self.ask_version()
        # the version text of a program goes to terminals and pages
        version = "".join(c if c.isprintable() else "?" for c in identity.engine_version)
        return replace(identity, engine_version=version, integrator=self.traits.integrator)

    @classmethod
    def fingerprint_of(cls, **options: Any) -> Mapping[str, Any] | None:
        """Return the contents of the program and all that it runs, where that is known."""
        files = cls.installed_files(Path(cls.find(options.get("program"))))
        if not files:
            return None
        return facts(cls.name, "executable", files, cls.deciding_variables, cls.deciding(**options))

    @classmethod
    def installed_files(cls, program: Path) -> list[Path]:
        """Return the files that decide a result, the program first; none where not all are known.

        Here the program with its libraries, where that is ``self_contained``.
        """
        return program_files(program) if cls.self_contained else []

    @classmethod
    def deciding(cls, **options: Any) -> Mapping[str, str]:  # noqa: ARG003
        """Return the options, also by default, that decide a result and that no job has."""
        return {}

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return :meth:`fingerprint_of` this program, read once."""
        return self._fingerprint

    @cached_property
    def _fingerprint(self) -> Mapping[str, Any] | None:
        return self.fingerprint_of(**self.opened_with)

    def ask(
        self, words: Sequence[str], files: Mapping[str, str] | None = None
    ) -> tuple[str, Ended]:
        """Run a command once in a folder with these files; return its first output and its end."""
        with fresh_folder() as folder:
            for name, text in (files or {}).items():
                (folder / name).write_text(text, encoding="utf-8")
            ended = self.start(words, folder, ASK_SECONDS)
            return first_text(folder / "said", 100_000), ended

    def start(self, words: Sequence[str], folder: Path, seconds: float) -> Ended:
        """Run a command in a folder."""
        return self.processes.run(
            words,
            folder,
            seconds=seconds,
            memory=self.limits.memory,
            environment=self.environment(folder),
        )

    def closed_error(self) -> EngineError:
        """Return the error of a job that is given after :meth:`close`."""
        return EngineCrashError(f"{self.title} was closed")

    def close(self) -> None:
        """End what runs; whoever waits for it removes its files."""
        self.processes.close()


class ScriptedEngine(ScriptSource, ProgramEngine):
    """A code that runs scripts through its program, in as many processes as it has workers.

    ``scenes`` is the module that runs scenes, where the code takes them: its ``rules(scene)``,
    ``script(scene)`` and ``motions(program, scenes, workers=, limits=, processes=)``.
    """

    scenes: ClassVar[Any] = None

    @abstractmethod
    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:
        """Return the words that run tasks, written into a folder, in one process."""

    # ---- the form of scripts and their files

    def write(self, folder: Path, tasks: Sequence[Task]) -> None:
        """Write the scripts of a batch, by their names, and the list of its runs."""
        runs = []
        for place, task in enumerate(tasks):
            (folder / task.script.name).write_text(task.script.text, encoding="utf-8")
            series = f"{place}.csv" if task.job.sampled else ""
            runs.append({**task.values, "series": series, "results": f"{place}.txt"})
        (folder / RUNS).write_text(json.dumps(runs), encoding="utf-8")

    def shares(self, tasks: Sequence[Task]) -> list[list[int]]:
        """Return the indices of the tasks of each process: those of one script, dealt out."""
        scripts: dict[Script, list[int]] = {}
        for place, task in enumerate(tasks):
            scripts.setdefault(task.script, []).append(place)
        return [
            [same[k] for k in hand]
            for same in scripts.values()
            for hand in dealt(len(same), self.workers)
        ]

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again by hand."""
        return f"{Path(self.program).name} {task.script.name} {self.words(task)}"

    def words(self, task: Task) -> str:
        """Return the command line's words for a task: NAME=VALUE, lists without spaces."""
        return " ".join(f"{name}={str(v).replace(' ', '')}" for name, v in task.values.items())

    def table(self, series: str) -> Table:
        """Return the columns of a series: of a dump, or of a CSV."""
        read = read_dump if series.startswith("ITEM:") else read_csv
        return read(series, self.title)

    def error_of(self, ended: Ended, log: str) -> EngineError | None:  # noqa: ARG002
        """Return the error by the end of a process, or None where it ended well.

        ``log`` is that of the task it was at, empty where all had finished.
        """
        return ended.error(self.title)

    def log_of(self, folder: Path, index: int) -> str:
        """Return the log of the task of this index, nothing before it has begun."""
        return text_of(folder / f"{index}.txt")

    def read_job(self, folder: Path, index: int, task: Task, seconds: float) -> Output | None:
        """Return the output of a task that took so long, None where it has not finished.

        Raise EngineError for a bad one. A result ``seconds`` wins over the share of the process's
        wall time.
        """
        log = self.log_of(folder, index)
        if not finished(log):
            return None
        return self.output(task, log, text_of(folder / f"{index}.csv"), seconds)

    # ---- scenes

    def rules(self, scene: Scene) -> Rules:
        """Return the conventions by which a scene is run; raise Unsupported."""
        if self.scenes is None:
            return super().rules(scene)
        conventions: Rules = self.scenes.rules(scene)
        return conventions

    def motions(self, jobs: Sequence[Job]) -> list[Motion | EngineError]:
        """Return the motion of the scene of each job, or the error of its run, in order."""
        motions: list[Motion | EngineError] = self.scenes.motions(
            self.program, [self.scene_of(job) for job in jobs], workers=self.workers,
            limits=self.limits, processes=self.processes,
        )  # fmt: skip
        return motions

    def script_text(self, job: Job) -> str:
        """Return the plain script of a job: of its template, else of its scene."""
        if self.scenes is None or job.scene is None or self.has_template(job.template):
            return self.template_text(self.task(job))
        return str(self.scenes.script(self.scene_of(job)))

    def template_text(self, task: Task) -> str:
        """Return the script of a template below the command that runs it."""
        return f"# {self.command_line(task)}\n{task.script.text}"

    # ---- runs

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the scripts of jobs, and the scenes of those without, and return their outputs."""
        self.check(jobs)
        if self.processes.closed:
            return [self.closed_error() for _ in jobs]
        outcomes: dict[int, Output | EngineError] = {}
        for scripted, run in ((False, self.run_scene_jobs), (True, self._run_scripts)):
            places = [
                k for k, job in enumerate(jobs) if self.has_template(job.template) is scripted
            ]
            if places:
                outcomes.update(zip(places, run([jobs[k] for k in places]), strict=True))
        return [outcomes[place] for place in range(len(jobs))]

    def _run_scripts(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        self.identify()
        tasks = [self.task(job) for job in jobs]
        outcomes: list[Output | EngineError] = []
        for task, outcome in zip(tasks, self.execute(tasks), strict=True):
            head = f"# {self.command_line(task)}\n# sha256 of the script: {task.script.sha256}"
            log = f"{head}\n{outcome.log or f'{self.title} left no log.'}\n"
            if isinstance(outcome, EngineError):
                outcomes.append(outcome.with_log(log))
            else:
                self._logs.setdefault(task.script.name, log)
                outcomes.append(replace(outcome, log=log))
        return outcomes

    def execute(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks, shared out over processes, and return their outputs in order."""

        def write(folder: Path, some: Sequence[Task]) -> list[str]:
            self.write(folder, some)
            return self.command(folder, some)

        batches = Batches(
            title=self.title,
            write=write,
            read=self.read_job,
            error=self.error_of,
            log=self.log_of,
            environment=self.environment,
            seconds=lambda task: task.job.seconds,
        )
        return batches.run(tasks, self.workers, self.limits, self.processes, self.shares(tasks))

    def output(self, task: Task, log: str, series: str, seconds: float) -> Output:
        """Return the output of a task from its log and its series."""
        script = task.script
        provenance = replace(self.identify(), script=script.name, script_sha256=script.sha256)
        tables = {SERIES: self.table(series)} if series else {}
        output = Output(results_in(log), provenance, tables, log, seconds, self.title)
        if output.has("verdict") and output.text("verdict") == "not_a_number":
            raise EngineNaNError(f"{self.title} met a place or velocity that is not a number")
        if output.has("seconds"):
            return replace(output, seconds=output.number("seconds"))
        return output

    def logs(self) -> dict[str, str]:
        """Return, for each script, the log of the first run of it that finished."""
        return dict(self._logs)
