"""Work elsewhere: jobs in an executor, cases in copies of this process.

A worker of a ``concurrent.futures.Executor``, or of a Dask cluster, opens an engine once and keeps
it open. What is done is kept in the cache of the process that started the command; a worker that is
lost costs the jobs it had.

A verification is mostly Python, which uses one core of a process. So copies of the process, made by
fork, verify some of the cases.
"""

from __future__ import annotations

import asyncio
import atexit
import os
import platform
import shutil
import signal
import subprocess
import threading
import warnings
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, as_completed
from concurrent.futures import ThreadPoolExecutor as Threads
from contextlib import closing, contextmanager, suppress
from functools import partial
from importlib import import_module
from multiprocessing import get_context
from multiprocessing.connection import Connection, Pipe
from typing import Any, Generic, NamedTuple, Self, TypeVar

from harness.engines.base import Engine, Job, Output
from harness.engines.process import way_of_death
from harness.engines.registry import open_engine
from harness.errors import EngineCrashError, EngineError, HarnessError, RequestError
from harness.store.cache import SOURCES, Outcomes, key_of, opened, source_digest, versions
from harness.workflows import Progress

PIECES = 128  # into which a batch is cut, for workers of any number and speed
LARGEST_PIECE = 32  # jobs that are lost with a worker, at most
CONNECT_SECONDS = 10.0
SUBMIT_SECONDS = 60.0  # for sbatch to check the job of a worker
SLURM, SLURM_JOBS = "slurm", 8
IDLE_SECONDS = 60  # until a job of SLURM without runs is ended: another one may have to queue
MOST_CHARACTERS = 200  # of what a library reports
LOST = "lost with its worker or the scheduler: the same command runs it again"
LOSSES = ("KilledWorker", "FutureCancelledError")  # exceptions of Dask
PLACE = 2  # bytes of a place in a queue
CLEANING_SECONDS = 2.0  # that a copy has to close its engines
Item = TypeVar("Item")
Result = TypeVar("Result")


@contextmanager
def opened_on(executor: Executor, name: str) -> Iterator[Engine]:
    """Yield an engine whose jobs run in an executor and are kept in this process's cache."""
    with opened(name, remote=partial(remote_outcomes, executor)) as engine:
        yield engine


