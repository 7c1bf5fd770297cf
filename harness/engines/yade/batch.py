"""Run generated scripts in Yade, a process for a batch of runs.

The script takes the runs as a list and writes what each left when it is over. When the
process dies, the run it was at gets the error and the rest go on in a new process.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness.engines.input_values import Values
from harness.engines.parallel import dealt, in_batches
from harness.engines.process import Limits, Processes, last_words, text_of
from harness.engines.yade.read import LAST_RESULT
from harness.engines.yade.scripts import Script
from harness.errors import EngineCrashError, EngineError, EngineOutputError

FOREIGN = ("PYTHON", "OMPI_", "PMI_", "PMIX_", "DISPLAY", "XDG_CONFIG_HOME")
"""Variables that Yade must not inherit: it has a Python of its own, and would take itself for
a rank of the launcher that the harness runs under."""


@dataclass(frozen=True)
class Job:
    """A script and the parameters of one run; whether it writes a series."""

    script: Script
    values: Values
    series: bool = True


@dataclass(frozen=True)
class Output:
    """What a finished run left: its lines RESULT, and its series or nothing."""

    results: str
    series: str


class Batches:
    """Runner for the executable ``program``, ``workers`` processes side by side."""

    def __init__(self, program: str, workers: int, limits: Limits) -> None:
        self._program, self._workers, self._limits = program, workers, limits
        self._processes = Processes()
        self._folder = tempfile.TemporaryDirectory(prefix="dem-harness-")

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run jobs of one script; return what each left, or what went wrong with it, in order."""
        return in_batches(jobs, dealt(len(jobs), self._workers), self._run_batch)

    def close(self) -> None:
        """End what runs and remove the temporary files."""
        self._processes.close()
        self._folder.cleanup()

    def _run_batch(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run jobs in one process; return what the finished ones left, and one error if it died."""
        if self._processes.closed:
            return [EngineCrashError(f"Yade ({self._program}) was closed")]
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        script = folder / jobs[0].script.name
        script.write_text(jobs[0].script.text, encoding="utf-8")
        runs = [_with_files(job, number) for number, job in enumerate(jobs)]
        (folder / "runs.json").write_text(json.dumps(runs), encoding="utf-8")
        limit = self._limits.seconds * len(jobs)
        ended = self._processes.run(
            [self._program, "-n", "-x", script.name, "runs.json"],
            folder,
            seconds=limit,
            memory=self._limits.memory,
            environment=environment(os.environ, folder),
        )
        done: list[Output | EngineError] = []
        for number, job in enumerate(jobs):
            results = text_of(folder / f"{number}.txt")
            if LAST_RESULT not in results:
                error = ended.error("Yade", limit) or EngineOutputError(
                    f"Yade ended without a result{last_words(ended.said)}"
                )
                error.log = ended.said
                done.append(error)
                break
            series = text_of(folder / f"{number}.csv") if job.series else ""
            done.append(Output(results, series))
        shutil.rmtree(folder, ignore_errors=True)
        return done


def environment(inherited: Mapping[str, str], home: Path) -> dict[str, str]:
    """Return the environment of a Yade that keeps to its own Python and writes to ``home`` only.

    Yade does not start without a HOME, and makes folders in it.
    """
    kept = {name: text for name, text in inherited.items() if not name.startswith(FOREIGN)}
    return {**kept, "HOME": str(home)}


def _with_files(job: Job, number: int) -> Values:
    """Return a job's parameters with the files that its run writes."""
    series = f"{number}.csv" if job.series else ""
    return {**job.values, "series": series, "results": f"{number}.txt"}
