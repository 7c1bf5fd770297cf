"""The tower runs that the rows share, each made once.

By the exact propagator, which has no step: what a row finds is the model, not an
integrator. Towers are the source's (1 kg, 1 m, 9.81 m/s2) unless a row says otherwise.
"""

from __future__ import annotations

import math
from functools import cache

from harness.cases.tower.impulse_table import SPEEDS, STIFFNESSES, impulse_table
from harness.cases.tower.run import tower
from harness.observables.impulse import ImpulseRow
from harness.observables.summary import grain_alone
from harness.observables.tower import TowerRun
from harness.parameters.tower import Law, Tower

SAMPLES = 2000
"""For each run: enough to name a time to a thousandth of t0; changes of contact are exact."""

MEDIAN = (1e6, 2.0)
"""[N/m], [m/s] of the runs that the source tells most about."""

Ratios = dict[tuple[float, float], dict[int, float]]


@cache
def run(case: Tower, duration: float = 3.0) -> TowerRun:
    """Return ``case`` run for ``duration`` [t0], with profiles."""
    return tower(case, solver="exact", duration=duration, samples=SAMPLES, profiles=True)


@cache
def free_collision(particles: int, law: Law = "deformable") -> TowerRun:
    """Return a grain that runs into free particles, no gravity, until all have parted."""
    case = Tower(height=particles - 1, base="free", gravity=0.0, law=law)
    return run(case, 1.0 + 0.5 * particles)


@cache
def impulses(law: Law = "deformable") -> tuple[ImpulseRow, ...]:
    """Return the source's six runs over all heights, turnaround window."""
    return tuple(impulse_table(laws=(law,), solver="exact"))


def ratios(law: Law = "deformable") -> Ratios:
    """Return alpha by (stiffness, speed) and height."""
    found: Ratios = {(k, v): {} for k in STIFFNESSES for v in SPEEDS}
    for row in impulses(law):
        found[row.stiffness, row.speed][row.height] = row.ratio
    return found


@cache
def heights_with_structure_window(law: Law, tallest: int = 8) -> tuple[int, ...]:
    """Return the heights from 1 to ``tallest`` that have a structure window, median run."""
    rows = impulse_table(
        laws=(law,),
        windows=("structure",),
        heights=range(1, tallest + 1),
        stiffnesses=MEDIAN[:1],
        speeds=MEDIAN[1:],
    )
    return tuple(row.height for row in rows if math.isfinite(row.window_s))


def contact_intervals(one: TowerRun) -> list[tuple[float, float]]:
    """Return when the grain touches anything [t0], from and to; cut off by the end of the run."""
    first, *_, last = (float(time) for time in one.time_over_t0)
    alone = [*grain_alone(one), (last, last)]
    begins = [first, *(end for _, end in alone)]
    ends = [begin for begin, _ in alone]
    return [pair for pair in zip(begins, ends, strict=False) if pair[0] < pair[1]]
