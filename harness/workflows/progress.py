"""How a long workflow says how far it is: ``progress=`` of each, and bars for a terminal.

>>> from harness.workflows import progress_bars, verify
>>> with progress_bars("verify") as progress:  # doctest: +SKIP
...     found = verify(progress=progress)

Any function of a stage's name, the parts done and the parts in all will do in place of the bars.
"""

from __future__ import annotations

import math
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from harness.cases.verification import Progress as Progress
from harness.cases.verification import silent as silent

if TYPE_CHECKING:
    from rich.progress import Task

DELAY = 1.0
"""[s] What is done by then shows no bars."""

LOG_DELAY = 5.0
"""[s] What is done by then leaves no line in a log."""

LOG_PAUSE = 30.0
"""[s] Between two lines of a stage that goes on."""


MOST_BARS = 12
"""Stages up to which those that are over are shown too."""


class LogLines:
    """Says on stderr, a line each, which stages are over and how far the others are."""

    def __init__(self, title: str) -> None:
        self._title, self._begun = title, time.monotonic()
        self._last_line: dict[str, float] = {}
        self._lock = threading.Lock()

    def __call__(self, stage: str, done: int, total: int) -> None:
        """Print a line where a stage ends, and now and then while it goes on."""
        seconds = time.monotonic() - self._begun
        with self._lock:
            last = self._last_line.setdefault(stage, seconds)
            over = done >= total and last < math.inf
            if seconds < LOG_DELAY or not (over or seconds - last >= LOG_PAUSE):
                return
            self._last_line[stage] = math.inf if over else seconds
        print(f"{self._title}: {stage}, {done} of {total}, {seconds:.0f} s", file=sys.stderr)


@contextmanager
def progress_bars(title: str, *, quiet: bool = False) -> Iterator[Progress]:
    """Yield a function that draws a bar for each stage on stderr, below a line with ``title``.

    The line counts the seconds, and says so while kernels are compiled. Nothing is drawn before
    the first second has passed, and not when ``quiet``. Where stderr is neither a terminal nor a
    notebook, as in a log, stages are lines instead, those of the first seconds left out.
    """
    from rich.console import Console
    from rich.progress import BarColumn, ProgressColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars
    from rich.text import Text

    console = Console(stderr=True)
    if quiet or not (console.is_terminal or console.is_jupyter):
        yield silent if quiet else LogLines(title)
        return

    class Description(ProgressColumn):
        max_refresh = None

        def render(self, task: Task) -> Text:
            compiles = task.id == first and compiling()
            note = ": compiling, or loading, kernels (compiled once)" if compiles else ""
            return Text(f"{task.description}{note}"[: max(20, console.width - 30)])

    class Counts(ProgressColumn):
        max_refresh = None

        def render(self, task: Task) -> Text:
            return Text("" if task.total is None else f"{task.completed:.0f}/{task.total:.0f}")

    bars = Bars(Description(), BarColumn(16), Counts(), TimeElapsedColumn(), console=console)
    first = bars.add_task(title, total=None)
    stages: dict[str, object] = {}

    def update(stage: str, done: int, total: int) -> None:
        if stage not in stages:
            stages[stage] = bars.add_task(stage, total=total)
        # of many stages those that are over leave the terminal
        visible = done < total or len(stages) <= MOST_BARS
        bars.update(stages[stage], completed=done, total=total, visible=visible)  # type: ignore[arg-type]

    timer = threading.Timer(DELAY, bars.start)
    timer.daemon = True
    timer.start()
    try:
        yield update
    finally:
        timer.cancel()
        timer.join()
        bars.stop()


def compiling() -> bool:
    """Return whether another thread compiles a kernel, or reads one from where it is kept."""
    module = sys.modules.get("numba.core.compiler_lock")
    lock = getattr(getattr(module, "global_compiler_lock", None), "_lock", None)
    if lock is None:
        return False
    free: bool = lock.acquire(blocking=False)
    if free:
        lock.release()
    return not free
