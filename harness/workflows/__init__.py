"""What the command line can do, as functions; each is imported when it is first asked for.

>>> from harness.workflows import theory
>>> round(theory().critical_angle_deg, 4)
10.2078
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOMES = {
    "accept_baseline": "harness.workflows.baseline",
    "case_details": "harness.workflows.case_runs",
    "cases": "harness.workflows.case_runs",
    "compare_with_baseline": "harness.workflows.baseline",
    "critical_angle": "harness.cases.incline.angle",
    "critical_angles": "harness.cases.incline.angle",
    "diff": "harness.workflows.baseline",
    "energy_scaling_angles": "harness.cases.tower.impulse",
    "engines": "harness.workflows.engine_status",
    "extrapolated_critical_angle": "harness.cases.incline.angle",
    "film": "harness.workflows.case_runs",
    "film_section": "harness.workflows.case_runs",
    "history": "harness.workflows.history_search",
    "impulse_angles": "harness.cases.tower.impulse",
    "impulse_by_gamma": "harness.cases.tower.impulse",
    "impulse_table": "harness.cases.tower.impulse",
    "inputs": "harness.workflows.engine_status",
    "outdated_inputs": "harness.workflows.engine_status",
    "progress_bars": "harness.workflows.progress",
    "releases": "harness.workflows.release_runs",
    "run": "harness.workflows.case_runs",
    "sections": "harness.workflows.verification",
    "site": "harness.workflows.static_site",
    "study": "harness.workflows.study_run",
    "sweep": "harness.workflows.sweep_run",
    "theory": "harness.cases.incline.closed_forms",
    "tower": "harness.cases.tower.run",
    "verify": "harness.workflows.verification",
}
"""Where each function is. No function has the name of a module of this package."""

if TYPE_CHECKING:
    from harness.cases.incline.angle import critical_angle as critical_angle
    from harness.cases.incline.angle import critical_angles as critical_angles
    from harness.cases.incline.angle import (
        extrapolated_critical_angle as extrapolated_critical_angle,
    )
    from harness.cases.incline.closed_forms import theory as theory
    from harness.cases.tower.impulse import energy_scaling_angles as energy_scaling_angles
    from harness.cases.tower.impulse import impulse_angles as impulse_angles
    from harness.cases.tower.impulse import impulse_by_gamma as impulse_by_gamma
    from harness.cases.tower.impulse import impulse_table as impulse_table
    from harness.cases.tower.run import tower as tower
    from harness.workflows.baseline import accept_baseline as accept_baseline
    from harness.workflows.baseline import compare_with_baseline as compare_with_baseline
    from harness.workflows.baseline import diff as diff
    from harness.workflows.case_runs import case_details as case_details
    from harness.workflows.case_runs import cases as cases
    from harness.workflows.case_runs import film as film
    from harness.workflows.case_runs import film_section as film_section
    from harness.workflows.case_runs import run as run
    from harness.workflows.engine_status import engines as engines
    from harness.workflows.engine_status import inputs as inputs
    from harness.workflows.engine_status import outdated_inputs as outdated_inputs
    from harness.workflows.history_search import history as history
    from harness.workflows.progress import progress_bars as progress_bars
    from harness.workflows.release_runs import releases as releases
    from harness.workflows.static_site import site as site
    from harness.workflows.study_run import study as study
    from harness.workflows.sweep_run import sweep as sweep
    from harness.workflows.verification import sections as sections
    from harness.workflows.verification import verify as verify

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