def remote_outcomes(
    executor: Executor, engine: Engine, name: str, options: Mapping[str, Any], jobs: Sequence[Job]
) -> Outcomes:
    """Yield the place and the outcome of each job as soon as its piece is done by a worker.

    ``name`` and ``options`` open the engine in a worker. One whose programs, packages or source
    differ from those of ``engine`` runs nothing: its results would be kept as those of others.
    """
    size = max(1, min(LARGEST_PIECE, len(jobs) // PIECES))
    firsts, facts = range(0, len(jobs), size), identity(engine)
    calls = [(name, options, facts, jobs[first : first + size]) for first in firsts]
    for number, result in completed(executor, run_jobs, calls):
        count = len(calls[number][-1])
        outcomes = [result] * count if isinstance(result, EngineError) else result
        yield from zip(range(firsts[number], firsts[number] + count), outcomes, strict=True)


def completed(
    executor: Executor, function: Callable[..., Result], calls: Sequence[tuple[Any, ...]]
) -> Iterator[tuple[int, Result | EngineError]]:
    """Yield the number and the result of each call as soon as it is over, in any order.

    The result of a call that was lost or raised is an EngineError. Calls that have not begun are
    cancelled where the caller stops early.
    """
    futures: dict[Future[Result], int] = {}
    try:
        for number, arguments in enumerate(calls):
            try:
                futures[executor.submit(function, *arguments)] = number
            except Exception as error:  # of an executor that is broken or closed
                yield number, EngineCrashError(f"no worker took it: {_one_line(error)}")
        for future in as_completed(futures):
            number = futures.pop(future)  # what is done need not stay in memory
            try:
                yield number, future.result()
            except Exception as error:  # of Dask, of pickling, of an engine of another package
                is_lost = isinstance(error, CancelledError | BrokenExecutor)
                is_lost |= type(error).__name__ in LOSSES
                text = LOST if is_lost else f"failed on its worker: {_one_line(error)}"
                yield number, EngineCrashError(text)
    finally:
        for future in futures:
            future.cancel()


def _one_line(error: BaseException) -> str:
    return (" ".join(str(error).split()) or type(error).__name__)[:MOST_CHARACTERS]


# ---- in a worker


def identity(engine: Engine) -> dict[str, Any]:
    """Return the facts that decide an engine's results in this process, by name; no paths."""
    facts = dict(engine.fingerprint() or {"version": engine.identify().engine_version})
    facts.pop("program", None)  # the path
    return {
        "program of the engine": key_of(facts),
        "source of dem-harness": source_digest(*SOURCES),
        **versions("numpy", "pandas"),
    }


_open_engines: dict[str, Engine] = {}  # of a worker process, by what opens them
_opening_lock = threading.Lock()  # a worker may run jobs in several threads


def run_jobs(
    name: str, options: Mapping[str, Any], expected: Mapping[str, Any], jobs: Sequence[Job]
) -> list[Output | EngineError]:
    """Return the outcomes of jobs in an engine of this process, which stays open.

    ``expected`` is its identity where the command runs.
    """
    try:
        with _opening_lock:
            engine = _opened(name, options, expected)
        return engine.run(jobs)
    except HarnessError as error:
        where = f"engine {name!r} on worker {platform.node()}"
        return [EngineCrashError(f"{where}: {error}")] * len(jobs)


def _opened(name: str, options: Mapping[str, Any], expected: Mapping[str, Any]) -> Engine:
    key = repr((name, options, expected))
    if key not in _open_engines:
        engine = open_engine(name, options=options)
        facts = identity(engine)
        if other := [part for part, value in expected.items() if facts[part] != value]:
            engine.close()
            raise RequestError(f"not the same here and where the command runs: {', '.join(other)}")
        if not _open_engines:
            atexit.register(_close)
        _open_engines[key] = engine
    return _open_engines[key]


def _close() -> None:
    while _open_engines:
        _open_engines.popitem()[1].close()


# ---- Dask


@contextmanager
def dask_executor(
    cluster: str, note: Callable[[str], object] = lambda _: None
) -> Iterator[Executor]:
    """Yield an executor of a Dask cluster: an address, ``slurm``, or ``slurm:JOBS``.

    SLURM is given at most 8 jobs, or so many; all else is in the user's ``jobqueue.yaml``.
    ``note`` is called where no worker is there yet. Raise RequestError where Dask is not installed,
    nobody answers, or SLURM refuses the job of a worker.
    """
    options = {"timeout": CONNECT_SECONDS, "set_as_default": False}
    client = partial(_imported("distributed", "Client"), **options)
    if cluster.partition(":")[0] == SLURM:
        with _slurm_cluster(cluster) as jobs, client(jobs) as connected:
            yield connected.get_executor(pure=False)
        return
    if not _workers_at(cluster):
        note(f"--dask {cluster}: no worker is there yet; runs wait for one")
    with client(cluster) as connected:
        yield connected.get_executor(pure=False)


def _workers_at(address: str) -> int:
    """Return the number of workers of a scheduler; raise RequestError where none answers.

    A client of Dask hangs at an address that is none.
    """
    rpc = _imported("distributed", "rpc")

    async def identify() -> Any:
        async with rpc(address, timeout=CONNECT_SECONDS) as scheduler:
            return await asyncio.wait_for(scheduler.identity(), CONNECT_SECONDS)

    try:
        with Threads(1) as thread:  # a notebook's own thread has a loop that runs
            answer = thread.submit(asyncio.run, identify()).result()
        if answer["type"] == "Scheduler":
            return len(answer["workers"])
        reason = f"a {str(answer['type']).lower()} does"
    except Exception as error:  # whatever an address that is none, or another program, leads to
        reason = _one_line(error)
    raise RequestError(
        f"--dask {address}: no scheduler answers there ({reason}); must be the address of one, as "
        f"tcp://head:8786, or {SLURM}"
    )


@contextmanager
def _slurm_cluster(name: str) -> Iterator[Any]:
    """Yield a cluster of SLURM jobs, which begin with the runs and end after them."""
    jobs = str(SLURM_JOBS) if name == SLURM else name.removeprefix(f"{SLURM}:")
    if not (jobs.isascii() and jobs.isdigit() and 1 <= int(jobs) <= 10_000):
        raise RequestError(f"--dask {name}: must be {SLURM}:JOBS, from 1 to 10000 jobs")
    make = _imported("dask_jobqueue", "SLURMCluster")
    if shutil.which("sbatch") is None:
        raise RequestError(f"--dask {SLURM}: there is no sbatch on the path")
    try:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "Port .* is already in use")  # of the dashboard
            cluster = make()
    except (OSError, ValueError, RuntimeError) as error:
        raise RequestError(f"--dask {SLURM}: jobqueue.yaml: {_one_line(error)}") from None
    with cluster:
        _check_job(cluster.job_script())
        cluster.adapt(minimum=0, maximum_jobs=int(jobs), wait_count=IDLE_SECONDS, interval="1s")
        yield cluster


def _check_job(script: str) -> None:
    """Raise RequestError where sbatch refuses the job of a worker, which Dask would repeat."""
    command, text = ["sbatch", "--test-only"], script.encode()
    try:
        subprocess.run(command, input=text, capture_output=True, timeout=SUBMIT_SECONDS, check=True)
    except (OSError, subprocess.SubprocessError) as error:
        words = (getattr(error, "stderr", None) or str(error).encode()).decode(errors="replace")
        reason = " ".join(words.split())[:MOST_CHARACTERS]
        raise RequestError(
            f"--dask {SLURM}: sbatch refuses a job as in jobqueue.yaml: {reason}"
        ) from None


def _imported(module: str, name: str) -> Callable[..., Any]:
    try:
        member: Callable[..., Any] = getattr(import_module(module), name)
    except ImportError as error:
        install = "pip install 'dem-harness[dask]'"
        raise RequestError(f"--dask: {error.name} is not installed: {install}") from None
    return member


# ---- copies of this process


class Queue(Generic[Item]):
    """Items that this process and its copies take, each item once, as they come to them."""

    def __init__(self, items: Sequence[Item]) -> None:
        self._items = items
        self._places, source = os.pipe()
        with os.fdopen(source, "wb") as file:
            file.write(b"".join(place.to_bytes(PLACE, "big") for place in range(len(items))))

    def __iter__(self) -> Iterator[Item]:
        while place := os.read(self._places, PLACE):
            yield self._items[int.from_bytes(place, "big")]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._places)


