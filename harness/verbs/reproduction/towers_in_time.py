"""Figures 8, 9 and 14: the force on the grain and its chain of contacts in time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harness.comparison.ledger import Statement, claim
from harness.comparison.source_figures import FIGURES, TowersInTime
from harness.observables.felt_contacts import chain_changes, felt_contacts, grain_alone
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower
from harness.verbs.impulses import HEIGHTS, STIFFNESSES
from harness.verbs.reproduction.sentences import Fact, agreement, all_hold
from harness.verbs.towers import tower

PARTICLES = (2, 3, 10, 20)
SEPARATED = (2, 3, 4, 20)
STORY = {"the third joins": 0.5, "the grain comes back": 1.0, "the grain leaves": 1.5}
"""[t0] What the source reads off its three particles, to half a t0."""

NEIGHBOUR_ENDS = 1.5  # [t0] the source's end of the contacts with the neighbour
CONTACTS_SAID = 10  # the most contacts the source sees, about
COLLAPSED_HEIGHT = 9

SEEN = 0.01
"""Of the peak: what a figure shows."""

ALIKE = 1e-6
"""Of the peak: the part of a force that other figures call felt."""


def towers_in_time() -> tuple[TowersInTime, tuple[Statement, Statement, Statement]]:
    """Run the towers of the three figures; return them with the statements 8, 9 and 14."""
    runs = {height: _run(height) for height in HEIGHTS}
    tall = _run(2 * max(HEIGHTS))
    largest = max(float(run.grain_force.max()) for run in runs.values())
    shown = tuple(runs[n - 1] for n in PARTICLES)
    collapsed = tuple(
        tower(Tower(height=COLLAPSED_HEIGHT, stiffness=k), solver="exact", profiles=True)
        for k in STIFFNESSES
    )
    separated = tuple(runs[n - 1] for n in SEPARATED)
    felt = tuple(base_felt(run, tall) for run in separated)
    evidence = TowersInTime(shown, largest, collapsed, separated, felt)
    return evidence, (
        _force_and_contacts(shown, largest),
        _collapse(collapsed),
        _separation(separated, felt),
    )


def _run(height: int) -> TowerRun:
    return tower(Tower(height=height), solver="exact", profiles=True)


def story(run: TowerRun) -> dict[str, float]:
    """Return when the tower of three does what :data:`STORY` names [t0], and is alone, NaN if not.

    Raise ValueError for a tower of another height.
    """
    if run.tower.height != 2:
        raise ValueError(f"height = {run.tower.height}: the story is that of three particles")
    joins = [time for time, contacts in chain_changes(run) if contacts == 2]
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
    apart = _largest_difference(shown[2], shown[3]) / largest
    facts.append(
        (apart < SEEN, f"the forces of 10 and 20 particles differ by {_below(apart)} of the peak")
    )
    longest = [int(felt_contacts(run).max()) for run in shown]
    figure = FIGURES["fig-8"]
    return claim(
        figure.source,
        holds=all_hold(facts),
        computed=agreement(
            facts,
            f"The longest chain of the grain has {longest[2]} and {longest[3]} contacts in 10 and "
            f"20 particles (source: about {CONTACTS_SAID}).",
        ),
        evidence=figure.evidence,
        why="the source gives these times to half a t0, to which ours are rounded; "
        "a hundredth of the peak is what a figure shows",
    )


def _collapse(runs: Sequence[TowerRun]) -> Statement:
    """Judge by how much scaling brings runs an order of rigidity apart closer together."""
    pairs = list(itertools.pairwise(runs))
    before = max(_spread(pair, scaled=False) for pair in pairs)
    after = max(_spread(pair, scaled=True) for pair in pairs)
    events = [
        [time for time, _ in chain_changes(run) if SEEN < time < NEIGHBOUR_ENDS] for run in runs
    ]
    same = len({len(times) for times in events}) == 1
    shift = float(np.ptp(np.array(events), axis=0).max()) if same else math.nan
    gammas = [run.tower.gamma for run in runs]
    facts = [
        (
            after < 0.1 * before,
            "the mean difference of the forces of neighbours falls from "
            f"{100 * before:.0f} % to {100 * after:.1f} % of their mean when time is in t0 and "
            "force in v0 sqrt(k m)",
        ),
        (
            same and shift < 10 * SEEN,
            f"the contacts change in the same order, {shift:.3f} t0 apart at most",
        ),
    ]
    figure = FIGURES["fig-9"]
    return claim(
        figure.source,
        holds=all_hold(facts),
        computed=agreement(
            facts,
            f"What is left is gravity's: Gamma goes from {gammas[0]:.2g} to {gammas[-1]:.2g}.",
        ),
        evidence=figure.evidence,
        why="a collapse leaves less than a tenth of the difference; 10 particles, 2 m/s, until "
        f"{NEIGHBOUR_ENDS:g} t0",
    )


def _spread(pair: tuple[TowerRun, TowerRun], *, scaled: bool) -> float:
    """Return the mean difference of two forces over their mean, against scaled or bare axes."""
    times = [run.time_over_t0 if scaled else run.time for run in pair]
    last = NEIGHBOUR_ENDS * (1 if scaled else max(run.tower.contact_time for run in pair))
    grid = np.linspace(0, last, 3001)
    forces = [
        np.interp(grid, t, run.grain_force / (run.tower.speed * run.tower.omega if scaled else 1))
        for t, run in zip(times, pair, strict=True)
    ]
    return float(np.abs(forces[0] - forces[1]).mean() / np.mean(forces))


def _separation(runs: Sequence[TowerRun], felt: Sequence[float]) -> Statement:
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
    figure = FIGURES["fig-14"]
    return claim(
        figure.source,
        holds=all_hold(facts),
        computed=agreement(facts),
        evidence=figure.evidence,
        why="the base is felt when the force leaves that of a tower twice as tall as the tallest "
        f"by {100 * SEEN:g} % of its peak",
    )


def base_felt(run: TowerRun, tall: TowerRun) -> float:
    """Return when the grain's force first differs from that in ``tall`` [t0], infinite if never.

    By :data:`SEEN` of the peak. Both runs need the same grain, as t0 is theirs.
    """
    grid, forces = _on_one_grid(run, tall)
    apart = np.flatnonzero(np.abs(forces[0] - forces[1]) > SEEN * forces[1].max())
    return float(grid[apart[0]]) if apart.size else math.inf


def _largest_difference(one: TowerRun, other: TowerRun) -> float:
    _, forces = _on_one_grid(one, other)
    return float(np.abs(forces[0] - forces[1]).max())


def _on_one_grid(
    one: TowerRun, other: TowerRun
) -> tuple[NDArray[np.float64], list[NDArray[np.float64]]]:
    grid = np.linspace(0, min(one.time_over_t0[-1], other.time_over_t0[-1]), 6001)
    return grid, [np.interp(grid, run.time_over_t0, run.grain_force) for run in (one, other)]


def _below(part: float) -> str:
    return f"{part:.1e}" if part > ALIKE else f"less than {ALIKE:.0e}"
