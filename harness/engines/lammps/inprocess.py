"""Run scripts in LAMMPS as a library, in worker processes that are kept for many runs."""

from __future__ import annotations

import queue
from collections.abc import Sequence
from contextlib import ExitStack

from harness.engines.batches import each_alone
from harness.engines.lammps.worker_process import Left, Order, Worker
from harness.engines.process import Limits
from harness.engines.programs import fresh_folder
from harness.errors import EngineCrashError, EngineError
from harness.observables.provenance import Provenance


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

    def run(self, jobs: Sequence[Order]) -> list[Left | EngineError]:
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
