"""Figures 8 and 14: the force on the grain and its chain of contacts, and what it feels when."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.cases.tower.impulse_table import HEIGHTS
from harness.cases.tower.run import tower
from harness.observables.significant_contacts import significant_contacts
from harness.observables.summary import contact_changes, grain_alone
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement
from harness.reproduction.facts import Fact, claim_of_facts
from harness.reproduction.source import SOURCES

PARTICLES = (2, 3, 10, 20)
SEPARATED = (2, 3, 4, 20)
EVENTS = {"the third joins": 0.5, "the grain comes back": 1.0, "the grain leaves": 1.5}
"""[t0] What the source reads off its three particles, to half a t0."""

CONTACTS_SAID = 10  # the most contacts the source sees, about

ALIKE = 1e-6
"""Of the peak: the part of a force that other figures call felt."""


@dataclass(frozen=True)
class TowersInTime:
    """Towers of several heights over time, and the largest force on the grain of all [N].

    ``shown`` and ``separated`` are those of the two figures.
    """

    shown: tuple[TowerRun, ...]
    largest_force: float
    separated: tuple[TowerRun, ...]
    base_felt: tuple[float, ...]  # [t0], for each of ``separated``; infinite if not in the run


def towers_in_time() -> tuple[TowersInTime, tuple[Statement, Statement]]:
    """Run the towers of all heights; return those of the figures with the statements 8 and 14."""
    runs = {height: _run(height) for height in HEIGHTS}
    tall = _run(2 * max(HEIGHTS))
    largest = max(float(run.grain_force.max()) for run in runs.values())
    shown = tuple(runs[n - 1] for n in PARTICLES)
    separated = tuple(runs[n - 1] for n in SEPARATED)
    felt = tuple(base_felt(run, tall) for run in separated)
    evidence = TowersInTime(shown, largest, separated, felt)
    return evidence, (_force_and_contacts(shown, largest), separation(separated, felt))


def _run(height: int) -> TowerRun:
    return tower(Tower(height=height), solver="exact", profiles=True)


def event_times(run: TowerRun) -> dict[str, float]:
    """Return when the tower of three does what :data:`EVENTS` names [t0], and is alone, NaN if not.

    Raise ValueError for a tower of another height.
    """
    if run.tower.height != 2:
        raise ValueError(f"height = {run.tower.height}: the events are those of three particles")
    joins = [time for time, contacts in contact_changes(run) if contacts == 2]
    alone = grain_alone(run)
    back = alone[0][1] if len(alone) > 1 else math.nan
    return {
        "the third joins": joins[0] if joins else math.nan,
        "the grain is alone": alone[0][0] if alone else math.nan,
        "the grain comes back": back,
        "the grain leaves": alone[-1][0] if len(alone) > 1 else math.nan,
    }


def _force_and_contacts(shown: Sequence[TowerRun], largest: float) -> Statement:
    found = event_times(shown[1])
    facts: list[Fact] = [
        (
            round(2 * found[event]) / 2 == said if math.isfinite(found[event]) else False,
            f"{event} at {found[event]:.2f} t0 (source {said:g})",
        )
        for event, said in EVENTS.items()
    ]
    facts.insert(
        1,
        (
            math.isfinite(found["the grain is alone"]),
            f"the grain is alone from {found['the grain is alone']:.2f} t0",
        ),
    )
    apart = largest_difference(shown[2], shown[3]) / largest
    facts.append(
        (apart < SEEN, f"the forces of 10 and 20 particles differ by {_below(apart)} of the peak")
    )
    longest = [int(significant_contacts(run).max()) for run in shown]
    return claim_of_facts(
        SOURCES["fig-8"],
        facts,
        f"The longest chain of the grain has {longest[2]} and {longest[3]} contacts in 10 and "
        f"20 particles (source: about {CONTACTS_SAID}).",
    )


def _below(part: float) -> str:
    return f"{part:.1e}" if part > ALIKE else f"less than {ALIKE:.0e}"


NEIGHBOUR_ENDS = 1.5  # [t0] the source's end of the contacts with the neighbour

SEEN = 0.01
"""Of the peak: what a figure shows."""


def separation(runs: Sequence[TowerRun], felt: Sequence[float]) -> Statement:
    """Judge whether the base is felt later in longer chains, and where the neighbour's part ends.

    ``felt`` are the times of :func:`base_felt` of ``runs`` [t0], the longest chain last.
    """
    said = [
        f"{run.tower.particles} particles {f'at {at:.2f} t0' if math.isfinite(at) else 'never'}"
        for run, at in zip(runs, felt, strict=True)
    ]
    packets = grain_alone(runs[-1])
    last = packets[-1][0]
    facts = [
        (
            felt[0] < felt[1] < felt[2] < felt[3],
            f"the grain feels the base the later, the longer the chain ({', '.join(said)}, within "
            f"{runs[0].time_over_t0[-1]:.0f} t0)",
        ),
        (
            max(felt[:3]) < last <= NEIGHBOUR_ENDS < felt[3],
            f"the contacts with the neighbour alone, {len(packets)} packets in 20 particles, end "
            f"at {last:.2f} t0, before the base is felt there, and after it in the short chains",
        ),
    ]
    return claim_of_facts(SOURCES["fig-14"], facts)


def base_felt(run: TowerRun, tall: TowerRun) -> float:
    """Return when the grain's force first differs from that in ``tall`` [t0], infinite if never.

    By :data:`SEEN` of the peak. Both runs need the same grain, as t0 is theirs.
    """
    grid, forces = _on_one_grid(run, tall)
    apart = np.flatnonzero(np.abs(forces[0] - forces[1]) > SEEN * forces[1].max())
    return float(grid[apart[0]]) if apart.size else math.inf


def largest_difference(one: TowerRun, other: TowerRun) -> float:
    """Return the largest difference of the forces on the grain at one t/t0 [N]."""
    _, forces = _on_one_grid(one, other)
    return float(np.abs(forces[0] - forces[1]).max())


def _on_one_grid(
    one: TowerRun, other: TowerRun
) -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]:
    grid = np.linspace(0, min(one.time_over_t0[-1], other.time_over_t0[-1]), 6001)
    return grid, [np.interp(grid, run.time_over_t0, run.grain_force) for run in (one, other)]
