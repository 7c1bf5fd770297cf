"""The verbs of the command line as functions; each is imported when it is first used.

>>> from harness.workflows import theory
>>> round(theory().critical_angle_deg, 4)
10.2078
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOMES = {
    "harness.cases.incline.angle": "critical_angle extrapolated_critical_angle",
    "harness.cases.incline.closed_form": "theory",
    "harness.cases.tower.impulse": "impulse impulse_angles",
    "harness.cases.tower.runs": "tower",
    "harness.workflows.lists": "cases engines inputs outdated_inputs",
    "harness.workflows.progress": "progress_bars",
    "harness.workflows.results": "accept defects diff",
    "harness.workflows.release_runs": "releases",
    "harness.report.site": "site",
    "harness.workflows.runs": "run",
    "harness.workflows.sweeps": "sweep",
    "harness.workflows.verification": "verify",
}
_ALIASES = {"impulse": "impulse_angles"}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names.split()}

if TYPE_CHECKING:
    from harness.cases.incline.angle import critical_angle, extrapolated_critical_angle
    from harness.cases.incline.closed_form import theory
    from harness.cases.tower.impulse import impulse_angles
    from harness.cases.tower.impulse import impulse_angles as impulse
    from harness.cases.tower.runs import tower
    from harness.report.site import site
    from harness.workflows.lists import cases, engines, inputs, outdated_inputs
    from harness.workflows.progress import progress_bars
    from harness.workflows.release_runs import releases
    from harness.workflows.results import accept, defects, diff
    from harness.workflows.runs import run
    from harness.workflows.sweeps import sweep
    from harness.workflows.verification import verify

__all__ = [
    "accept", "cases", "critical_angle", "defects", "diff",
    "engines", "extrapolated_critical_angle", "impulse",
    "impulse_angles", "inputs", "outdated_inputs",
    "progress_bars", "releases", "run", "site", "sweep", "theory", "tower", "verify",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME_OF[name]), _ALIASES.get(name, name))


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME_OF})
