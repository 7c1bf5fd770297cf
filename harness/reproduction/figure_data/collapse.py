"""Figure 9: runs whose rigidities are an order of magnitude apart, in t0 and v0 sqrt(k m)."""

from __future__ import annotations

import itertools
import math

import numpy as np

from harness.cases.tower.impulse_table import STIFFNESSES
from harness.cases.tower.run import tower
from harness.observables.summary import contact_changes
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement
from harness.reproduction.facts import claim_of_facts
from harness.reproduction.source import SOURCES

HEIGHT = 9  # ten particles
LAST = 1.5  # [t0] beyond it the grain of ten particles has left

START = 0.01  # [t0] before it the first contacts close, all at once

LEFT = 0.1
"""A collapse leaves less than a tenth of the difference, and of t0 between events."""


def collapse() -> tuple[tuple[TowerRun, ...], Statement]:
    """Run ten particles at the source's stiffnesses, and judge how close scaling brings them."""
    runs = tuple(
        tower(Tower(height=HEIGHT, stiffness=k), solver="exact", profiles=True) for k in STIFFNESSES
    )
    return runs, judged(runs)


def judged(runs: tuple[TowerRun, ...]) -> Statement:
    """Judge by how much scaling brings runs an order of rigidity apart closer together."""
    pairs = list(itertools.pairwise(runs))
    before = max(_spread(pair, scaled=False) for pair in pairs)
    left = [_spread(pair, scaled=True) for pair in pairs]
    after = max(left)
    events = [[time for time, _ in contact_changes(run) if START < time < LAST] for run in runs]
    same = len({len(times) for times in events}) == 1
    shift = float(np.ptp(np.array(events), axis=0).max()) if same else math.nan
    gammas = [run.tower.gamma for run in runs]
    facts = [
        (
            after < LEFT * before,
            "the mean difference of the forces of neighbours falls from "
            f"{100 * before:.0f} % to {100 * after:.1f} % of their mean when time is in t0 and "
            "force in v0 sqrt(k m)",
        ),
        (
            same and shift < LEFT,
            f"the contacts change in the same order, {shift:.3f} t0 apart at most",
        ),
    ]
    return claim_of_facts(
        SOURCES["fig-9"],
        facts,
        f"With Gamma {', '.join(f'{gamma:.2g}' for gamma in gammas)}, what is left between "
        f"neighbours is {', '.join(f'{100 * part:.2g}' for part in left)} %.",
    )


def _spread(pair: tuple[TowerRun, TowerRun], *, scaled: bool) -> float:
    """Return the mean difference of two forces over their mean, against scaled or bare axes."""
    times = [run.time_over_t0 if scaled else run.time for run in pair]
    last = LAST * (1 if scaled else max(run.tower.contact_time for run in pair))
    grid = np.linspace(0, last, 3001)
    forces = [
        np.interp(grid, t, run.grain_force / (run.tower.speed * run.tower.omega if scaled else 1))
        for t, run in zip(times, pair, strict=True)
    ]
    return float(np.abs(forces[0] - forces[1]).mean() / np.mean(forces))
