"""Jobs on other processes and machines: any ``concurrent.futures.Executor``, or a Dask cluster.

An executor's processes open the engine once each, and keep it open. A worker that is lost costs
the jobs it had; what is done is in the cache of the process that started the command.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from harness.engines.contract import Engine, Job, Output
from harness.engines.registry import open_engine
from harness.errors import EngineCrashError, EngineError, HarnessError, RequestError

if TYPE_CHECKING:
    from harness.observables.provenance import Provenance

CHUNKS = 64  # pieces into which a batch is cut, for workers of any number and speed
LARGEST_CHUNK = 32  # jobs that are lost with a worker, at most
CONNECT_SECONDS = 10.0
SLURM = "slurm"
Outcome = Output | EngineError


class ExecutorEngine(Engine):
    """An engine whose jobs run in the processes of an executor.

    ``local`` answers all that needs no run; ``name`` and ``options`` open the engine elsewhere.
    """

    def __init__(
        self, local: Engine, executor: Executor, name: str, options: Mapping[str, Any]
    ) -> None:
        self.traits = local.traits
        self._local, self._executor = local, executor
        self._opening = (name, dict(options))

    def __getattribute__(self, attribute: str) -> Any:
        """Return the attribute of the local engine, but for runs."""
        if attribute in _OWN or attribute.startswith("__"):
            return object.__getattribute__(self, attribute)
        return getattr(object.__getattribute__(self, "_local"), attribute)

    def identify(self) -> Provenance:
        """Return who the local engine is."""
        return self._local.identify()

    def run(self, jobs: Sequence[Job]) -> list[Outcome]:
        """Return the outcomes of jobs, in order."""
        outcomes = dict(self.outcomes(jobs))
        return [outcomes[place] for place in range(len(jobs))]

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        """Yield the place and the outcome of each job as soon as its chunk is done."""
        self._local.check(jobs)
        size = max(1, min(LARGEST_CHUNK, len(jobs) // CHUNKS))
        places = [range(first, min(first + size, len(jobs))) for first in range(0, len(jobs), size)]
        futures = {
            self._executor.submit(run_jobs, *self._opening, [jobs[i] for i in chunk]): chunk
            for chunk in places
        }
        for future in as_completed(futures):
            try:
                found = future.result()
            except Exception as error:  # an executor reports a lost worker in its own words
                lost = EngineCrashError(f"its worker was lost: {' '.join(str(error).split())}")
                found = [lost] * len(futures[future])
            yield from zip(futures[future], found, strict=True)


_OWN = frozenset(
    ("identify", "run", "outcomes", "traits", "pace", "_local", "_executor", "_opening")
)
_OPEN: dict[str, Engine] = {}  # engines of a worker process, by what opens them


def run_jobs(name: str, options: Mapping[str, Any], jobs: Sequence[Job]) -> list[Outcome]:
    """Return the outcomes of jobs in an engine of this process, which stays open."""
    key = repr((name, sorted(options.items(), key=str)))
    if key not in _OPEN:
        if not _OPEN:
            atexit.register(_close)
        try:
            _OPEN[key] = open_engine(name, options=options)
        except HarnessError as error:
            return [EngineError(f"engine {name!r} on a worker: {error}")] * len(jobs)
    return _OPEN[key].run(jobs)


def _close() -> None:
    while _OPEN:
        _OPEN.popitem()[1].close()


@contextmanager
def dask_executor(cluster: str, workers: int = 8) -> Iterator[Executor]:
    """Yield an executor of a Dask cluster: an address, or ``slurm`` for dask-jobqueue.

    ``workers`` is the number of jobs that SLURM is given at most; all else is in the user's
    ``jobqueue.yaml``. Raise RequestError where Dask is not installed or nobody answers.
    """
    client_of = _slurm_client if cluster == SLURM else _client
    client = client_of(cluster, workers)
    try:
        yield client.get_executor(pure=False)
    finally:
        client.close()


def _client(address: str, _: int) -> Any:
    client = _imported("distributed", "Client")
    try:
        return client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise RequestError(
            f"--dask {address}: no scheduler answers there ({reason}); must be the address of one, "
            f"as tcp://head:8786, or {SLURM}"
        ) from None


def _slurm_client(_: str, workers: int) -> Any:
    cluster_of = _imported("dask_jobqueue", "SLURMCluster")
    try:
        cluster = cluster_of()
        cluster.adapt(minimum=0, maximum_jobs=workers)
    except (OSError, ValueError, RuntimeError) as error:
        raise RequestError(f"--dask {SLURM}: {' '.join(str(error).split())}") from None
    return _imported("distributed", "Client")(cluster, set_as_default=False)


def _imported(module: str, name: str) -> Callable[..., Any]:
    from importlib import import_module

    try:
        found: Callable[..., Any] = getattr(import_module(module), name)
    except ImportError as error:
        install = "pip install 'dem-harness[dask]'"
        raise RequestError(f"--dask: {error.name} is not installed: {install}") from None
    return found
