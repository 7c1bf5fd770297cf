"""Run the generated scripts in a Python that has Kratos, one process for a batch of runs.

Kratos is never imported into the harness's own process: it prints, and it may
crash. Each run of a batch writes its results as it ends, so a crash costs the run it
was at, and the rest go on in a new process.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from harness.engines.kratos.jobs import Job, Output
from harness.engines.kratos.read import error_of, finished, seconds_in, without_farewell
from harness.engines.kratos.scripts import words_of
from harness.engines.parallel import dealt, in_batches
from harness.engines.process import Limits, Processes, last_words, text_of
from harness.engines.programs import find_program
from harness.errors import EngineCrashError, EngineError, EngineMissingError
from harness.observables.provenance import Provenance

HELLO_SECONDS = 60.0

HELLO = """
from importlib.metadata import PackageNotFoundError, version
import KratosMultiphysics, KratosMultiphysics.DEMApplication
try:
    release = version("KratosMultiphysics")
except PackageNotFoundError:
    release = KratosMultiphysics.KratosGlobals.Kernel.Version()
print("\\nKRATOS", release)
"""


class Batches:
    """Runner for a Python at ``program``, or this one; ``workers`` processes side by side.

    ``install_hint`` tells how to get Kratos. Raise RequestError when there is no such program.
    """

    def __init__(
        self, program: str | None, install_hint: str, workers: int, limits: Limits
    ) -> None:
        self._python = sys.executable if program is None else find_program("kratos", program)
        self._install_hint, self._workers, self._limits = install_hint, workers, limits
        self._folder = tempfile.TemporaryDirectory(prefix="dem-harness-")
        self._processes = Processes()
        self._who: Provenance | None = None

    def identify(self) -> Provenance:
        """Return Kratos's version; raise EngineMissingError where this Python has none."""
        if self._who is None:
            folder = self._new_folder()
            ended = self._processes.run(
                [self._python, "-c", HELLO],
                folder,
                seconds=HELLO_SECONDS,
                memory=self._limits.memory,
            )
            words = [line.split(maxsplit=1) for line in ended.said.splitlines()]
            releases = [word[1] for word in words if len(word) == 2 and word[0] == "KRATOS"]
            if not releases or ended.code != 0:
                raise EngineMissingError(
                    f"{self._python} has no Kratos with its DEM application"
                    f"{last_words(without_farewell(ended.said))}; get it with: {self._install_hint}"
                )
            self._who = Provenance(
                "kratos", releases[-1], ("DEMApplication",), self._python, "worker"
            )
        return self._who

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the jobs, in as many processes as there are workers and scripts."""
        return in_batches(jobs, self._shares(jobs), self._run_batch)

    def close(self) -> None:
        """End what runs and remove the temporary files."""
        self._processes.close()
        self._folder.cleanup()

    def _shares(self, jobs: Sequence[Job]) -> list[list[int]]:
        """Return the jobs of each process: all of one script, dealt out over the workers."""
        by_script: dict[str, list[int]] = {}
        for index, job in enumerate(jobs):
            by_script.setdefault(job.script.sha256, []).append(index)
        return [
            [same[i] for i in hand]
            for same in by_script.values()
            for hand in dealt(len(same), self._workers)
        ]

    def _run_batch(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run jobs in one process; return what the finished ones left, and one error if it died."""
        if self._processes.closed:
            return [EngineCrashError("Kratos was closed") for _ in jobs]
        folder = self._new_folder()
        script = jobs[0].script
        (folder / script.name).write_text(script.text, encoding="utf-8")
        lines = [
            f"{words_of(job.values)} series={index}.csv results={index}.txt"
            for index, job in enumerate(jobs)
        ]
        (folder / "cases").write_text("\n".join(lines) + "\n", encoding="utf-8")
        ended = self._processes.run(
            [self._python, "-u", script.name, "--cases", "cases"],
            folder,
            seconds=self._limits.seconds * len(jobs),
            memory=self._limits.memory,
        )
        done: list[Output | EngineError] = []
        for index in range(len(jobs)):
            log, series = text_of(folder / f"{index}.txt"), text_of(folder / f"{index}.csv")
            if not finished(log):
                return [*done, error_of(ended, self._limits.seconds, self._install_hint)]
            done.append(Output(log, series, seconds_in(log)))
        return done

    def _new_folder(self) -> Path:
        return Path(tempfile.mkdtemp(dir=self._folder.name))