class Copy:
    """A copy of this process in which a generator runs: it yields answers, and is sent orders.

    ``work`` makes the generator, of a function for its progress, which calls ``progress`` here.
    """

    def __init__(
        self, work: Callable[[Progress], Generator[Any, Any, None]], progress: Progress
    ) -> None:
        self._progress = progress
        self._link, theirs = Pipe()
        with theirs:
            self._process = get_context("fork").Process(
                target=_serve, args=(work, theirs, self._link)
            )
            self._process.start()

    def send(self, order: Any) -> None:
        """Send the next order. Raise HarnessError where the copy died."""
        try:
            self._link.send(order)
        except OSError:
            raise self._death() from None

    def receive(self) -> Any:
        """Return the next answer; raise what the generator raised, HarnessError if it died."""
        while True:
            try:
                answer = self._link.recv()
            except (EOFError, OSError):
                raise self._death() from None
            if isinstance(answer, BaseException):
                raise answer
            if not isinstance(answer, _Progress):
                return answer
            self._progress(*answer)

    def _death(self) -> HarnessError:
        self._process.join(CLEANING_SECONDS)
        how = way_of_death(self._process.exitcode or 0)
        return HarnessError(f"a process that verifies some of the cases died: {how}")

    def close(self) -> None:
        """Let the copy close what it has opened, and end."""
        self._link.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, error: object, *_: object) -> None:
        if error is not None:
            self._process.terminate()
        else:
            self.close()
        self._process.join(CLEANING_SECONDS)
        self._process.kill()
        self._link.close()


class _Progress(NamedTuple):
    stage: str
    done: int
    total: int


def _serve(
    work: Callable[[Progress], Generator[Any, Any, None]], link: Connection, theirs: Connection
) -> None:
    theirs.close()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the process that made the copy ends it
    generator = work(lambda *parts: link.send(_Progress(*parts)))
    with suppress(KeyboardInterrupt), closing(generator):
        try:
            answer = next(generator)
            while True:
                link.send(answer)
                answer = generator.send(link.recv())
        except (StopIteration, EOFError):
            pass  # nobody wants more
        except Exception as error:
            with suppress(OSError):
                link.send(error)
