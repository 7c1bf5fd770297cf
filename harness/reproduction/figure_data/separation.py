"""Figure 14: when the grain feels more than its neighbour."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from harness.observables.summary import grain_alone
from harness.observables.tower import TowerRun
from harness.reproduction.claims import Statement
from harness.reproduction.facts import claim_of_facts
from harness.reproduction.source import SOURCES

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
