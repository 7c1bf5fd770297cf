"""Record each run of a command in the history: start, quantities, end.

The name of a quantity says which run it is of: runs of the same name can be drawn over one another.
Parameters are named where they are not the default.
"""

from __future__ import annotations

import contextlib
import platform
import sqlite3
import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.errors import HarnessError
from harness.observables.row import Row

if TYPE_CHECKING:
    from harness.store.history import History
    from harness.workflows.progress import Progress


def non_default(record: Mapping[str, Any], defaults: Mapping[str, Any]) -> str:
    """Return the values of a record that are not the usual ones, as the end of a name."""
    changed = {
        key: record[key] for key, usual in defaults.items() if record.get(key, usual) != usual
    }
    return "".join(f", {key} = {value}" for key, value in changed.items())


@dataclass
class Recording:
    """What a command records of its run before it ends."""

    status: int = 0
    engine: Mapping[str, Any] = field(default_factory=dict)
    quantities: Sequence[Row] = ()
    cached: bool = False
    folder: Path | None = None
    progress: Progress = lambda *_: None


Finish = Callable[[Recording, float, str], None]
"""Completes a run: with the recording, the seconds it took, and a note on what ended it."""


@contextlib.contextmanager
def recorded(command: str, *, quiet: bool = False) -> Iterator[Recording]:
    """Record a run from here to the end of the block, with the error that ended it, if any.

    Yield what the command fills in, with what shows its progress unless ``quiet``. A default place
    that cannot be written costs a note on stderr, one that was named in DEM_HARNESS_HOME the
    command: RequestError.
    """
    from harness.cli import interrupted_status
    from harness.workflows import progress_bars

    recording, clock = Recording(), time.monotonic()
    with _begin(command) as finish:
        try:
            with progress_bars(command, quiet=quiet) as recording.progress:
                yield recording
        except HarnessError as error:
            recording.status = error.exit_status
            finish(recording, time.monotonic() - clock, str(error))
            raise
        except KeyboardInterrupt:
            recording.status = interrupted_status()
            finish(recording, time.monotonic() - clock, "interrupted")
            raise
        # of an exception that nobody foresaw the run stays unfinished
        finish(recording, time.monotonic() - clock, "")


@contextlib.contextmanager
def _begin(command: str) -> Iterator[Finish]:
    """Insert a run that starts now; yield what completes it."""
    from harness import __version__
    from harness.files import history_place
    from harness.store.acceptance import commit
    from harness.store.entries import tell_stderr
    from harness.store.history import History, RunStart

    place = history_place()
    system = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    start = RunStart(command, given_words(command), __version__, commit(), system)
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


def _finish(history: History, run: int, recording: Recording, seconds: float, note: str) -> None:
    """Complete the run; a history that went away meanwhile must not cost its result."""
    from harness.store.entries import tell_stderr
    from harness.store.history import RunEnd

    end = RunEnd(
        status=recording.status,
        seconds=seconds,
        engine=recording.engine.get("engine", ""),
        engine_version=recording.engine.get("engine_version", ""),
        how=recording.engine.get("how", ""),
        cached=recording.cached,
        folder=str(recording.folder.absolute()) if recording.folder else "",
        note=note,
    )
    try:
        history.finish(run, end, recording.quantities)
    except sqlite3.Error as error:
        tell_stderr(f"history {history.path} cannot be written ({error}); the run has no end there")


def given_words(command: str) -> list[str]:
    """Return the words after the command as text, as the shell handed them over."""
    words = sys.argv[1:]
    words_after = words[words.index(command) + 1 :] if command in words else []
    # what is not UTF-8 on the command line cannot be stored as it is
    return [word.encode("utf-8", "backslashreplace").decode() for word in words_after]
