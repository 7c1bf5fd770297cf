"""What inclines and their critical angles are expected to take an engine."""

from __future__ import annotations

import math

from harness.cases.incline.levels import Ladder
from harness.cases.incline.parameters import Incline
from harness.cases.incline.template import Route
from harness.engines.cost import engine_seconds
from harness.engines.traits import Traits

PASSAGE, WELL = 2.1, 4.5
"""[sqrt(d/g)] that a run takes by the passage route, and for each well by the steady route: the
mean over the runs of an angle, the same at k = 1e5, 1e6 and 1e8 N/m in the reference DEM."""

PASSAGES, STEADY_RUNS, COARSE_RUNS = 12, 16, 70
"""Runs behind an angle, likewise; the last at steps so coarse that fates are probed, 60 to 71 at
4.8 steps per contact and k = 1e5 to 1e7 N/m."""


def run_seconds(case: Incline, route: Route, rules: Traits) -> float:
    """Return what one run is expected to take [s]."""
    longest = PASSAGE if route == "passage" else min(WELL * case.wells, case.time_limit)
    steps = longest * math.sqrt(case.diameter / case.gravity) / case.step
    return engine_seconds(steps, case.spheres + 1, rules)


def angle_seconds(case: Incline, route: Route, rules: Traits) -> float:
    """Return what a critical angle is expected to take [s], by a case with the wells to pass."""
    from harness.cases.incline.steady import COARSE

    runs = PASSAGES
    if route == "steady":
        runs = COARSE_RUNS if case.steps_per_contact < COARSE else STEADY_RUNS
    return runs * run_seconds(case, route, rules)


def extrapolation_seconds(case: Incline, rules: Traits, ladder: Ladder | None = None) -> float:
    """Return what the angles of a ladder of stiffnesses and steps are expected to take [s]."""
    return sum(angle_seconds(one, "passage", rules) for one in (ladder or Ladder()).cases(case))
