"""Run scripts with any LAMMPS executable, alone or under an MPI launcher.

One process runs a batch of jobs, one after the other, so that a process start
is not paid per angle. When the process dies, the job it was at gets the error
and the rest go on in a new process.
"""

from __future__ import annotations

import contextlib
import os
import re
import shlex
import signal
import subprocess
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from harness.engines.lammps.jobs import Job, Limits, Output
from harness.engines.lammps.programs import find_program
from harness.engines.lammps.read import LAST_RESULT, error_from_text, version_in
from harness.engines.lammps.scripts import names_to_forget
from harness.engines.parallel import side_by_side
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMissingError,
    EngineTimeoutError,
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
        self._live: set[subprocess.Popen[bytes]] = set()
        self._closed = False
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
        count = max(1, min(self._workers, len(jobs)))
        batches = [list(range(first, len(jobs), count)) for first in range(count)]
        outputs: dict[int, Output | EngineError] = {}

        def serve(batch: list[int]) -> None:
            while batch:
                done = self._run_batch([jobs[index] for index in batch])
                outputs.update(zip(batch, done, strict=False))
                del batch[: len(done)]

        side_by_side(serve, batches, count)
        return [outputs[index] for index in range(len(jobs))]

    def close(self) -> None:
        """End what runs and remove the temporary files."""
        self._closed = True
        for process in list(self._live):
            _kill(process)
        self._folder.cleanup()

    def _run_batch(self, jobs: Sequence[Job]) -> list[Output | EngineError]:
        """Run jobs in one process; return what the finished ones left, and one error if it died."""
        if self._closed:
            return [EngineCrashError(f"LAMMPS ({self._lmp}) was closed")]
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        (folder / "batch.in").write_text(_batch(jobs, folder), encoding="utf-8")
        start = time.monotonic()
        quiet = ["-log", "none", "-screen", "none"]
        said, code, timed_out = self._execute(folder, quiet, self._limits.seconds * len(jobs))
        share = (time.monotonic() - start) / len(jobs)
        done: list[Output | EngineError] = []
        for index, job in enumerate(jobs):
            log = _text(folder / f"{index}.log")
            if LAST_RESULT not in log:
                error = error_from_text(log if "ERROR" in log else said, code)
                if timed_out:
                    error = EngineTimeoutError(
                        f"LAMMPS ({self._lmp}) did not finish within {self._limits.seconds:g} s"
                    )
                error.log = "\n".join(text for text in (log, said) if text)
                return [*done, error]
            done.append(Output(log, _text(folder / f"{index}.csv") if job.series else None, share))
        return done

    def _check_launcher(self) -> None:
        """Raise EngineMissingError unless the launcher starts one LAMMPS on all its ranks.

        A launcher of another MPI library than LAMMPS's starts as many separate
        LAMMPS as it has ranks, which would write over each other's files.
        """
        folder = Path(tempfile.mkdtemp(dir=self._folder.name))
        (folder / "batch.in").write_text("print hello\n", encoding="utf-8")
        said, code, timed_out = self._execute(folder, ["-log", "none"], HELP_SECONDS)
        greetings = len(re.findall(r"^LAMMPS \(", said, re.MULTILINE))
        if greetings == 1 and code == 0 and not timed_out:
            return
        launcher = shlex.join(self._launcher)
        if greetings > 1:
            raise EngineMissingError(
                f"--mpirun {launcher!r} started {greetings} separate LAMMPS instead of one on all "
                f"ranks: launcher and {self._lmp} belong to different MPI libraries"
            )
        reason = "it gave no answer" if timed_out else f"exit status {code}{_first_line(said)}"
        raise EngineMissingError(f"--mpirun {launcher!r} does not run {self._lmp}: {reason}")

    def _execute(
        self, folder: Path, options: Sequence[str], seconds: float
    ) -> tuple[str, int, bool]:
        """Run ``batch.in`` under the limits; return its words, its exit status, and if it hung."""
        command = [*self._launcher, self._lmp, "-in", "batch.in", *options]
        with (folder / "said").open("wb") as said:
            process = subprocess.Popen(
                _with_memory_limit(command, self._limits.memory),
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=subprocess.STDOUT,
                cwd=folder,
                env={**os.environ, "OMP_NUM_THREADS": "1"},
                start_new_session=True,
            )
            self._live.add(process)
            timed_out = False
            try:
                process.wait(seconds)
            except subprocess.TimeoutExpired:
                timed_out = True
            finally:
                # also when the harness is interrupted
                _kill(process)
                self._live.discard(process)
        return _text(folder / "said")[-4000:], process.returncode, timed_out

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
                f"--lmp {self._lmp} is not LAMMPS: its -h names no release{_first_line(text)}"
            ) from None
        packages = _packages(text)
        if "GRANULAR" not in packages:
            raise EngineMissingError(
                f"--lmp {self._lmp} (LAMMPS {version}) was built without the GRANULAR package; "
                "it is needed for pair_style granular"
            )
        how = shlex.join(self._launcher) if self._launcher else "executable"
        return Provenance("lammps", version, packages, self._lmp, how)


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
        lines += [f"variable {name} delete" for name in names_to_forget(job.script)]
        lines += [f"variable {name} index {value}" for name, value in variables.items()]
        lines.append(f"include {script.name}")
    return "\n".join(lines) + "\n"


def _packages(text: str) -> tuple[str, ...]:
    found = re.search(r"^Installed packages:\s*\n\s*\n((?:[A-Z0-9][A-Z0-9 \-]*\n)+)", text, re.M)
    return tuple(found.group(1).split()) if found else ()


def _with_memory_limit(command: Sequence[str], limit: int) -> list[str]:
    """Return the command under a bound on its address space, which its children inherit."""
    return ["sh", "-c", 'ulimit -v "$0" && exec "$@"', str(limit // 1024), *command]


def _kill(process: subprocess.Popen[bytes]) -> None:
    """End a process that still runs, and the ranks of its launcher with it."""
    if process.poll() is None:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8", errors="replace") if path.exists() else ""


def _first_line(text: str) -> str:
    lines = text.strip().splitlines()
    return f" (it says: {lines[0][:120]})" if lines else ""
