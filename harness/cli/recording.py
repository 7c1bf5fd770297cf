"""Write down each run in the history: when it starts, and how it ended."""

from __future__ import annotations

import contextlib
import math
import platform
import sqlite3
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.store.history import History, Quantity


@dataclass
class Recording:
    """What a command tells of its run before it ends."""

    status: int = 0
    engine: Mapping[str, Any] = field(default_factory=dict)
    quantities: Sequence[Quantity] = ()
    cached: bool = False
    folder: Path | None = None


@contextlib.contextmanager
def recorded(command: str) -> Iterator[Recording]:
    """Record a run from here to the end of the block, with the error that ended it, if any.

    Yield what the command fills in. A default place that cannot be written
    costs a note on stderr, one that was named in DEM_HARNESS_HOME the command:
    RequestError.
    """
    from harness.cli import INTERRUPTED
    from harness.errors import HarnessError

    told, clock = Recording(), time.monotonic()
    history, run = _begin(command)
    note = ""
    try:
        yield told
    except HarnessError as error:
        told.status, note = error.exit_status, str(error)
        raise
    except KeyboardInterrupt:
        told.status, note = INTERRUPTED, "interrupted"
        raise
    finally:
        # of an exception that nobody foresaw the run stays unfinished
        if history is not None:
            with history:
                if note or sys.exc_info()[0] is None:
                    _finish(history, run, told, time.monotonic() - clock, note)


def verdicts(checks: Sequence[Mapping[str, Any]]) -> list[Quantity]:
    """Return the checks of a verification's record as quantities."""
    from harness.store.history import Quantity

    return [
        Quantity(
            name=check["name"],
            kind=check["kind"],
            unit=check["unit"],
            value=_number(check["value"]),
            uncertainty=_number(check["uncertainty"]),
            expected=_number(check["expected"]),
            tolerance=_number(check["tolerance"]),
            verdict=check["verdict"],
            triage=check.get("triage", ""),
        )
        for check in checks
    ]


def _number(value: Any) -> float:
    return math.nan if value is None else float(value)


def _begin(command: str) -> tuple[History | None, int]:
    from harness import __version__
    from harness.store.checkout import commit
    from harness.store.entries import tell_stderr
    from harness.store.history import History, Start
    from harness.store.home import history_place

    place = history_place()
    system = f"{platform.system()} {platform.machine()}, Python {platform.python_version()}"
    try:
        history = History(place.path)
        start = Start(command, _given(command), __version__, commit(), system)
        return history, history.begin(start)
    except (OSError, sqlite3.Error) as error:
        if place.named_by:
            raise place.refused(str(error)) from None
        tell_stderr(f"history {place.path} cannot be written ({error}); this run is not recorded")
        return None, 0


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
    """Return the words after the command, as the shell handed them over."""
    words = sys.argv[1:]
    return words[words.index(command) + 1 :] if command in words else []
