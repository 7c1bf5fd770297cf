"""Write down each run in the history: when it starts, and how it ended."""

from __future__ import annotations

import contextlib
import math
import platform
import sqlite3
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.errors import HarnessError

if TYPE_CHECKING:
    from harness.store.history import History, Quantity
    from harness.workflows.progress import Progress


@dataclass
class Recording:
    """What a command tells of its run before it ends."""

    status: int = 0
    engine: Mapping[str, Any] = field(default_factory=dict)
    quantities: Sequence[Quantity] = ()
    cached: bool = False
    folder: Path | None = None
    progress: Progress = lambda *_: None


Finish = Callable[[Recording, float, str], None]
"""Completes a run: with what was told, the seconds it took, and a note on what ended it."""


@contextlib.contextmanager
def recorded(command: str, *, quiet: bool = False) -> Iterator[Recording]:
    """Record a run from here to the end of the block, with the error that ended it, if any.

    Yield what the command fills in, with what shows its progress unless ``quiet``. A default place
    that cannot be written costs a note on stderr, one that was named in DEM_HARNESS_HOME the
    command: RequestError.
    """
    from harness.cli import interrupted_status
    from harness.workflows import progress_bars

    told, clock = Recording(), time.monotonic()
    with _begin(command) as finish:
        try:
            with progress_bars(command, quiet=quiet) as told.progress:
                yield told
        except HarnessError as error:
            told.status = error.exit_status
            finish(told, time.monotonic() - clock, str(error))
            raise
        except KeyboardInterrupt:
            told.status = interrupted_status()
            finish(told, time.monotonic() - clock, "interrupted")
            raise
        # of an exception that nobody foresaw the run stays unfinished
        finish(told, time.monotonic() - clock, "")


def verdicts(checks: Sequence[Mapping[str, Any]]) -> list[Quantity]:
    """Return the checks of a verification's record as quantities."""
    from harness.store.history import Quantity

    found = []
    for check in checks:
        told: dict[str, Any] = {one.name: check.get(one.name, "") for one in fields(Quantity)}
        told |= {name: math.nan for name, value in told.items() if value is None}
        found.append(Quantity(**told))
    return found


@contextlib.contextmanager
def _begin(command: str) -> Iterator[Finish]:
    """Insert a run that starts now; yield what completes it."""
    from harness import __version__
    from harness.home import history_place
    from harness.store.checkout import commit
    from harness.store.entries import tell_stderr
    from harness.store.history import History, Start

    place = history_place()
    system = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    start = Start(command, _given(command), __version__, commit(), system)
    with contextlib.ExitStack() as stack:
        try:
            history = stack.enter_context(History(place.path))
            run = history.begin(start)
        except (OSError, sqlite3.Error) as error:
            if place.named_by:
                raise place.refused(str(error)) from None
            tell_stderr(f"history {place.path} cannot be written ({error}); no record of this run")
            yield lambda *_: None
        else:
            yield partial(_finish, history, run)


def _finish(history: History, run: int, told: Recording, seconds: float, note: str) -> None:
    """Complete the run; a history that went away meanwhile must not cost its result."""
    from harness.store.entries import tell_stderr
    from harness.store.history import End

    end = End(
        status=told.status,
        seconds=seconds,
        engine=told.engine.get("engine", ""),
        engine_version=told.engine.get("engine_version", ""),
        how=told.engine.get("how", ""),
        cached=told.cached,
        folder=str(told.folder.absolute()) if told.folder else "",
        note=note,
    )
    try:
        history.finish(run, end, told.quantities)
    except sqlite3.Error as error:
        tell_stderr(f"history {history.path} cannot be written ({error}); the run has no end there")


def _given(command: str) -> list[str]:
    """Return the words after the command as text, as the shell handed them over."""
    words = sys.argv[1:]
    given = words[words.index(command) + 1 :] if command in words else []
    # what is not UTF-8 on the command line cannot be stored as it is
    return [word.encode("utf-8", "backslashreplace").decode() for word in given]
