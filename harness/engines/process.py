"""Processes of engines: one under limits, many side by side; their deaths as errors.

Several items (scripts or scenes) run in a process. One that crashes, hangs or is refused ends its
process: it has failed, and those after it run in another one.
"""

from __future__ import annotations

import contextlib
import errno
import fcntl
import math
import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import BinaryIO, Generic, TypeVar

from harness.errors import (
    EngineCrashError,
    EngineError,
    EngineMemoryError,
    EngineOutputError,
    EngineTimeoutError,
)
from harness.files import (
    advice,
    cache_place,
    held_folder,
    lock_file,
    make_private,
    remove_segments,
)

Item = TypeVar("Item")
Result = TypeVar("Result")

SAID = "said"  # the file of a program's output
LAST_WORDS = 4000  # bytes of a program's output that are kept
LARGEST_FILE = 1024**3  # bytes that a program may write into a file
LONGEST_SECONDS = 2e6  # that a run may take: a pipe waits for 31 bits of milliseconds
FIRST_LOOK, LOOK_SECONDS = 0.05, 0.5  # to the first look at a program, and at most between two
# signals of a program that did not end itself: its output before gives no reason
FAULTS = frozenset({signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL, signal.SIGKILL})
OUT_OF_MEMORY = (  # in lower or upper case
    r"failed to (?:re)?allocate|bad_alloc|MemoryError|out of memory"
    r"|cannot allocate memory|failed to map segment|can't start new thread"
)
# leads a process group, and kills it when the harness, which holds its stdin, is gone
GUARD = ("sh", "-c", "read -r _; kill -KILL 0")


# ---- one program


@dataclass(frozen=True)
class Limits:
    """Bounds on one run: wall time [s] and address space [bytes].

    A run that is expected to take longer than its part of that time has ``patience`` times as long.
    """

    seconds: float = 300.0
    memory: int = 4 * 1024**3
    patience: float = 10.0

    def time_for(self, expected: float) -> float:
        """Return the wall time [s] of runs that are expected to take so long [s]."""
        return min(LONGEST_SECONDS, max(self.seconds, self.patience * expected))


@dataclass(frozen=True)
class Ended:
    """The end of a program: of its output, exit status, wall time [s], whether it hung.

    ``limit`` [s] is the time that it had.
    """

    output: str
    code: int
    seconds: float
    timed_out: bool
    limit: float = math.inf

    def error(self, engine: str) -> EngineError | None:
        """Return the error of an engine by the end of its process, None where it ended well."""
        if self.timed_out:
            message = f"{engine} did not finish within {self.limit:g} s"
            return EngineTimeoutError(message).with_log(self.output)
        return death(engine, self.code, self.output).with_log(self.output) if self.code else None


class Processes:
    """Runs programs; :meth:`close` ends those that run, from whatever thread."""

    def __init__(self) -> None:
        self._groups: set[int] = set()
        self._starting = threading.Lock()
        self.closed = False

    def run(
        self,
        command: Sequence[str],
        folder: Path,
        *,
        seconds: float,
        memory: int,
        environment: Mapping[str, str] | None = None,
    ) -> Ended:
        """Run a command in a folder, one thread, its output in a file; wait for its end.

        Time is over after ``seconds`` without a new file or more output. The process group is
        killed then, when the program ends, and when the harness is interrupted or dies. Raise
        EngineCrashError after :meth:`close`.
        """
        start = time.monotonic()
        with (folder / SAID).open("wb") as stream, self._group() as group:
            with self._starting:  # what starts is in its group before that is killed
                if self.closed:
                    raise EngineCrashError(f"{Path(command[0]).name} was closed")
                process = subprocess.Popen(
                    with_limits(command, memory), stdin=subprocess.DEVNULL, stdout=stream,
                    stderr=subprocess.STDOUT, cwd=folder, env=one_thread(environment),
                    process_group=group,
                )  # fmt: skip
            try:
                timed_out = _hangs(process, seconds, folder, stream)
            finally:  # also when the harness is interrupted
                _kill(group)
                process.wait()
        if process.returncode:
            _wait_for_end(group)
            remove_segments()
        words = last_text(folder / SAID)
        return Ended(words, process.returncode, time.monotonic() - start, timed_out, seconds)

    def close(self) -> None:
        """End what runs; nothing is started any more."""
        with self._starting:
            self.closed = True
        for group in list(self._groups):
            _kill(group)

    @contextlib.contextmanager
    def _group(self) -> Iterator[int]:
        """Yield a process group that is killed at the end of the block, or of the harness."""
        # a shell complains of a working directory that was removed
        with subprocess.Popen(GUARD, stdin=subprocess.PIPE, cwd="/", process_group=0) as guard:
            self._groups.add(guard.pid)
            try:
                yield guard.pid
            finally:
                _kill(guard.pid)
                self._groups.discard(guard.pid)


