"""An engine that runs script files through a program: one piece of code for every such code.

To make one, subclass :class:`ScriptedEngine` beside a folder ``templates`` with a file
``<template>.<extension>.j2`` for each template of a case that the code can state, and give

- ``name``, ``traits`` (whose ``title`` messages write), ``programs`` (names on PATH, the first
  that is there is taken), ``extension`` of script files;
- :meth:`~ScriptedEngine.ask_version`: who the program is, from :meth:`~ScriptedEngine.ask`;
- :meth:`~ScriptedEngine.command`: the words that run a batch of tasks in a folder;
- :meth:`~ScriptedEngine.write`: the files of the batch beside its scripts.

A script declares the values it takes and prints ``RESULT name = value``, ``RESULT verdict = ...``
last. The rest has defaults, for a script that has a dictionary ``PARAMETERS`` and writes the lines
of job i of a batch to ``<i>.txt`` when the job is over and its series to ``<i>.csv``. Override

- ``renders_variants``: whether each variant of a template is a script of its own, or all run the
  main one with other values;
- ``unused_values``: values that no script of the engine has a use for;
- ``switches``: variables that a sampled job sets where the script declares them;
- ``jinja``, :meth:`~ScriptedEngine.context`: Jinja's options, and further names for templates;
- :meth:`~ScriptedEngine.literal`: how the code writes a value; :meth:`~ScriptedEngine.declared`:
  which variables a script's text declares;
- :meth:`~ScriptedEngine.settings`: values that the engine adds to those of a job;
- :meth:`~ScriptedEngine.shares`: which tasks run in one process, and side by side;
- :meth:`~ScriptedEngine.environment`, :meth:`~ScriptedEngine.error_of`: of the process;
- :meth:`~ScriptedEngine.log_of`, :meth:`~ScriptedEngine.read_job`, :meth:`~ScriptedEngine.table`:
  what a task left;
- :meth:`~ScriptedEngine.run_batch` or :meth:`~ScriptedEngine.execute` for another way to run.
"""

from __future__ import annotations

import shutil
import tempfile
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from harness.engines.batches import collect, run_in_turn
from harness.engines.contract import Job
from harness.engines.fingerprints import facts, program_files
from harness.engines.output import SERIES, Output, Table, results_in
from harness.engines.parallel import cores, dealt, parallel_map
from harness.engines.process import Ended, Limits, Processes, first_text, text_of
from harness.engines.programs import find_program
from harness.engines.script import ScriptSource, Task
from harness.engines.tables import read_csv
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMissingError,
    RequestError,
)
from harness.observables.provenance import Provenance

ASK_SECONDS = 60.0
NO_FILES: Mapping[str, str] = {}
FOLDER = "dem-harness-"
"""How the name of an engine's temporary folder begins."""


