"""Progress of a long workflow: bars on a terminal or in a notebook, lines in a log.

Every workflow takes ``progress``, a function of a stage's name, the parts done, and all parts.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Progress = Callable[[str, int, int], None]
BARS_AFTER_SECONDS = 1.0
LOG_AFTER_SECONDS = 5.0
LOG_PAUSE_SECONDS = 30.0  # between two lines of a stage that goes on
MOST_BARS = 12  # stages up to which finished ones stay on the terminal


def silent(stage: str, done: int, total: int) -> None:
    """Show nothing."""


def log_lines(title: str) -> Progress:
    """Return a function that prints a stage on stderr at its end, and now and then before."""
    started, last = time.monotonic(), dict[str, float]()

    def update(stage: str, done: int, total: int) -> None:
        seconds = time.monotonic() - started
        since = seconds - last.setdefault(stage, seconds)
        is_due = done >= total or since >= LOG_PAUSE_SECONDS
        if is_due and seconds >= LOG_AFTER_SECONDS and last[stage] < float("inf"):
            last[stage] = float("inf") if done >= total else seconds
            print(f"{title}: {stage}, {done} of {total}, {seconds:.0f} s", file=sys.stderr)

    return update


@contextmanager
def progress_bars(title: str, *, quiet: bool = False) -> Iterator[Progress]:
    """Yield a function that draws a bar for each stage on stderr, below a line with ``title``.

    Nothing is drawn in the first second, and nothing at all when ``quiet``.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    console = Console(stderr=True)
    if quiet or not (console.is_terminal or console.is_jupyter):
        yield silent if quiet else log_lines(title)
        return
    columns = (TextColumn("{task.description}"), BarColumn(16), MofNCompleteColumn())
    bars = Bars(*columns, TimeElapsedColumn(), console=console)
    bars.add_task(title, total=None)
    stages: dict[str, Any] = {}
    lock = threading.Lock()

    def update(stage: str, done: int, total: int) -> None:
        with lock:
            if stage not in stages:
                stages[stage] = bars.add_task(stage, total=total)
        visible = done < total or len(stages) <= MOST_BARS
        bars.update(stages[stage], completed=done, total=total, visible=visible)

    timer = threading.Timer(BARS_AFTER_SECONDS, bars.start)
    timer.daemon = True
    timer.start()
    try:
        yield update
    finally:
        timer.cancel()
        timer.join()
        bars.stop()
