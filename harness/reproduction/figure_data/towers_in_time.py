"""Figures 8 and 14: the force on the grain and its chain of contacts, and what it feels when."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.cases.tower.impulse_table import HEIGHTS
from harness.cases.tower.run import tower
from harness.observables.significant_contacts import significant_contacts
from harness.observables.summary import contact_changes, grain_alone
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement, claim_of_facts

PARTICLES = (2, 3, 10, 20)
SEPARATED = (2, 3, 4, 20)
NEIGHBOUR_ENDS = 1.5  # [t0] the source's end of the contacts with the neighbour

SEEN = 0.01
"""Of the peak: what a figure shows."""

ALIKE = 1e-6
"""Of the peak: the part of a force that other figures call felt."""


class TowersInTime(NamedTuple):
    """Towers of several heights over time, and the largest force on the grain of all [N].

    ``shown`` and ``separated`` are those of the two figures.
    """

    shown: tuple[TowerRun, ...]
    largest_force: float
    separated: tuple[TowerRun, ...]
    base_felt: tuple[float, ...]  # [t0], for each of ``separated``; infinite if not in the run


def towers_in_time() -> tuple[TowersInTime, tuple[Statement, Statement]]:
    """Run the towers of all heights; return those of the figures with the statements 8 and 14."""
    *runs, tall = (
        tower(Tower(height=n), solver="exact", profiles=True) for n in (*HEIGHTS, 2 * max(HEIGHTS))
    )
    shown, separated = (tuple(runs[n - 2] for n in chosen) for chosen in (PARTICLES, SEPARATED))
    found = TowersInTime(
        shown,
        max(float(run.grain_force.max()) for run in runs),
        separated,
        tuple(base_felt(run, tall) for run in separated),
    )
    return found, (_force_and_contacts(found), separation(separated, found.base_felt))


class Events(NamedTuple):
    """When things happen to three particles [t0], NaN for what does not."""

    joins: float
    alone: float
    back: float
    leaves: float


_SAID = {"joins": 0.5, "back": 1.0, "leaves": 1.5}  # [t0] what the source reads off, to half a t0


def event_times(run: TowerRun) -> Events:
    """Return when the tower of three does what :class:`Events` names.

    Raise ValueError for a tower of another height.
    """
    if run.tower.height != 2:
        raise ValueError(f"height = {run.tower.height}: the events are those of three particles")
    joins = [time for time, contacts in contact_changes(run) if contacts == 2]
    (begins, ends), *later = grain_alone(run) or [(math.nan, math.nan)]
    back, leaves = (ends, later[-1][0]) if later else (math.nan, math.nan)
    return Events(joins[0] if joins else math.nan, begins, back, leaves)


def _force_and_contacts(found: TowersInTime) -> Statement:
    events = event_times(found.shown[1])
    agree = {
        name: math.isfinite(at := getattr(events, name)) and round(2 * at) / 2 == said
        for name, said in _SAID.items()
    }
    apart = largest_difference(*found.shown[2:]) / found.largest_force
    return claim_of_facts(
        "fig-8",
        [
            agree["joins"],
            math.isfinite(events.alone),
            agree["back"],
            agree["leaves"],
            apart < SEEN,
        ],
        events=events,
        apart=f"{apart:.1e}" if apart > ALIKE else f"less than {ALIKE:.0e}",
        longest=[int(significant_contacts(run).max()) for run in found.shown],
    )


def separation(runs: Sequence[TowerRun], felt: Sequence[float]) -> Statement:
    """Judge whether the base is felt later in longer chains, and where the neighbour's part ends.

    ``felt`` are the times of :func:`base_felt` of ``runs`` [t0], the longest chain last.
    """
    packets = grain_alone(runs[-1])
    last = packets[-1][0]
    return claim_of_facts(
        "fig-14",
        [
            felt[0] < felt[1] < felt[2] < felt[3],
            max(felt[:3]) < last <= NEIGHBOUR_ENDS < felt[3],
        ],
        felt=[
            f"{run.tower.particles} particles {f'at {at:.2f} t0' if math.isfinite(at) else 'never'}"
            for run, at in zip(runs, felt, strict=True)
        ],
        span=runs[0].time_over_t0[-1],
        packets=len(packets),
        last=last,
    )


def base_felt(run: TowerRun, tall: TowerRun) -> float:
    """Return when the grain's force first differs from that in ``tall`` [t0], infinite if never.

    By :data:`SEEN` of the peak. Both runs need the same grain, as t0 is theirs.
    """
    grid, one, other = _on_one_grid(run, tall)
    apart = np.flatnonzero(np.abs(one - other) > SEEN * other.max())
    return float(grid[apart[0]]) if apart.size else math.inf


def largest_difference(one: TowerRun, other: TowerRun) -> float:
    """Return the largest difference of the forces on the grain at one t/t0 [N]."""
    _, first, second = _on_one_grid(one, other)
    return float(np.abs(first - second).max())


def _on_one_grid(one: TowerRun, other: TowerRun) -> list[NDArray[np.float64]]:
    """Return common times [t0], and both forces there [N]."""
    grid = np.linspace(0, min(one.time_over_t0[-1], other.time_over_t0[-1]), 6001)
    forces = [np.interp(grid, run.time_over_t0, run.grain_force) for run in (one, other)]
    return [grid, *forces]
