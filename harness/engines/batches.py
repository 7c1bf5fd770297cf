"""Many runs: in one process, after one that dies or hangs, in batches, or each on its own."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TypeVar

from harness.engines.output import Output
from harness.engines.parallel import cores, parallel_each
from harness.engines.process import Ended, last_words
from harness.errors import EngineCrashError, EngineError, EngineOutputError, EngineTimeoutError

Item = TypeVar("Item")
Result = TypeVar("Result")
Outcome = Output | EngineError

BATCH_SECONDS = 10.0
"""A batch that takes less is followed by one of twice the runs: starting a process costs a second
at most, and so much is repeated after kill -9."""

_FINISHED = re.compile(r"^RESULT verdict = ", re.MULTILINE)


def finished(log: str) -> bool:
    """Return whether a log has the line that a script prints last, not only echoes it."""
    return _FINISHED.search(log) is not None


def in_batches(
    items: Sequence[Item], run: Callable[[Sequence[Item]], list[Outcome]]
) -> Iterator[tuple[int, Outcome]]:
    """Yield the place and the outcome of each item, run in batches that grow with their speed."""
    first, size = 0, 2 * cores()
    while first < len(items):
        clock = time.monotonic()
        batch = run(items[first : first + size])
        if time.monotonic() - clock < BATCH_SECONDS:
            size *= 2
        yield from enumerate(batch, first)
        first += len(batch)


def each_alone(
    items: Sequence[Item], run: Callable[[Item], Result | EngineError], workers: int, who: str
) -> Iterator[tuple[int, Result | EngineError]]:
    """Yield the place and the outcome of each item as it is over, run side by side.

    After two in a row for each worker that hang, the rest is not tried.
    """
    most, hung = 2 * workers, 0

    def one(item: Item) -> Result | EngineError:
        nonlocal hung
        if hung >= most:
            return EngineTimeoutError(f"{who}: not run after {most} in a row that hung")
        outcome = run(item)
        hung = hung + 1 if isinstance(outcome, EngineTimeoutError) else 0
        return outcome

    yield from parallel_each(one, items, min(workers, len(items)))


def run_in_turn(
    items: Sequence[Item], run_batch: Callable[[Sequence[Item]], list[Outcome]]
) -> list[Outcome]:
    """Return the outcome of each item, in order, from as many batches as it takes.

    ``run_batch`` may return fewer outcomes than it was given items, as a process that dies does,
    but one at least: it is called again with the rest. Two batches in a row that hang at
    their first item end it: the rest would cost the time limit each.
    """
    done: list[Outcome] = []
    hung = False
    while len(done) < len(items):
        batch = run_batch(items[len(done) :])
        done += batch
        hangs = isinstance(batch[-1], EngineTimeoutError)
        if hangs and hung and len(batch) == 1:
            message = f"{batch[-1]}; not run after two that hung"
            done += [EngineTimeoutError(message) for _ in items[len(done) :]]
        hung = hangs
    return done


def collect(
    logs: Iterable[str],
    read: Callable[[int], Output],
    error_of: Callable[[str], EngineError | None],
    ended: Ended,
    who: str,
) -> list[Outcome]:
    """Return the outputs of finished runs of a process, and an error for the one it died at.

    ``read`` returns the output of a run, ``error_of`` the error that the process's end and the log
    of the run it was at (empty: of none) speak of. That a run ended cleanly is known by the
    beginning of the next, or by the end of the process: where that failed after all runs had
    finished, none of them counts. A log that raises EngineOutputError ends the list with it.
    """
    done: list[Outcome] = []
    whole: list[str] = []
    try:
        for log in logs:
            if not finished(log):
                error = error_of(log) or EngineOutputError(
                    f"{who} ended without a result{last_words(ended.said)}"
                )
                error.log = "\n".join(dict.fromkeys(text for text in (log, ended.said) if text))
                return [*done, error]
            whole.append(log)
            done.append(_read(read, len(done), log))
    except EngineOutputError as error:
        return [*done, error]
    death = error_of("")
    return done if death is None else [_late(death, log) for log in whole]


def _read(read: Callable[[int], Output], index: int, log: str) -> Outcome:
    """Return the output of a finished run, or the error that it raises."""
    try:
        return read(index)
    except EngineError as error:
        error.log = log
        return error


def _late(death: EngineError, log: str) -> EngineError:
    """Return the error of a run whose process failed after its results were there."""
    error = EngineCrashError(f"{death}, after its results were written")
    error.log = log
    return error
