"""The tower runs that the rows share, each made once.

By the exact propagator, which has no step: what a row finds is the model, not an
integrator. Towers are the source's (1 kg, 1 m, 9.81 m/s2) unless a row says otherwise.
"""

from __future__ import annotations

from functools import cache

from harness.cases.tower.impulse_table import HEIGHTS, SPEEDS, STIFFNESSES, impulse_table
from harness.cases.tower.run import tower
from harness.observables.impulse import ImpulseRow
from harness.observables.tower import TowerRun
from harness.observables.windows import Window
from harness.parameters.tower import Law, Tower

SAMPLES = 2000
"""For each run: enough to name a time to a thousandth of t0; changes of contact are exact."""

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
def windows(law: Law, window: Window, heights: tuple[int, ...] = HEIGHTS) -> dict[int, ImpulseRow]:
    """Return the rows of another window by height, at 1e6 N/m and 2 m/s."""
    rows = impulse_table(
        laws=(law,),
        windows=(window,),
        heights=heights,
        stiffnesses=(1e6,),
        speeds=(2.0,),
        solver="exact",
    )
    return {row.height: row for row in rows}


def contact_intervals(one: TowerRun) -> list[tuple[float, float]]:
    """Return when the grain touches anything [t0], from and to; cut off by the end of the run."""
    touching = one.grain_force > 0
    times = one.time_over_t0
    found: list[tuple[float, float]] = []
    begin: float | None = None
    for time, on in zip(times, touching, strict=True):
        if on and begin is None:
            begin = float(time)
        elif not on and begin is not None and time > begin:
            found.append((begin, float(time)))
            begin = None
    return found if begin is None else [*found, (begin, float(times[-1]))]
