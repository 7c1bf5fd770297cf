"""Figures 8 and 14: the force on the grain and its chain of contacts in time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from harness.cases.tower.impulse_table import HEIGHTS
from harness.cases.tower.run import tower
from harness.observables.significant_contacts import significant_contacts
from harness.observables.summary import contact_changes, grain_alone
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement
from harness.reproduction.facts import Fact, claim_of_facts
from harness.reproduction.figure_data.separation import (
    SEEN,
    base_felt,
    largest_difference,
    separation,
)
from harness.reproduction.source import SOURCES

PARTICLES = (2, 3, 10, 20)
SEPARATED = (2, 3, 4, 20)
STORY = {"the third joins": 0.5, "the grain comes back": 1.0, "the grain leaves": 1.5}
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


def story(run: TowerRun) -> dict[str, float]:
    """Return when the tower of three does what :data:`STORY` names [t0], and is alone, NaN if not.

    Raise ValueError for a tower of another height.
    """
    if run.tower.height != 2:
        raise ValueError(f"height = {run.tower.height}: the story is that of three particles")
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
    found = story(shown[1])
    facts: list[Fact] = [
        (
            round(2 * found[event]) / 2 == said if math.isfinite(found[event]) else False,
            f"{event} at {found[event]:.2f} t0 (source {said:g})",
        )
        for event, said in STORY.items()
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
