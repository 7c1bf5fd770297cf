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

from harness.engines.lammps.batch import read_batch, write_batch
from harness.engines.lammps.jobs import Job, Output
from harness.engines.liggghts.scripts import all_scripts
from harness.engines.parallel import dealt, in_batches
from harness.engines.process import Ended, Limits, Processes, first_words
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMissingError,
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
        write_batch(jobs, folder, lambda _: names_to_forget())
        seconds = self._limits.seconds
        ended = self._execute(folder, seconds * len(jobs))
        return read_batch(
            jobs,
            folder,
            ended,
            who="LIGGGHTS",
            program=self._program,
            seconds=seconds,
            clean=lambda log: _STRETCH.sub("", log),
        )

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
