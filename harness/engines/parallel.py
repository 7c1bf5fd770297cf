"""Run a function over items side by side, in threads that wait for processes."""

from __future__ import annotations

import os
import queue
import sys
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


LOOK_SECONDS = 0.5
"""Between two looks for a signal, which a thread that begins to wait may miss."""


def cores() -> int:
    """Return the number of cores this process may use; a scheduler may give less than it shows."""
    given = os.environ.get("SLURM_CPUS_PER_TASK", "")
    if given.isdecimal():
        return int(given)
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
    """Yield the place and ``function`` of each item as it is done; no more after an exception.

    An interrupt, or a caller that leaves, does not wait for what runs: closing the engine ends
    that.
    """
    pool, done = ThreadPoolExecutor(max(1, threads)), queue.SimpleQueue[Future[Result]]()
    try:
        places = {pool.submit(function, item): place for place, item in enumerate(items)}
        for future in places:
            future.add_done_callback(done.put)
        for _ in places:
            over = _next(done)
            yield places[over], over.result()
    finally:
        left = isinstance(sys.exception(), (KeyboardInterrupt, GeneratorExit))
        pool.shutdown(wait=not left, cancel_futures=True)


def _next(done: queue.SimpleQueue[Future[Result]]) -> Future[Result]:
    while True:
        try:
            return done.get(timeout=LOOK_SECONDS)
        except queue.Empty:
            continue


def dealt(count: int, hands: int) -> list[range]:
    """Return the indices 0 to ``count`` - 1, dealt out over as many hands at most."""
    hands = max(1, min(hands, count))
    return [range(first, count, hands) for first in range(hands)]
