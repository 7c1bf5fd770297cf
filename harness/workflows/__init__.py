"""What the command line can do, as functions; each is imported when it is first asked for.

>>> from harness.workflows import theory
>>> round(theory().critical_angle_deg, 4)
10.2078
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOMES = {
    "harness.cases.incline.angle": "critical_angle critical_angles extrapolated_critical_angle",
    "harness.cases.incline.closed_forms": "theory",
    "harness.cases.tower.impulse": "energy_scaling_angles impulse_angles impulse_by_gamma "
    "impulse_table",
    "harness.cases.tower.run": "tower",
    "harness.workflows.baseline": "accept_baseline compare_with_baseline diff releases",
    "harness.workflows.case_runs": "case_details cases film run",
    "harness.workflows.engine_status": "engines inputs outdated_inputs",
    "harness.workflows.progress": "progress_bars",
    "harness.workflows.static_site": "site",
    "harness.workflows.sweep_run": "sweep",
    "harness.workflows.verification": "sections verify",
}
"""The functions of each module. No function has the name of a module of this package."""

_HOME_OF = {name: home for home, names in _HOMES.items() for name in names.split()}

if TYPE_CHECKING:
    from harness.cases.incline.angle import (
        critical_angle,
        critical_angles,
        extrapolated_critical_angle,
    )
    from harness.cases.incline.closed_forms import theory
    from harness.cases.tower.impulse import (
        energy_scaling_angles,
        impulse_angles,
        impulse_by_gamma,
        impulse_table,
    )
    from harness.cases.tower.run import tower
    from harness.workflows.baseline import accept_baseline, compare_with_baseline, diff, releases
    from harness.workflows.case_runs import case_details, cases, film, run
    from harness.workflows.engine_status import engines, inputs, outdated_inputs
    from harness.workflows.progress import progress_bars
    from harness.workflows.static_site import site
    from harness.workflows.sweep_run import sweep
    from harness.workflows.verification import sections, verify

__all__ = [
    "accept_baseline", "case_details", "cases", "compare_with_baseline", "critical_angle",
    "critical_angles", "diff", "energy_scaling_angles", "engines", "extrapolated_critical_angle",
    "film", "impulse_angles", "impulse_by_gamma", "impulse_table",
    "inputs", "outdated_inputs", "progress_bars", "releases", "run", "sections", "site",
    "sweep", "theory", "tower", "verify",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOME_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME_OF})
