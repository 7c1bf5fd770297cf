"""Run scripts with any LAMMPS executable, alone or under an MPI launcher.

One process runs a batch of jobs, one after the other, so that a process start
is not paid per angle. When the process dies, the job it was at gets the error
and the rest go on in a new process.
"""

from __future__ import annotations

import re
import shlex
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from harness.engines.lammps.batch import read_batch, write_batch
from harness.engines.lammps.jobs import Job, Output
from harness.engines.lammps.read import version_in
from harness.engines.lammps.scripts import names_to_forget
from harness.engines.parallel import dealt, in_batches
from harness.engines.process import Ended, Limits, Processes, first_words
from harness.engines.programs import find_program
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMissingError,
    RequestError,
)
from harness.observables.provenance import Provenance

HELP_SECONDS = 60.0


class Executable:
    """Runner for ``lmp`` at a path, with an optional launcher such as ``mpirun -np 4``.

    Raise RequestError when the executable or the launcher is not there,
    EngineMissingError when it is not a LAMMPS with the GRANULAR package.
    """

    def __init__(self, lmp: str, launcher: str, workers: int, limits: Limits) -> None:
        self._lmp = find_program("lmp", lmp)
        self._launcher = shlex.split(launcher)
        if self._launcher:
            self._launcher[0] = find_program("mpirun", self._launcher[0])
        self._workers = 1 if self._launcher else workers
        self._limits = limits
        self._provenance = self._ask_for_help()
        self._folder = tempfile.TemporaryDirectory(prefix="dem-harness-")
        self._processes = Processes()
        if self._launcher:
            self._check_launcher()

    def identify(self) -> Provenance:
        """Return version and packages as the executable's own help names them."""
        return self._provenance

    def run(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run the jobs, in as many processes as there are workers.

        Raise RequestError for a job with the deformable law: an executable
        cannot call it.
        """
        if any(job.deformable for job in jobs):
            raise RequestError(
                "law = 'deformable' runs in LAMMPS in-process only, where the harness can give "
                "the forces: leave --lmp and --mpirun out, or choose law 'overlap'"
            )
        return in_batches(jobs, dealt(len(jobs), self._workers), self._run_batch)

    def close(self) -> None:
        """End what runs and remove the temporary files."""
        self._processes.close()
        self._folder.cleanup()

    def _run_batch(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run jobs in one process; return what the finished ones left, and one error if it died."""
        if self._processes.closed:
            return [EngineCrashError(f"LAMMPS ({self._lmp}) was closed")]
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        write_batch(jobs, folder, names_to_forget)
        quiet = ["-log", "none", "-screen", "none"]
        seconds = self._limits.seconds
        ended = self._execute(folder, quiet, seconds * len(jobs))
        return read_batch(jobs, folder, ended, who="LAMMPS", program=self._lmp, seconds=seconds)

    def _check_launcher(self) -> None:
        """Raise EngineMissingError unless the launcher starts one LAMMPS on all its ranks.

        A launcher of another MPI library than LAMMPS's starts as many separate
        LAMMPS as it has ranks, which would write over each other's files.
        """
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        (folder / "batch.in").write_text("print hello\n", encoding="utf-8")
        ended = self._execute(folder, ["-log", "none"], HELP_SECONDS)
        greetings = len(re.findall(r"^LAMMPS \(", ended.said, re.MULTILINE))
        if greetings == 1 and ended.code == 0 and not ended.timed_out:
            return
        launcher = shlex.join(self._launcher)
        if greetings > 1:
            raise EngineMissingError(
                f"--mpirun {launcher!r} started {greetings} separate LAMMPS instead of one on all "
                f"ranks: launcher and {self._lmp} belong to different MPI libraries"
            )
        reason = (
            "it gave no answer"
            if ended.timed_out
            else f"exit status {ended.code}{first_words(ended.said)}"
        )
        raise EngineMissingError(f"--mpirun {launcher!r} does not run {self._lmp}: {reason}")

    def _execute(self, folder: Path, options: Sequence[str], seconds: float) -> Ended:
        """Run ``batch.in`` under the limits."""
        command = [*self._launcher, self._lmp, "-in", "batch.in", *options]
        return self._processes.run(command, folder, seconds=seconds, memory=self._limits.memory)

    def _ask_for_help(self) -> Provenance:
        """Return what ``lmp -h`` says of version and packages."""
        try:
            answer = subprocess.run(
                [self._lmp, "-h"],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=HELP_SECONDS,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise EngineMissingError(f"--lmp {self._lmp} does not run: {error}") from None
        text = (answer.stdout + answer.stderr).decode(errors="replace")
        try:
            version = version_in(text)
        except EngineMissingError:
            raise EngineMissingError(
                f"--lmp {self._lmp} is not LAMMPS: its -h names no release{first_words(text)}"
            ) from None
        packages = _packages(text)
        if "GRANULAR" not in packages:
            raise EngineMissingError(
                f"--lmp {self._lmp} (LAMMPS {version}) was built without the GRANULAR package; "
                "it is needed for pair_style granular"
            )
        how = shlex.join(self._launcher) if self._launcher else "executable"
        return Provenance("lammps", version, packages, self._lmp, how)


def _packages(text: str) -> tuple[str, ...]:
    found = re.search(r"^Installed packages:\s*\n\s*\n((?:[A-Z0-9][A-Z0-9 \-]*\n)+)", text, re.M)
    return tuple(found.group(1).split()) if found else ()
