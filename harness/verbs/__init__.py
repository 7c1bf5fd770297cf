"""What the command line can do, as functions; each is imported when it is first asked for.

>>> from harness.verbs import theory
>>> round(theory().critical_angle_deg, 4)
10.2078
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

_HOMES = {
    "accept_baseline": "harness.verbs.baseline",
    "compare_with_baseline": "harness.verbs.baseline",
    "critical_angle": "harness.verbs.incline",
    "critical_angles": "harness.verbs.incline",
    "diff": "harness.verbs.diff",
    "energy_scaling_angles": "harness.verbs.impulse_angles",
    "engines": "harness.verbs.status",
    "extrapolated_critical_angle": "harness.verbs.incline",
    "history": "harness.verbs.history",
    "inputs": "harness.verbs.scripts",
    "outdated_inputs": "harness.verbs.scripts",
    "impulse_angles": "harness.verbs.impulse_angles",
    "impulse_by_gamma": "harness.verbs.impulse_angles",
    "impulse_table": "harness.verbs.impulses",
    "reproduce": "harness.verbs.reproduction.run",
    "releases": "harness.verbs.releases",
    "theory": "harness.verbs.closed_forms",
    "tower": "harness.verbs.towers",
    "verify": "harness.verbs.verification",
}

if TYPE_CHECKING:
    from harness.verbs.baseline import accept_baseline as accept_baseline
    from harness.verbs.baseline import compare_with_baseline as compare_with_baseline
    from harness.verbs.closed_forms import theory as theory
    from harness.verbs.diff import diff as diff
    from harness.verbs.history import history as history
    from harness.verbs.impulse_angles import energy_scaling_angles as energy_scaling_angles
    from harness.verbs.impulse_angles import impulse_angles as impulse_angles
    from harness.verbs.impulse_angles import impulse_by_gamma as impulse_by_gamma
    from harness.verbs.impulses import impulse_table as impulse_table
    from harness.verbs.incline import critical_angle as critical_angle
    from harness.verbs.incline import critical_angles as critical_angles
    from harness.verbs.incline import extrapolated_critical_angle as extrapolated_critical_angle
    from harness.verbs.releases import releases as releases
    from harness.verbs.reproduction.run import reproduce as reproduce
    from harness.verbs.scripts import inputs as inputs
    from harness.verbs.scripts import outdated_inputs as outdated_inputs
    from harness.verbs.status import engines as engines
    from harness.verbs.towers import tower as tower
    from harness.verbs.verification import verify as verify

__all__ = list(_HOMES)


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value
