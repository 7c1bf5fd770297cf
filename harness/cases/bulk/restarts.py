"""Restart files of bulk runs: long ones leave them, each after as much work."""

from __future__ import annotations

import math

from harness.cases.bulk.materials import Bed
from harness.engines.contract import RESTART_EVERY, Values

WORK = 10**9
"""[particles x steps] between two restart files: seven minutes of a core in LAMMPS."""

LONG = 2 * WORK
"""[particles x steps] of the shortest run that leaves any: a quarter of an hour."""


def restart_values(p: Bed) -> Values:
    """Return the value of a job that says how often it leaves a restart file; none for a short run.

    They are part of the run, which begins anew at each of them: so it is the same wherever it is
    cut. They fall on rows of the series.
    """
    if p.grains * (p.settle_steps + p.steps) < LONG:
        return {}
    return {RESTART_EVERY: p.every * math.ceil(WORK / p.grains / p.every)}


def longest_part(values: Values) -> float:
    """Return the share of the steps of a job that lie between two of its restart files."""
    steps = float(values["settle_steps"]) + float(values["steps"])
    return min(1.0, float(values.get(RESTART_EVERY, steps)) / steps)
