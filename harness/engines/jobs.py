"""One way to run many: several in a process, processes side by side, the rest after a crash again.

An item (a script or a scene) that crashes, hangs or is refused ends its process: it has failed, and
those after it run in another one.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Generic, TypeVar

from harness.engines.process import Ended, Limits, Processes, fresh_folder, last_words, signal_of
from harness.errors import EngineCrashError, EngineError, EngineOutputError, EngineTimeoutError

Item = TypeVar("Item")
Result = TypeVar("Result")
Places = Sequence[int]

BATCH_SECONDS = 10.0  # what is lost of a batch after kill -9 takes no longer


@dataclass(frozen=True, kw_only=True)
class Batches(Generic[Item, Result]):
    """A code that runs the items of a folder, in order, in one process.

    ``write`` writes the files of items into a folder and returns the command. ``read`` returns the
    result of an item by its place and its share of the wall time [s], None where the process did
    not get so far; it raises EngineError for a bad one. ``error`` returns the error by the end of
    a process and the log of the item that it was at (empty: of none), None where it ended well.
    ``log`` returns the log of an item, ``seconds`` its expected time [s] where that is long.
    """

    title: str
    write: Callable[[Path, Sequence[Item]], Sequence[str]]
    read: Callable[[Path, int, Item, float], Result | None]
    error: Callable[[Ended, str], EngineError | None]
    log: Callable[[Path, int], str] = lambda folder, place: ""  # noqa: ARG005
    environment: Callable[[Path], Mapping[str, str] | None] = lambda folder: None  # noqa: ARG005
    seconds: Callable[[Item], float] = lambda item: 0.0  # noqa: ARG005

    def run(
        self,
        items: Sequence[Item],
        workers: int | None = None,
        limits: Limits | None = None,
        processes: Processes | None = None,
        shares: Sequence[Places] | None = None,
    ) -> list[Result | EngineError]:
        """Return the result of each item, or the error of its run, in order.

        ``workers`` processes run side by side, by default as many as there are cores; each has
        ``limits.seconds`` from one result to the next. ``shares`` are the places of items that
        share processes; unless given all are dealt out. ``processes`` can be closed from elsewhere.
        """
        hands, limits, processes = workers or cores(), limits or Limits(), processes or Processes()
        chosen = dealt(len(items), hands) if shares is None else shares

        def run_share(share: Places) -> list[tuple[int, Result | EngineError]]:
            outcomes = self._in_turn([items[place] for place in share], limits, processes)
            return [*zip(share, outcomes, strict=True)]

        outcomes = dict(chain(*parallel_map(run_share, chosen if items else (), hands)))
        return [outcomes[place] for place in range(len(items))]

    def _in_turn(
        self, items: Sequence[Item], limits: Limits, processes: Processes
    ) -> list[Result | EngineError]:
        """Run items in as many processes as needed.

        After two in a row that hang at their first item the rest is not run: each would take the
        time limit.
        """
        done: list[Result | EngineError] = []
        hung = False
        while len(done) < len(items):
            batch = self._process(items[len(done) :], limits, processes)
            done += batch
            hangs = isinstance(batch[-1], EngineTimeoutError)
            if hangs and hung and len(batch) == 1:
                message = f"{batch[-1]}; not run after two that hung"
                done += [EngineTimeoutError(message) for _ in items[len(done) :]]
            hung = hangs
        return done

    def _process(
        self, items: Sequence[Item], limits: Limits, processes: Processes
    ) -> list[Result | EngineError]:
        """Return the outcomes of the items that one process got to, at least of the first."""
        closed = EngineCrashError(f"{self.title} was closed")
        if processes.closed:
            return [closed for _ in items]
        with fresh_folder() as folder:
            ended = processes.run(
                self.write(folder, items),
                folder,
                seconds=limits.time_for(sum(map(self.seconds, items))),
                memory=limits.memory,
                environment=self.environment(folder),
            )
            outcomes: list[Result | EngineError] = []
            for place, item in enumerate(items):
                try:
                    result = self.read(folder, place, item, ended.seconds / len(items))
                except EngineError as error:
                    outcomes.append(error.with_log(self.log(folder, place) or ended.output))
                    continue
                if result is None:
                    log = self.log(folder, place)
                    killed = processes.closed and signal_of(ended.code) is signal.SIGKILL
                    failure = closed if killed else self._failure(ended, log)
                    texts = dict.fromkeys(filter(None, (log, ended.output)))
                    return [*outcomes, failure.with_log("\n".join(texts))]
                outcomes.append(result)
            if death := self.error(ended, ""):  # its last result may be spoiled
                late = EngineCrashError(f"{death}, after its results were written")
                outcomes[-1] = late.with_log(self.log(folder, len(items) - 1) or ended.output)
            return outcomes

    def _failure(self, ended: Ended, log: str) -> EngineError:
        words = f"{self.title} ended without a result{last_words(ended.output)}"
        return self.error(ended, log) or EngineOutputError(words)


def in_batches(
    items: Sequence[Item], run: Callable[[Sequence[Item]], list[Result]], size: int
) -> Iterator[tuple[int, Result]]:
    """Yield the place and the result of each item, run in batches that grow with their speed."""
    first = 0
    while first < len(items):
        clock = time.monotonic()
        batch = run(items[first : first + size])
        if time.monotonic() - clock < BATCH_SECONDS:
            size *= 2
        yield from enumerate(batch, first)
        first += len(batch)


def cores() -> int:
    """Return the number of cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def parallel_map(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> list[Result]:
    """Return ``function`` of each item, in order; on the first exception, start no more."""
    results = dict(parallel_each(function, items, threads))
    return [results[place] for place in range(len(results))]


def parallel_each(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> Iterator[tuple[int, Result]]:
    """Yield the place and ``function`` of each item as it is done, until an exception.

    An interrupt, or a caller that leaves, does not wait for what runs: closing the engine ends
    that.
    """
    failures: list[BaseException] = []

    def call(item: Item) -> Result:
        if failures:  # a thread may take its next item before this generator sees the exception
            raise failures[0]
        try:
            return function(item)
        except BaseException as error:
            failures.append(error)
            raise

    pool = ThreadPoolExecutor(max(1, threads))
    try:
        places = {pool.submit(call, item): place for place, item in enumerate(items)}
        for future in as_completed(places):
            yield places[future], future.result()
    finally:
        interrupted = isinstance(sys.exception(), (KeyboardInterrupt, GeneratorExit))
        pool.shutdown(wait=not interrupted, cancel_futures=True)


def dealt(count: int, hands: int) -> list[range]:
    """Return the indices 0 to ``count`` - 1, dealt out over as many hands at most."""
    hands = max(1, min(hands, count))
    return [range(first, count, hands) for first in range(hands)]
