"""Figures 15 and 16: the two windows over which the source sums up the impulse."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd

from harness.cases.tower.impulse_angles import READINGS, angle_from_impulse_ratio
from harness.cases.tower.run import tower
from harness.errors import RequestError
from harness.observables.impulse import impulse_until
from harness.observables.tower import TowerRun
from harness.observables.windows import SEARCH, structure_end, turnaround
from harness.parameters.tower import LAWS, Law, Tower
from harness.reproduction.claims import Statement, claim_of_facts

HEIGHTS = range(1, 7)
"""Two to seven particles."""

LITERAL, LOOSER = "all n contacts", "two contacts or more"
"""What the chain must have held before it swings to one: the source's words, and a looser one."""

_LEAST = {LITERAL: None, LOOSER: 2}


class WindowChoice(NamedTuple):
    """A tower with the time of its largest compression and, where it exists, the structure window.

    Times in t0; ``structure`` is NaN where the window does not exist.
    """

    run: TowerRun
    largest_compression: float
    structure: float


def structure_window() -> tuple[pd.DataFrame, Statement]:
    """Return the structure window's ends, impulse ratios and angles, by law and reading.

    Columns law, held (the reading), height, window_t0, impulse_ratio and the
    angles of both readings of the shock; NaN where the window does not exist
    within 3 t0.
    """
    frame = pd.DataFrame([row for law in LAWS for row in _of_law(law)])
    exists = frame.dropna()
    heights = {
        run: [int(n) for n in part["height"]] for run, part in exists.groupby(["law", "held"])
    }
    own = Tower().law
    angles = {held: exists[(exists["law"] == own) & (exists["held"] == held)] for held in _LEAST}
    ends = [angles[held].set_index("height")["window_t0"] for held in _LEAST]
    both = ends[0].index.intersection(ends[1].index)
    return frame, claim_of_facts(
        "fig-15",
        literal=heights[own, LITERAL],
        looser=heights[own, LOOSER],
        overlap=[heights["overlap", held] for held in _LEAST],
        every=list(HEIGHTS),
        listed=_listed,
        angles=[angles[held]["critical_angle_lost_deg"].to_numpy() for held in _LEAST],
        same="the same" if (ends[0][both] == ends[1][both]).all() else "not the same",
    )


def _of_law(law: Law) -> Iterator[dict[str, object]]:
    runs = {n: tower(Tower(height=n, law=law), solver="exact", profiles=True) for n in HEIGHTS}
    for held, least in _LEAST.items():
        single = impulse_until(runs[1], _structure(runs[1], least))
        for height, run in runs.items():
            end = _structure(run, least)
            ratio = impulse_until(run, end) / single if math.isfinite(end) else math.nan
            yield {
                "law": law,
                "held": held,
                "height": height,
                "window_t0": end / run.tower.contact_time,
                "impulse_ratio": ratio,
            } | {
                f"critical_angle_{reading}_deg": angle_from_impulse_ratio(ratio, reading)
                for reading in READINGS
            }


def window_selection() -> tuple[tuple[WindowChoice, ...], Statement]:
    """Return three and four particles with their largest compression, and what it says.

    The source's text names three particles, the caption of its figure four.
    """
    choices = tuple(_choice(height) for height in (2, 3))
    facts = []
    for choice in choices:
        at = choice.largest_compression
        said = f"{choice.run.tower.particles} particles are compressed most at {at:.3f} t0"
        said += f", which makes a window of {2 * at:.3f} t0"
        if math.isfinite(choice.structure):
            said += f" (the contacts' window: {choice.structure:.3f})"
        facts.append((0 < at < SEARCH, said))
    forces = [float(c.run.time_over_t0[int(c.run.grain_force.argmax())]) for c in choices]
    return choices, claim_of_facts("fig-16", facts, forces=forces)


def _choice(height: int) -> WindowChoice:
    run = tower(Tower(height=height), solver="exact", profiles=True)
    t0 = run.tower.contact_time
    return WindowChoice(run, turnaround(run) / t0, _structure(run, None) / t0)


def _structure(run: TowerRun, least: int | None) -> float:
    """Return the end of the structure window [s], NaN where there is none."""
    try:
        return structure_end(run, least)
    except RequestError:
        return math.nan


def _listed(heights: list[int]) -> str:
    if len(heights) > 2 and heights == list(range(heights[0], heights[-1] + 1)):
        return f"{heights[0]} to {heights[-1]}"
    return " and ".join(str(n) for n in heights) or "none"
