"""Figures 1, 10, 11 and 13: impulse ratio and critical angle against height."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.cases.tower.impulse_angles import energy_scaling_angles
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints
from harness.parameters.tower import Tower
from harness.reproduction.claims import Fact, Statement, claim_of_facts, untestable
from harness.theory.energy_scaling import LARGEST_HEIGHT

HALVED = (0.4, 0.6)
"""What "nearly halve" may mean for alpha on the plateau."""

FLAT = 0.01
"""Of alpha, and of the angle over its first: what a figure shows of a plateau or a rise."""

PUBLISHED = f"{PEYNEAU_ROUX.value_deg:g} +- {PEYNEAU_ROUX.uncertainty_deg:g} deg"
_LOWEST = PEYNEAU_ROUX.value_deg - PEYNEAU_ROUX.uncertainty_deg


def thin_layers(reference: ReferencePoints | None) -> Statement:
    """Return the row of the measured angles: others' points, tested only if the user gives them."""
    published = f"the published angle, {PUBLISHED} ({PEYNEAU_ROUX.citation})."
    if reference is None:
        return untestable("fig-1", computed=f"Nothing was measured here: drawn is {published}")
    angles = np.array(reference.angles_deg)[np.argsort(reference.heights)]
    return claim_of_facts("fig-1", name=reference.name, angles=angles, published=published)


def impulse_ratio(frame: pd.DataFrame) -> Statement:
    """Judge alpha(n) of the source's six runs."""
    runs = list(curves(frame, "impulse_ratio"))
    low, high = (pick(run.plateau for run in runs) for pick in (min, max))
    halved = low > HALVED[0] and high < HALVED[1]
    return _row("fig-10", runs, "", [(halved, f"the plateau is {low:.3f} to {high:.3f}")])


def critical_angles(frame: pd.DataFrame, reference: ReferencePoints | None) -> Statement:
    """Judge theta_c(n) of the six runs and say what the source's other formula makes of it."""
    runs = list(curves(frame, "critical_angle_lost_deg"))
    plateaus, other = (
        [pick(run.plateau for run in some) for pick in (min, max)]
        for some in (runs, list(curves(frame, "critical_angle_kept_deg")))
    )
    points = "Perrin's points are not here, so that agreement is not tested."
    if reference is not None:
        mean = np.mean([run.values for run in runs], axis=0)
        ours = np.interp(reference.heights, runs[0].heights, mean)
        off = float(np.sqrt(np.mean((np.array(reference.angles_deg) - ours) ** 2)))
        points = f"{reference.name} lies {off:.2f} deg away (r.m.s.)."
    return _row(
        "fig-11",
        runs,
        " deg",
        first=runs[0].values[0],
        plateaus=plateaus,
        reaches="below" if plateaus[-1] < _LOWEST else "reaching",
        published=PUBLISHED,
        other=other,
        points=points,
    )


def energy_scaling() -> tuple[pd.DataFrame, Statement]:
    """Return the angles of alpha = 1/sqrt(n), and whether they fall without an asymptote."""
    scaling = energy_scaling_angles()
    angles = scaling["critical_angle_lost_deg"].to_numpy()
    below = scaling["height"][angles < _LOWEST]
    remark = (
        f"It stays above {_LOWEST:.2f} deg, the published angle less its uncertainty, throughout."
    )
    if len(below):
        remark = (
            f"It is below the published {PUBLISHED} from n = {below.iloc[0]} on, long before ten."
        )
    return scaling, claim_of_facts("fig-13", angles=angles, remark=remark)


def _row(
    key: str, runs: list[Curve], unit: str, others: list[Fact] | None = None, **numbers: Any
) -> Statement:
    """Return the row of runs that fall: corrected if only those that rise are in the way."""
    falling, rising = [r for r in runs if r.falls], [r for r in runs if not r.falls]
    facts: list[Fact] = []
    if falling:
        first, last = (pick(run.level_from for run in falling) for pick in (min, max))
        told = f"{first} to {last}" if last != first else f"{first}"
        text = f"{len(falling)} of {len(runs)} runs fall and are level from n = {told} on"
        facts.append((last <= LARGEST_HEIGHT, f"{text} (source: about {LARGEST_HEIGHT})"))
    facts += [(False, _rising(run, falling, unit)) for run in rising]
    facts += others or []
    return claim_of_facts(
        key,
        facts,
        corrected_holds=bool(falling) and sum(not held for held, _ in facts) == len(rising),
        correction=f"not for {'; '.join(run.name for run in rising)}",
        **numbers,
    )


def _rising(run: Curve, falling: list[Curve], unit: str) -> str:
    """Return how far a run rises, where, and how long its window is there."""
    row = int(run.rises.argmax())
    others = [other.windows[row] for other in falling]
    beside = f" (others {min(others):.1f} to {max(others):.1f})" if others else ""
    return (
        f"{run.name}: rises by {run.rise:.2f}{unit} on its way, to {run.values[row]:.2f}{unit} at "
        f"n = {run.heights[row]}, where its window is {run.windows[row]:.1f} t0{beside}; "
        f"level from {run.level_from} on"
    )


class Curve(NamedTuple):
    """One run over height: plateau at the tallest, and what disturbs the way to it."""

    name: str
    heights: NDArray[np.int64]
    values: NDArray[np.float64]
    windows: NDArray[np.float64]  # [t0]

    @property
    def plateau(self) -> float:
        """Return the value of the tallest tower."""
        return float(self.values[-1])

    @property
    def level_from(self) -> int:
        """Return the first height from which on all values are within FLAT of the plateau."""
        off = np.flatnonzero(np.abs(self.values - self.values[-1]) > FLAT * self.values[0])
        return int(self.heights[off[-1] + 1]) if off.size else int(self.heights[0])

    @property
    def rises(self) -> NDArray[np.float64]:
        """Return how far each value stands above that of any smaller height."""
        return np.asarray(self.values - np.minimum.accumulate(self.values))

    @property
    def rise(self) -> float:
        """Return the largest rise above any smaller height's value."""
        return float(self.rises.max())

    @property
    def falls(self) -> bool:
        """Return whether it ends lower than it begins and nowhere rises by more than FLAT."""
        limit = FLAT * float(self.values[0])
        return self.rise <= limit and self.plateau < self.values[0] - limit


def curves(frame: pd.DataFrame, column: str) -> Iterator[Curve]:
    """Yield the source's law's runs of a table of impulses, each against height."""
    part = frame[frame["law"] == Tower().law]
    for (k, v), run in part.groupby(["stiffness_N_per_m", "speed_m_per_s"], sort=False):
        ordered = run.sort_values("height")
        height, value, window = (ordered[n].to_numpy() for n in ("height", column, "window_s"))
        t0 = Tower(stiffness=k, speed=v).contact_time
        yield Curve(f"k = {k:.0e} N/m, {v:g} m/s".replace("e+0", "e"), height, value, window / t0)
