"""Towers in an engine, held against the exact solution of the overlap law."""

import numpy as np
import pytest

from harness.cases.tower.run import run_towers
from harness.solvers.chain import exact

KINDS = [
    {"gravity": 0.0},
    {"base": "free", "gravity": 0.0},
    {"base": "free"},
    {"start": "preloaded"},
    {"start": "gapped", "gap": 1e-4},
    {"mass": 0.3, "diameter": 0.02, "stiffness": 2e4, "speed": 0.7},
]
"""Every kind of tower, by what is not the default."""


def run(engine, case, **options):
    """Return the run of a tower; raise what went wrong in it."""
    (found,) = run_towers(engine, [case], 3.0, **options)
    assert not isinstance(found, Exception), found
    return found


def force_difference(found):
    """Return the largest difference of the grain's force to the exact one, over its peak."""
    reference = exact.run(found.tower, found.time[-1], samples=len(found.time) - 1)
    rows = np.searchsorted(reference.time, found.time - 1e-9 * found.time[-1])
    assert reference.time[rows] == pytest.approx(found.time, abs=1e-12 * found.time[-1])
    difference = np.abs(reference.grain_force[rows] - found.grain_force).max()
    return difference / reference.grain_force.max()
