"""Run a function over items side by side, in threads that wait for processes."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


LOOK_SECONDS = 0.5
"""Between two looks for a signal, which a thread that begins to wait may miss."""


def cores() -> int:
    """Return the number of cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def parallel_map(
    function: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> list[Result]:
    """Return ``function`` of each item, in order; on the first exception, start no more.

    An interrupt does not wait for what runs: closing the engine ends that.
    """
    pool = ThreadPoolExecutor(max(1, threads))
    try:
        return [_result(future) for future in [pool.submit(function, item) for item in items]]
    finally:
        pool.shutdown(wait=sys.exc_info()[0] is not KeyboardInterrupt, cancel_futures=True)


def _result(future: Future[Result]) -> Result:
    while not wait([future], LOOK_SECONDS).done:
        pass
    return future.result()


def dealt(count: int, hands: int) -> list[range]:
    """Return the indices 0 to ``count`` - 1, dealt out over as many hands at most."""
    hands = max(1, min(hands, count))
    return [range(first, count, hands) for first in range(hands)]
