"""Figures 15 and 16: the two windows over which the source sums up the impulse."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pandas as pd

from harness.cases.tower.impulse_angles import READINGS, angle_from_impulse_ratio
from harness.cases.tower.run import tower
from harness.errors import RequestError
from harness.observables.impulse import impulse_until
from harness.observables.tower import TowerRun
from harness.observables.windows import SEARCH, structure_end, turnaround
from harness.parameters.tower import LAWS, Law, Tower
from harness.reproduction.claims import Statement
from harness.reproduction.facts import all_hold, claim_of_facts
from harness.reproduction.source import SOURCES

HEIGHTS = range(1, 7)
"""Two to seven particles."""

LITERAL, LOOSER = "all n contacts", "two contacts or more"
"""What the chain must have held before it swings to one: the source's words, and a looser one."""

_LEAST = {LITERAL: None, LOOSER: 2}
SOURCE_LAW = Tower().law


@dataclass(frozen=True)
class WindowChoice:
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
    rows = [row for law in LAWS for row in _of_law(law)]
    frame = pd.DataFrame(rows)
    exist = {
        (law, held): [int(n) for n in part["height"]]
        for (law, held), part in frame.dropna().groupby(["law", "held"])
    }
    literal, looser = (exist.get((SOURCE_LAW, held), []) for held in (LITERAL, LOOSER))
    overlap = exist.get(("overlap", LITERAL), []), exist.get(("overlap", LOOSER), [])
    every = list(HEIGHTS)
    ours = frame[(frame["law"] == SOURCE_LAW)].set_index(["held", "height"])
    angles = ours["critical_angle_lost_deg"]
    facts = [
        (
            literal == every,
            f"under the deformable law the window exists for n = {_list(literal)} of "
            f"{every[0]} to {every[-1]}, with {_angles(angles[LITERAL])} deg",
        ),
        (overlap[0] == every, f"under the overlap law for n = {_list(overlap[0])}"),
    ]
    remark = (
        f"If a chain of two contacts or more may swing to one, it exists for n = {_list(looser)} "
        f"(overlap law {_list(overlap[1])}), with {_angles(angles[LOOSER])} deg; where both exist "
        f"they are {'the same' if _same(ours) else 'not the same'}. "
        "How well it fits Perrin's points cannot be tested without them."
    )
    return frame, claim_of_facts(
        SOURCES["fig-15"], facts, remark, holds=all_hold(facts[:1]), corrected_holds=looser == every
    )


def window_selection() -> tuple[tuple[WindowChoice, ...], Statement]:
    """Return three and four particles with their largest compression, and what it says.

    The source's text names three particles, the caption of its figure four.
    """
    choices = tuple(_choice(height) for height in (2, 3))
    facts = [
        (
            0 < choice.largest_compression < SEARCH,
            f"{choice.run.tower.particles} particles are compressed most at "
            f"{choice.largest_compression:.3f} t0, which makes a window of "
            f"{2 * choice.largest_compression:.3f} t0"
            + (
                f" (the contacts' window: {choice.structure:.3f})"
                if math.isfinite(choice.structure)
                else ""
            ),
        )
        for choice in choices
    ]
    forces = [float(c.run.time_over_t0[int(c.run.grain_force.argmax())]) for c in choices]
    return choices, claim_of_facts(
        SOURCES["fig-16"],
        facts,
        "The source's text says three particles, its caption four: both are shown. The grain's "
        "own compression is its force over k and peaks at "
        f"{forces[0]:.3f} and {forces[1]:.3f} t0; taken is that of the chain.",
    )


def _of_law(law: Law) -> list[dict[str, object]]:
    rows = []
    runs = {n: tower(Tower(height=n, law=law), solver="exact", profiles=True) for n in HEIGHTS}
    for held, least in _LEAST.items():
        single = impulse_until(runs[1], _structure(runs[1], least))
        for height, run in runs.items():
            end = _structure(run, least)
            ratio = impulse_until(run, end) / single if math.isfinite(end) else math.nan
            angles = {
                f"critical_angle_{reading}_deg": angle_from_impulse_ratio(ratio, reading)
                for reading in READINGS
            }
            window = end / run.tower.contact_time
            rows.append(
                {"law": law, "held": held, "height": height, "window_t0": window}
                | {"impulse_ratio": ratio, **angles}
            )
    return rows


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


def _same(ours: pd.DataFrame) -> bool:
    ends = ours["window_t0"].unstack("held").dropna()
    return bool((ends[LITERAL] == ends[LOOSER]).all())


def _list(heights: list[int]) -> str:
    if len(heights) > 2 and heights == list(range(heights[0], heights[-1] + 1)):
        return f"{heights[0]} to {heights[-1]}"
    return " and ".join(str(n) for n in heights) or "none"


def _angles(angles: pd.Series) -> str:
    return ", ".join(f"{angle:.2f}" for angle in angles.dropna())
