"""The verbs of the command line as functions; each is imported when it is first used.

>>> from harness.workflows import theory
>>> round(theory().critical_angle_deg, 4)
10.2078
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOMES = {
    "harness.cases.incline": "critical_angle theory",
    "harness.cases.tower": "impulse tower",
    "harness.workflows.lists": "cases engines inputs outdated_inputs",
    "harness.workflows.progress": "progress_bars",
    "harness.workflows.results": "accept diff",
    "harness.workflows.releases": "releases",
    "harness.workflows.site": "site",
    "harness.workflows.runs": "run",
    "harness.workflows.sweeps": "sweep",
    "harness.workflows.verification": "verify",
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names.split()}

if TYPE_CHECKING:
    from harness.cases.incline import critical_angle, theory
    from harness.cases.tower import impulse, tower
    from harness.workflows.lists import cases, engines, inputs, outdated_inputs
    from harness.workflows.progress import progress_bars
    from harness.workflows.releases import releases
    from harness.workflows.results import accept, diff
    from harness.workflows.runs import run
    from harness.workflows.site import site
    from harness.workflows.sweeps import sweep
    from harness.workflows.verification import verify

__all__ = [
    "accept", "cases", "critical_angle", "diff", "engines", "impulse", "inputs", "outdated_inputs",
    "progress_bars", "releases", "run", "site", "sweep", "theory", "tower", "verify",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME_OF[name]), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME_OF})
