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
    "cases": "harness.workflows.case_list",
    "compare_with_baseline": "harness.workflows.baseline",
    "critical_angle": "harness.cases.incline.critical_angles",
    "critical_angles": "harness.cases.incline.critical_angles",
    "diff": "harness.workflows.run_diffs",
    "energy_scaling_angles": "harness.cases.tower.impulse_angles",
    "engines": "harness.workflows.status",
    "extrapolated_critical_angle": "harness.cases.incline.critical_angles",
    "history": "harness.workflows.history_search",
    "impulse_angles": "harness.cases.tower.impulse_angles",
    "impulse_by_gamma": "harness.cases.tower.impulse_angles",
    "impulse_table": "harness.cases.tower.impulse_table",
    "inputs": "harness.workflows.scripts",
    "outdated_inputs": "harness.workflows.scripts",
    "progress_bars": "harness.workflows.progress",
    "releases": "harness.workflows.release_runs",
    "run": "harness.workflows.case_run",
    "sections": "harness.workflows.report_sections",
    "study": "harness.workflows.study_run",
    "sweep": "harness.workflows.sweep_run",
    "theory": "harness.cases.incline.closed_forms",
    "tower": "harness.cases.tower.run",
    "verify": "harness.workflows.verification_run",
}
"""Where each function is. No function has the name of a module of this package."""

_RUN_ENGINES = {
    "compare_with_baseline",
    "critical_angle",
    "critical_angles",
    "extrapolated_critical_angle",
    "impulse_angles",
    "impulse_table",
    "releases",
    "reproduce",
    "run",
    "tower",
    "verify",
}
"""Those for which an engine is opened by its name, and its runs are kept."""

if TYPE_CHECKING:
    from harness.cases.incline.closed_forms import theory as theory
    from harness.cases.incline.critical_angles import critical_angle as critical_angle
    from harness.cases.incline.critical_angles import critical_angles as critical_angles
    from harness.cases.incline.critical_angles import (
        extrapolated_critical_angle as extrapolated_critical_angle,
    )
    from harness.cases.tower.impulse_angles import energy_scaling_angles as energy_scaling_angles
    from harness.cases.tower.impulse_angles import impulse_angles as impulse_angles
    from harness.cases.tower.impulse_angles import impulse_by_gamma as impulse_by_gamma
    from harness.cases.tower.impulse_table import impulse_table as impulse_table
    from harness.cases.tower.run import tower as tower
    from harness.workflows.baseline import accept_baseline as accept_baseline
    from harness.workflows.baseline import compare_with_baseline as compare_with_baseline
    from harness.workflows.case_list import cases as cases
    from harness.workflows.case_run import run as run
    from harness.workflows.history_search import history as history
    from harness.workflows.progress import progress_bars as progress_bars
    from harness.workflows.release_runs import releases as releases
    from harness.workflows.report_sections import sections as sections
    from harness.workflows.run_diffs import diff as diff
    from harness.workflows.scripts import inputs as inputs
    from harness.workflows.scripts import outdated_inputs as outdated_inputs
    from harness.workflows.status import engines as engines
    from harness.workflows.study_run import study as study
    from harness.workflows.sweep_run import sweep as sweep
    from harness.workflows.verification_run import verify as verify

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    if name in _RUN_ENGINES:
        from harness.workflows.opened import opening

        value = opening(value)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOMES})
