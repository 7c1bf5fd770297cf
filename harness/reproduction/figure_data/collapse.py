"""Figure 9: runs whose rigidities are an order of magnitude apart, in t0 and v0 sqrt(k m)."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np

from harness.cases.tower.impulse_table import STIFFNESSES
from harness.cases.tower.run import tower
from harness.observables.summary import contact_changes
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement, claim_of_facts

HEIGHT = 9  # ten particles
LAST = 1.5  # [t0] beyond it the grain of ten particles has left

START = 0.01  # [t0] before it the first contacts close, all at once


def collapse() -> tuple[tuple[TowerRun, ...], Statement]:
    """Run ten particles at the source's stiffnesses, and judge how close scaling brings them."""
    runs = tuple(
        tower(Tower(height=HEIGHT, stiffness=k), solver="exact", profiles=True) for k in STIFFNESSES
    )
    return runs, judged(runs)


def judged(runs: tuple[TowerRun, ...]) -> Statement:
    """Judge by how much scaling brings runs an order of rigidity apart closer together."""
    left = np.array([_spread(pair, scaled=True) for pair in pairwise(runs)])
    events = [[time for time, _ in contact_changes(run) if START < time < LAST] for run in runs]
    same = len({len(times) for times in events}) == 1
    return claim_of_facts(
        "fig-9",
        before=max(_spread(pair, scaled=False) for pair in pairwise(runs)),
        left=left,
        shift=float(np.ptp(np.array(events), axis=0).max()) if same else math.nan,
        gammas=[run.tower.gamma for run in runs],
    )


def _spread(pair: tuple[TowerRun, TowerRun], *, scaled: bool) -> float:
    """Return the mean difference of two forces over their mean, against scaled or bare axes."""
    last = LAST * (1 if scaled else max(run.tower.contact_time for run in pair))
    grid = np.linspace(0, last, 3001)
    one, other = (
        np.interp(grid, run.time_over_t0, run.grain_force / (run.tower.speed * run.tower.omega))
        if scaled
        else np.interp(grid, run.time, run.grain_force)
        for run in pair
    )
    return float(np.abs(one - other).mean() / np.mean([one, other]))