def _hangs(
    process: subprocess.Popen[bytes], seconds: float, folder: Path, output: BinaryIO
) -> bool:
    """Wait for the end of a process; return whether it went ``seconds`` without progress."""
    state, since, look = _progress(folder, output), time.monotonic(), FIRST_LOOK
    while (remaining := since + seconds - time.monotonic()) > 0.0:
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(min(remaining, look))
            return False
        look = min(2.0 * look, LOOK_SECONDS)
        if (new := _progress(folder, output)) != state:
            state, since = new, time.monotonic()
    return process.poll() is None


def _progress(folder: Path, output: BinaryIO) -> int:
    """Return a number that changes as a process of a folder gets on: files and output."""
    # a program may remove its folder, but not the open file of its output
    return os.fstat(output.fileno()).st_size + sum(len(files) for *_, files in os.walk(folder))


def _kill(group: int) -> None:
    """End a process group: a program, the ranks of a launcher, their children."""
    with contextlib.suppress(ProcessLookupError, PermissionError):
        os.killpg(group, signal.SIGKILL)


def _wait_for_end(group: int) -> None:
    """Wait until the processes of a group that was killed are gone, a second at most."""
    end = time.monotonic() + 1.0
    with contextlib.suppress(ProcessLookupError, PermissionError):
        while time.monotonic() < end:
            os.killpg(group, 0)
            time.sleep(0.01)


def with_limits(command: Sequence[str], memory: int) -> list[str]:
    """Return the command under bounds on its address space and files, as its children are."""
    kilobytes = _allowed(resource.RLIMIT_AS, memory) // 1024
    blocks = _allowed(resource.RLIMIT_FSIZE, LARGEST_FILE) // 512
    limits = f'ulimit -v {kilobytes} && ulimit -f {blocks} && exec "$@"'
    return ["sh", "-c", limits, "sh", *command]


def _allowed(kind: int, wanted: int) -> int:
    """Return a bound, or what the harness itself is allowed where that is less."""
    bounds = [bound for bound in resource.getrlimit(kind) if bound != resource.RLIM_INFINITY]
    return min([wanted, *bounds])


