"""The verbs of the command line as functions, each imported when it is first used; progress.

>>> from harness.workflows import theory
>>> round(theory().critical_angle_deg, 4)
10.2078
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from harness.cases.incline.closed_form import theory
    from harness.cases.incline.search import critical_angle, extrapolated_critical_angle
    from harness.cases.tower.impulse import impulse_angles
    from harness.cases.tower.impulse import impulse_angles as impulse
    from harness.cases.tower.runs import tower
    from harness.report.site import site
    from harness.workflows.comparisons import accept, defects, diff, releases
    from harness.workflows.lists import cases, engines, inputs, outdated_inputs
    from harness.workflows.runs import run
    from harness.workflows.sweeps import sweep
    from harness.workflows.verification import verify

__all__ = [
    "Progress", "accept", "cases", "critical_angle", "defects", "diff", "engines",
    "extrapolated_critical_angle", "impulse", "impulse_angles", "inputs", "outdated_inputs",
    "progress_bars", "releases", "run", "silent", "site", "sweep", "theory", "tower", "verify",
]  # fmt: skip

_VERBS = {  # by the modules that have them
    "harness.cases.incline.search": ("critical_angle", "extrapolated_critical_angle"),
    "harness.cases.incline.closed_form": ("theory",),
    "harness.cases.tower.impulse": ("impulse_angles",),
    "harness.cases.tower.runs": ("tower",),
    "harness.report.site": ("site",),
    "harness.workflows.comparisons": ("accept", "defects", "diff", "releases"),
    "harness.workflows.lists": ("cases", "engines", "inputs", "outdated_inputs"),
    "harness.workflows.runs": ("run",),
    "harness.workflows.sweeps": ("sweep",),
    "harness.workflows.verification": ("verify",),
}


def __getattr__(name: str) -> Any:
    verb = "impulse_angles" if name == "impulse" else name
    for module, verbs in _VERBS.items():
        if verb in verbs:
            return getattr(import_module(module), verb)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


# ---- progress, of which every workflow is given a function

Progress = Callable[[str, int, int], None]  # the name of a stage, the parts done, and all parts
BARS_AFTER_SECONDS = 1.0
LOG_AFTER_SECONDS, LOG_PAUSE_SECONDS = 5.0, 30.0  # until the first line, and between two
MOST_BARS = 12  # stages up to which finished ones stay on the terminal


def silent(stage: str, done: int, total: int) -> None:
    """Show nothing."""


@contextmanager
def progress_bars(title: str, *, quiet: bool = False) -> Iterator[Progress]:
    """Yield a function that draws a bar for each stage on stderr, below a line with ``title``.

    Nothing is drawn in the first second, and nothing at all when ``quiet``. Where stderr is no
    terminal, a line is printed at the end of a stage, and now and then before.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bars

    console = Console(stderr=True)
    if quiet or not (console.is_terminal or console.is_jupyter):
        yield silent if quiet else _log_lines(title)
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


def _log_lines(title: str) -> Progress:
    started, printed, ended = time.monotonic(), dict[str, float](), set[str]()

    def update(stage: str, done: int, total: int) -> None:
        seconds = time.monotonic() - started
        since = seconds - printed.setdefault(stage, seconds)
        is_due = done >= total or since >= LOG_PAUSE_SECONDS
        if is_due and seconds >= LOG_AFTER_SECONDS and stage not in ended:
            printed[stage] = seconds
            ended.update([stage] if done >= total else ())
            print(f"{title}: {stage}, {done} of {total}, {seconds:.0f} s", file=sys.stderr)

    return update
