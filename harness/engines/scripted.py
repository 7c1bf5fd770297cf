"""An engine that runs script files through a program: one piece of code for every such code.

To make one, subclass :class:`ScriptedEngine` beside a folder ``templates`` with a file
``<template>.<extension>.j2`` for each template of a case that the code can state, and give

- ``name``, ``traits`` (whose ``title`` messages write), ``programs`` (names on PATH, the first
  that is there is taken), ``extension`` of script files;
- ``ask_version``: who the program is, from :meth:`~ScriptedEngine.ask`;
- ``command``: the words that run a batch of tasks in a folder;
- ``write``: the files of the batch beside its scripts.

A script declares the values it takes and prints ``RESULT name = value``, ``RESULT verdict = ...``
last. The rest has defaults, for a script that has a dictionary ``PARAMETERS`` and writes the lines
of job i of a batch to ``<i>.txt`` when the job is over, and its series to ``<i>.csv``. Override

- of the scripts (:class:`~harness.engines.script.ScriptSource`): ``renders_variants``,
  ``unused_values``, ``switches``, ``jinja``, ``context``, ``literal``, ``declared``, ``settings``;
- of the program (:class:`~harness.engines.programs.ProgramEngine`): ``find``, ``self_contained``,
  ``environment``;
- of the runs: ``shares``, ``error_of``, ``log_of``, ``ranks_in``, ``read_job``, ``table``,
  ``command_line``;
  ``run_batch`` and ``execute`` for another way to run.
"""

from __future__ import annotations

import signal
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from harness.engines.batches import collect, run_in_turn
from harness.engines.contract import Job
from harness.engines.output import SERIES, Output, Table, results_in
from harness.engines.parallel import dealt, parallel_map
from harness.engines.process import Ended, signal_of, text_of
from harness.engines.programs import ProgramEngine, fresh_folder
from harness.engines.script import Task
from harness.engines.tables import read_csv
from harness.errors import EngineError


class ScriptedEngine(ProgramEngine):
    """A code that runs scripts through its program, in as many processes as it has workers."""

    # ---- what a subclass gives -------------------------------------------------------------

    @abstractmethod
    def command(self, folder: Path, tasks: Sequence[Task]) -> list[str]:
        """Return the words that run tasks, written into a folder, in one process."""

    def write(self, folder: Path, tasks: Sequence[Task]) -> None:
        """Write the files of a batch: here its scripts, by their names."""
        for script in {task.script.name: task.script for task in tasks}.values():
            (folder / script.name).write_text(script.text, encoding="utf-8")

    # ---- what it may override --------------------------------------------------------------

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

    def ranks_in(self, log: str) -> int:  # noqa: ARG002
        """Return how many MPI ranks a log speaks of."""
        return 1

    def table(self, series: str) -> Table:
        """Return the columns of a series."""
        return read_csv(series, self.title)

    def run_batch(self, tasks: Sequence[Task]) -> list[Output | EngineError]:
        """Run tasks in one process; return what those left that it got to, one at least."""
        if self.processes.closed:
            return [self.closed_error() for _ in tasks]
        with fresh_folder() as folder:
            self.write(folder, tasks)
            ended = self.start(self.command(folder, tasks), folder, self.limits.seconds)
            share = ended.seconds / len(tasks)
            return collect(
                (self.log_of(folder, index) for index in range(len(tasks))),
                lambda index: self.read_job(folder, index, tasks[index], share),
                lambda log: self._ended_by_us(ended) or self.error_of(ended, log),
                ended,
                self.title,
            )

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

    def _ended_by_us(self, ended: Ended) -> EngineError | None:
        """Return the error of a process that :meth:`close` ended, which no fault of it did."""
        ours = self.processes.closed and signal_of(ended.code) is signal.SIGKILL
        return self.closed_error() if ours else None

    def output(self, task: Task, log: str, series: str, seconds: float) -> Output:
        """Return the output of a task from its log and its series."""
        script = task.script
        who = replace(self.identify(), script=script.name, script_sha256=script.sha256)
        tables = {SERIES: self.table(series)} if series else {}
        ranks = self.ranks_in(log)
        output = Output(results_in(log), who, tables, log, seconds, self.title, ranks)
        return (
            replace(output, seconds=output.number("seconds")) if output.has("seconds") else output
        )

    def headed(self, task: Task, log: str) -> str:
        """Return a log below the command that runs the same again."""
        head = f"# {self.command_line(task)}\n# sha256 of the script: {task.script.sha256}"
        return f"{head}\n{log or f'{self.title} left no log.'}\n"

    def logs(self) -> dict[str, str]:
        """Return, for each script, the log of the first run of it that finished."""
        return dict(self._logs)