def one_thread(environment: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return an environment, the harness's own unless given, with one thread a process."""
    return {**(os.environ if environment is None else environment), "OMP_NUM_THREADS": "1"}


def fresh_folder() -> contextlib.AbstractContextManager[Path]:
    """Return a temporary folder, removed when its context ends, or by a run after kill -9."""
    return held_folder(Path(tempfile.gettempdir()))


# ---- how a program died


def signal_of(code: int) -> signal.Signals | None:
    """Return the signal of an exit status, a process's own or its shell's."""
    with contextlib.suppress(ValueError):
        if code < 0 or code > 128:
            return signal.Signals(-code if code < 0 else code - 128)
    return None


def way_of_death(code: int) -> str:
    """Return the text of an exit status: a signal's name, or the status."""
    number = signal_of(code)
    return f"exit status {code}" if number is None else f"signal {number.name}"


def death(engine: str, code: int, text: str) -> EngineError:
    """Return the error of a program that ended with a bad exit status, after these words.

    The status comes first: after a fatal signal only the last line of output is used, since the
    lines before it give no reason. Where the program ended by itself its output decides.
    """
    ending, number, last = way_of_death(code), signal_of(code), last_words(text)
    is_fault = number in FAULTS
    if number is signal.SIGXFSZ or (not is_fault and os.strerror(errno.EFBIG) in text):
        most = _allowed(resource.RLIMIT_FSIZE, LARGEST_FILE)
        return EngineOutputError(f"{engine} wrote a file of more than {most} bytes")
    if number is signal.SIGBUS:
        return EngineMemoryError(f"{engine} died: {ending}: {advice()}")
    if number is signal.SIGKILL:
        reason = "took more memory than there is, or was ended from outside"
        return EngineMemoryError(f"{engine} {reason}; it died: {ending}")
    if re.search(OUT_OF_MEMORY, last if is_fault else text, re.IGNORECASE):
        return EngineMemoryError(f"{engine} ran out of memory{last}")
    return EngineCrashError(f"{engine} died: {ending}{last}")


def last_words(text: str) -> str:
    """Return the last line of a program's output, in brackets; nothing for empty output."""
    lines = re.findall(r".*\w.*", text)
    return f" (its last line: {lines[-1].strip()[:160]})" if lines else ""


def first_words(text: str) -> str:
    """Return the first line of a program's output, in brackets; nothing for empty output."""
    line = re.search(r".*\w.*", text)
    return f" (it says: {line[0].strip()[:120]})" if line else ""


# ---- texts that programs write


def text_of(path: Path) -> str:
    """Return the text of a file, or nothing where there is none."""
    return path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""


def last_text(path: Path) -> str:
    """Return the last :data:`LAST_WORDS` bytes of a file, or nothing where there is none."""
    if not path.is_file():
        return ""
    with path.open("rb") as stream:
        stream.seek(max(0, path.stat().st_size - LAST_WORDS))
        return stream.read().decode(errors="replace")


def first_text(path: Path, size: int) -> str:
    """Return the first ``size`` bytes of a file as text, however long it is."""
    with path.open("rb") as stream:
        return stream.read(size).decode(errors="replace")


# ---- many items, several to a process

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
        shares: Sequence[Sequence[int]] | None = None,
    ) -> list[Result | EngineError]:
        """Return the result of each item, or the error of its run, in order.

        ``workers`` processes run side by side, by default as many as there are cores; each has
        ``limits.seconds`` from one result to the next. ``shares`` are the places of items that
        share processes; unless given all are dealt out. ``processes`` can be closed from elsewhere.
        """
        hands, limits, processes = workers or cores(), limits or Limits(), processes or Processes()
        shares = dealt(len(items), hands) if shares is None else shares
        groups = [[items[place] for place in share] for share in shares]
        ends = parallel_map(lambda group: self._in_turn(group, limits, processes), groups, hands)
        outcomes = dict(zip(chain(*shares), chain(*ends), strict=True))
        return [outcomes[place] for place in range(len(items))]

    def _in_turn(
        self, items: Sequence[Item], limits: Limits, processes: Processes
    ) -> list[Result | EngineError]:
        """Run items in as many processes as needed.

        After two in a row that hang the rest is not run: each would take the time limit.
        """
        done: list[Result | EngineError] = []
        while len(done) < len(items):
            done += self._process(items[len(done) :], limits, processes)
            if len(done) > 1 and all(isinstance(end, EngineTimeoutError) for end in done[-2:]):
                message = f"{done[-1]}; not run after two that hung"
                done += [EngineTimeoutError(message) for _ in items[len(done) :]]
        return done

    def _process(
        self, items: Sequence[Item], limits: Limits, processes: Processes
    ) -> list[Result | EngineError]:
        """Return the outcomes of the items that one process got to, at least of the first."""
        if processes.closed:
            return [self._closed() for _ in items]
        with fresh_folder() as folder:
            ended = processes.run(
                self.write(folder, items), folder,
                seconds=limits.time_for(sum(map(self.seconds, items))), memory=limits.memory,
                environment=self.environment(folder),
            )  # fmt: skip
            outcomes: list[Result | EngineError] = []
            for place, item in enumerate(items):
                try:
                    result = self.read(folder, place, item, ended.seconds / len(items))
                except EngineError as error:
                    outcomes.append(error.with_log(self.log(folder, place) or ended.output))
                    continue
                if result is None:
                    is_closed = processes.closed and signal_of(ended.code) is signal.SIGKILL
                    log = self.log(folder, place)
                    failure = self._closed() if is_closed else self._failure(ended, log)
                    texts = dict.fromkeys(filter(None, (log, ended.output)))
                    return [*outcomes, failure.with_log("\n".join(texts))]
                outcomes.append(result)
            if death := self.error(ended, ""):  # its last result may be spoiled
                late = EngineCrashError(f"{death}, after its results were written")
                outcomes[-1] = late.with_log(self.log(folder, len(items) - 1) or ended.output)
            return outcomes

    def _closed(self) -> EngineError:
        return EngineCrashError(f"{self.title} was closed")

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


def dealt(count: int, hands: int) -> list[range]:
    """Return the indices 0 to ``count`` - 1, dealt out over as many hands at most."""
    hands = max(1, min(hands, count))
    return [range(first, count, hands) for first in range(hands)]


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


# ---- environments of releases
#
# A folder of the cache with a file COMPLETE, written last, whose time is that of the last use. Who
# uses or makes one locks it; the others may be dropped.

FOLDER, COMPLETE = "releases", "complete"
USED, MADE = LOCKS = ".used", ".lock"  # endings of the locks of users and of the maker


def environments_folder() -> Path:
    """Return the default folder of environments."""
    return cache_place().path / FOLDER


@contextlib.contextmanager
def locked(home: Path, lock: str, how: int = fcntl.LOCK_EX) -> Iterator[None]:
    """Keep a lock of an environment; raise BlockingIOError with LOCK_NB where another does."""
    make_private(home.parent)
    with lock_file(home.with_name(home.name + lock)) as file:
        fcntl.flock(file, how)
        yield


def drop(home: Path) -> None:
    """Remove an environment; raise BlockingIOError where somebody uses or makes it."""
    now = fcntl.LOCK_EX | fcntl.LOCK_NB
    with locked(home, USED, now), locked(home, MADE, now):
        (home / COMPLETE).unlink(missing_ok=True)
        shutil.rmtree(home, ignore_errors=True)