class ScriptedEngine(ScriptSource):
    """A code that runs scripts through ``program``, by default the first of ``programs`` on PATH.

    ``workers`` processes run side by side, as many as there are cores unless told otherwise.
    ``self_contained`` says that the program with its libraries is all that decides a result: runs
    of such a one are cached; ``keeps_finished``, that a finished run counts though its process
    fails at its end. Raise RequestError for a named program that is not there,
    EngineMissingError where none is named and there is none.
    """

    programs: ClassVar[tuple[str, ...]] = ()
    self_contained: ClassVar[bool] = False
    keeps_finished: ClassVar[bool] = False

    def __init__(
        self,
        program: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
    ) -> None:
        self.program = self.find(program)
        self.limits = limits or Limits()
        self.workers = workers or cores()
        self.processes = Processes()
        self._logs: dict[str, str] = {}

    # ---- what a subclass gives -------------------------------------------------------------

    @abstractmethod
    def ask_version(self) -> Provenance:
        """Return who the program is; raise EngineMissingError where it is another, or broken."""

    @abstractmethod
    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:
        """Return the words that run tasks, written into a folder, in one process."""

    def write(self, folder: Path, tasks: Sequence[Task]) -> None:
        """Write the files of a batch: here its scripts, by their names."""
        for script in {task.script.name: task.script for task in tasks}.values():
            (folder / script.name).write_text(script.text, encoding="utf-8")

    # ---- what it may override --------------------------------------------------------------

    @classmethod
    def find(cls, program: str | None) -> str:
        """Return the absolute path of the program that is named, or of a known one."""
        if program is not None:
            return find_program(f"program {cls.name}=", program)
        for name in cls.programs:
            try:
                return find_program("program", name)
            except RequestError:
                continue
        raise EngineMissingError(cls.traits.missing(f"no {' or '.join(cls.programs)} on PATH"))

    def shares(self, tasks: Sequence[Task]) -> list[list[int]]:
        """Return the indices of the tasks of each process: those of one script, dealt out."""
        scripts: dict[str, list[int]] = {}
        for index, task in enumerate(tasks):
            scripts.setdefault(task.script.sha256, []).append(index)
        return [
            [same[i] for i in hand]
            for same in scripts.values()
            for hand in dealt(len(same), self.workers)
        ]

    def environment(self, folder: Path) -> Mapping[str, str] | None:  # noqa: ARG002
        """Return the environment of a process that works in a folder; None: the harness's own."""
        return None

    def command_line(self, task: Task) -> str:
        """Return the command that runs a task again by hand."""
        words = " ".join(f"{name}={self.literal(value)}" for name, value in task.values.items())
        return f"{Path(self.program).name} {task.script.name} {words}"

    def error_of(self, ended: Ended, log: str) -> EngineError | None:  # noqa: ARG002
        """Return the error that the end of a process speaks of, or None where it ended well.

        ``log`` is that of the task it was at, empty where all had finished.
        """
        return ended.error(self.title, self.limits.seconds)

    def log_of(self, folder: Path, index: int) -> str:
        """Return what the task of this index left, nothing before it has begun."""
        return text_of(folder / f"{index}.txt")

    def read_job(self, folder: Path, index: int, task: Task, seconds: float) -> Output:
        """Return the output of a finished task that took so long; raise EngineError for a bad one.

        A result ``seconds`` wins over the share of the process's wall time.
        """
        series = folder / f"{index}.csv"
        return self.output(task, self.log_of(folder, index), text_of(series), seconds)

    def table(self, series: str) -> Table:
        """Return the columns of a series."""
        return read_csv(series, self.title)

    def run_batch(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks in one process; return what those left that it got to, one at least."""
        if self.processes.closed:
            return [self.closed_error() for _ in tasks]
        folder = self.new_folder()
        try:
            self.write(folder, tasks)
            ended = self.processes.run(
                self.command(folder, tasks),
                folder,
                seconds=self.limits.seconds,
                memory=self.limits.memory,
                environment=self.environment(folder),
                progress=lambda: len(list(folder.iterdir())),
            )
            share = ended.seconds / len(tasks)
            return collect(
                [self.log_of(folder, index) for index in range(len(tasks))],
                lambda index: self.read_job(folder, index, tasks[index], share),
                lambda log: self.error_of(ended, log),
                ended,
                self.title,
                keeps_finished=self.keeps_finished,
            )
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def execute(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks, shared out over processes, and return their outputs in order."""
        results: dict[int, Output | EngineError] = {}

        def serve(share: Sequence[int]) -> None:
            results.update(
                zip(share, run_in_turn([tasks[i] for i in share], self.run_batch), strict=True)
            )

        parallel_map(serve, self.shares(tasks), self.workers)
        return [results[index] for index in range(len(tasks))]

    # ---- what every one does ---------------------------------------------------------------

    def identify(self) -> Provenance:
        """Return version and executable, asked once."""
        return self._identity

    @cached_property
    def _identity(self) -> Provenance:
        return replace(self.ask_version(), integrator=self.traits.integrator)

    @classmethod
    def fingerprint_of(cls, **options: Any) -> Mapping[str, Any] | None:
        """Return the contents of the program and its libraries, where they are all there is."""
        program = options.get("program")
        files = program_files(Path(cls.find(program))) if cls.self_contained else []
        return facts(cls.name, "executable", files) if files else None

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return :meth:`fingerprint_of` this program, read once."""
        return self._fingerprint

    @cached_property
    def _fingerprint(self) -> Mapping[str, Any] | None:
        return self.fingerprint_of(program=self.program)

    def ask(self, words: Sequence[str], files: Mapping[str, str] = NO_FILES) -> tuple[str, Ended]:
        """Run a command once, beside these files; return what it says first and how it ended."""
        with tempfile.TemporaryDirectory(prefix=FOLDER) as home:
            folder = Path(home)
            for name, text in files.items():
                (folder / name).write_text(text, encoding="utf-8")
            ended = self.processes.run(
                words,
                folder,
                seconds=ASK_SECONDS,
                memory=self.limits.memory,
                environment=self.environment(folder),
            )
            return first_text(folder / "said", 100_000), ended

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the scripts of jobs, and return their outputs in order."""
        self.check(jobs)
        if not jobs:
            return []
        if self.processes.closed:
            return [self.closed_error() for _ in jobs]
        self.identify()
        tasks = [self.task(job) for job in jobs]
        outputs: list[Output | EngineError] = []
        for task, output in zip(tasks, self.execute(tasks), strict=True):
            log = self.headed(task, output.log)
            if isinstance(output, EngineError):
                output.log = log
                outputs.append(output)
            else:
                self._logs.setdefault(task.script.name, log)
                outputs.append(replace(output, log=log))
        return outputs

    def output(self, task: Task, log: str, series: str, seconds: float) -> Output:
        """Return the output of a task from its log and its series."""
        results = results_in(log)
        told = dict(results).get("seconds")
        script = task.script
        return Output(
            results,
            replace(self.identify(), script=script.name, script_sha256=script.sha256),
            {SERIES: self.table(series)} if series else {},
            log,
            seconds if told is None else float(told),
            self.title,
        )

    def headed(self, task: Task, log: str) -> str:
        """Return a log below the command that runs the same again."""
        head = f"# {self.command_line(task)}\n# sha256 of the script: {task.script.sha256}"
        return f"{head}\n{log or f'{self.title} left no log.'}\n"

    def logs(self) -> dict[str, str]:
        """Return, for each script, the log of the first run of it that finished."""
        return dict(self._logs)

    @cached_property
    def _folder(self) -> tempfile.TemporaryDirectory[str]:
        return tempfile.TemporaryDirectory(prefix=FOLDER)

    def new_folder(self) -> Path:
        """Return a fresh folder, removed with the engine at the latest."""
        return Path(tempfile.mkdtemp(dir=self._folder.name))

    def closed_error(self) -> EngineError:
        """Return the error of a job that is given after :meth:`close`."""
        return EngineCrashError(f"{self.title} was closed")

    def close(self) -> None:
        """End what runs and remove the temporary files."""
        self.processes.close()
        if "_folder" in vars(self):
            self._folder.cleanup()
