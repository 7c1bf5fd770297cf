"""Run the scripts with a LIGGGHTS executable, a batch of them in one process.

LIGGGHTS is silent about an error where it has no log: every job writes its own. When the
process dies, the job it was at gets the error and the rest go on in a new process.
"""

from __future__ import annotations

import os
import re
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from harness.engines.lammps.jobs import Job, Output
from harness.engines.lammps.read import LAST_RESULT, error_from_text
from harness.engines.liggghts.scripts import all_scripts
from harness.engines.parallel import dealt, in_batches
from harness.engines.process import Ended, Limits, Processes, first_words, text_of
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMissingError,
    EngineTimeoutError,
)
from harness.observables.provenance import Provenance

HELP_SECONDS = 60.0
MODEL = "hooke/stiffness"
"""The one normal model whose spring and dashpot can be stated."""

ALONE = {
    "OMPI_MCA_ess_singleton_isolated": "1",
    "OMPI_MCA_pml": "ob1",
    "OMPI_MCA_btl": "self",
}
"""Open MPI for one process: no daemon that outlives it, no search for networks (0.3 s a start)."""

_STRETCH = re.compile(r"\n? +Step \n +\d+ \n +\d+ \nLoop time of .*\n")
"""What LIGGGHTS says of each of the short runs of the incline, which cannot be turned off."""


class Executable:
    """Runner for LIGGGHTS at a path; it is started without an MPI launcher.

    Raise EngineMissingError when it does not run or is not LIGGGHTS.
    """

    def __init__(self, program: str, workers: int, limits: Limits) -> None:
        self._program = program
        self._workers = workers
        self._limits = limits
        self._provenance = self._ask_for_help()
        self._folder = tempfile.TemporaryDirectory(prefix="dem-harness-")
        self._processes = Processes()

    def identify(self) -> Provenance:
        """Return the version that the executable's own help names."""
        return self._provenance

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the jobs, in as many processes as there are workers."""
        return in_batches(jobs, dealt(len(jobs), self._workers), self._run_batch)

    def close(self) -> None:
        """End what runs and remove the temporary files."""
        self._processes.close()
        self._folder.cleanup()

    def _run_batch(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run jobs in one process; return what the finished ones left, and one error if it died."""
        if self._processes.closed:
            return [EngineCrashError(f"LIGGGHTS ({self._program}) was closed")]
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        (folder / "batch.in").write_text(_batch(jobs, folder), encoding="utf-8")
        ended = self._execute(folder, self._limits.seconds * len(jobs))
        done: list[Output | EngineError] = []
        for index, job in enumerate(jobs):
            log = _STRETCH.sub("", text_of(folder / f"{index}.log"))
            if LAST_RESULT not in log:
                return [*done, self._error(log, ended)]
            series = text_of(folder / f"{index}.csv") if job.series else None
            done.append(Output(log, series, ended.seconds / len(jobs)))
        return done

    def _execute(self, folder: Path, seconds: float) -> Ended:
        """Run ``batch.in`` under the limits.

        Open MPI keeps its session files in TMPDIR, and leaves them when it is killed.
        """
        return self._processes.run(
            [self._program, "-in", "batch.in", "-log", "none", "-screen", "none"],
            folder,
            seconds=seconds,
            memory=self._limits.memory,
            environment={**os.environ, **ALONE, "TMPDIR": str(folder)},
        )

    def _error(self, log: str, ended: Ended) -> EngineError:
        """Return what the log of a job that did not finish, or its process's end, speaks of."""
        error = error_from_text(log if "ERROR" in log else ended.said, ended.code, "LIGGGHTS")
        if ended.timed_out:
            error = EngineTimeoutError(
                f"LIGGGHTS ({self._program}) did not finish within {self._limits.seconds:g} s"
            )
        error.log = "\n".join(text for text in (log, ended.said) if text)
        return error

    def _ask_for_help(self) -> Provenance:
        """Return what ``liggghts -help`` says of version and models."""
        try:
            answer = subprocess.run(
                [self._program, "-log", "none", "-help"],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=HELP_SECONDS,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise EngineMissingError(f"--liggghts {self._program} does not run: {error}") from None
        text = (answer.stdout + answer.stderr).decode(errors="replace")
        version = re.search(r"^LIGGGHTS \(Version ([^,)\n]+)", text, re.MULTILINE)
        if version is None:
            raise EngineMissingError(
                f"--liggghts {self._program} is not LIGGGHTS: its -help names no "
                f"version{first_words(text)}"
            )
        if MODEL not in text.split():
            raise EngineMissingError(
                f"--liggghts {self._program} ({version[1]}) was built without the contact "
                f"model {MODEL}"
            )
        return Provenance("liggghts", version[1], (), self._program, "executable")


def names_to_forget() -> list[str]:
    """Return the variables that an earlier run may have left.

    LIGGGHTS's ``clear`` keeps them: they would shadow defaults, or refuse another style.
    """
    return sorted(frozenset().union(*(script.names for script in all_scripts())))


def _batch(jobs: Sequence[Job], folder: Path) -> str:
    """Return the input that runs the jobs in turn, each from a clean slate."""
    lines: list[str] = []
    for index, job in enumerate(jobs):
        script = folder / f"{job.script.sha256[:16]}-{job.script.name}"
        if not script.exists():
            script.write_text(job.script.text, encoding="utf-8")
        variables = dict(job.variables)
        if job.series:
            variables |= {"series": f"{index}.csv"}
        lines += [f"log {index}.log", "clear"]
        lines += [f"variable {name} delete" for name in names_to_forget()]
        lines += [f"variable {name} index {value}" for name, value in variables.items()]
        lines.append(f"include {script.name}")
    return "\n".join(lines) + "\n"
