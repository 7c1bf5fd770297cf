"""Figures 1, 10, 11 and 13: impulse ratio and critical angle against height."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.cases.tower.impulse_angles import energy_scaling_angles
from harness.observables.reference import PEYNEAU_ROUX, ReferencePoints
from harness.parameters.tower import Tower
from harness.reproduction.claims import Statement, untestable
from harness.reproduction.facts import Fact, claim_of_facts
from harness.reproduction.source import SOURCES
from harness.theory.energy_scaling import LARGEST_HEIGHT

HALVED = (0.4, 0.6)
"""What "nearly halve" may mean for alpha on the plateau."""


def thin_layers(reference: ReferencePoints | None) -> Statement:
    """Return the row of the measured angles: others' points, tested only if the user gives them."""
    published = (
        f"{PEYNEAU_ROUX.value_deg:g} +- {PEYNEAU_ROUX.uncertainty_deg:g} deg "
        f"({PEYNEAU_ROUX.citation})"
    )
    if reference is None:
        return untestable(
            SOURCES["fig-1"],
            "an experiment of others (Perrin et al. 2021), whose points the source does not list; "
            "give them as a CSV with h_over_d and theta_deg",
            computed=f"Nothing was measured here: drawn is the published angle, {published}.",
        )
    order = np.argsort(reference.heights)
    angles = np.array(reference.angles_deg)[order]
    facts = [
        (
            bool(angles[-1] < angles[0]),
            f"in {reference.name} the angle goes from {angles[0]:.2f} deg, lowest, to "
            f"{angles[-1]:.2f} deg, highest",
        )
    ]
    return claim_of_facts(SOURCES["fig-1"], facts, f"Beside it the published angle, {published}.")


def impulse_ratio(frame: pd.DataFrame) -> Statement:
    """Judge alpha(n) of the source's six runs."""
    runs = list(curves(frame, "impulse_ratio"))
    plateaus = [run.plateau for run in runs]
    facts = [
        *_falling(runs, ""),
        (
            min(plateaus) > HALVED[0] and max(plateaus) < HALVED[1],
            f"the plateau is {min(plateaus):.3f} to {max(plateaus):.3f}",
        ),
    ]
    return _row("fig-10", facts, runs)


def critical_angles(frame: pd.DataFrame, reference: ReferencePoints | None) -> Statement:
    """Judge theta_c(n) of the six runs and say what the source's other formula makes of it."""
    runs = list(curves(frame, "critical_angle_lost_deg"))
    other = list(curves(frame, "critical_angle_kept_deg"))
    plateaus = sorted(run.plateau for run in runs)
    low = PEYNEAU_ROUX.value_deg - PEYNEAU_ROUX.uncertainty_deg
    remark = (
        f"From {runs[0].values[0]:.2f} deg it comes to {plateaus[0]:.2f} to {plateaus[-1]:.2f} "
        f"deg, {'below' if plateaus[-1] < low else 'reaching'} the published "
        f"{PEYNEAU_ROUX.value_deg:g} +- {PEYNEAU_ROUX.uncertainty_deg:g} deg; under the source's "
        f"other formula, v alpha, to {min(r.plateau for r in other):.2f} to "
        f"{max(r.plateau for r in other):.2f} deg. "
    )
    if reference is None:
        remark += "Perrin's points are not here, so that agreement is not tested."
    else:
        remark += f"{reference.name} lies {_distance(runs, reference):.2f} deg away (r.m.s.)."
    return _row("fig-11", _falling(runs, " deg"), runs, remark)


def energy_scaling() -> tuple[pd.DataFrame, Statement]:
    """Return the angles of alpha = 1/sqrt(n), and whether they fall without an asymptote."""
    scaling = energy_scaling_angles()
    angles = scaling.set_index("height")["critical_angle_lost_deg"]
    steps = np.diff(angles.to_numpy())
    ten, tallest = float(angles[LARGEST_HEIGHT]), float(angles.iloc[-1])
    low = PEYNEAU_ROUX.value_deg - PEYNEAU_ROUX.uncertainty_deg
    below = angles.index[angles < low]
    facts = [
        (
            bool((steps < 0).all()),
            f"theta_c falls at every height, from {angles.iloc[0]:.2f} deg to {ten:.2f} deg at "
            f"{LARGEST_HEIGHT}",
        ),
        (
            ten - tallest > FLAT * float(angles.iloc[0]),
            f"it goes on to {tallest:.2f} deg at {angles.index[-1]}, without an asymptote",
        ),
    ]
    remark = f"It stays above {low:.2f} deg, the published angle less its uncertainty, throughout."
    if len(below):
        remark = (
            f"It is below the published {PEYNEAU_ROUX.value_deg:g} +- "
            f"{PEYNEAU_ROUX.uncertainty_deg:g} deg from n = {below[0]} on, long before ten."
        )
    return scaling, claim_of_facts(SOURCES["fig-13"], facts, remark)


def _falling(runs: list[Curve], unit: str) -> list[Fact]:
    """Return which runs fall and which rise on the way, and from which height they are level."""
    falling, rising = [r for r in runs if r.falls], [r for r in runs if not r.falls]
    facts: list[Fact] = []
    if falling:
        first, last = (f(run.level_from for run in falling) for f in (min, max))
        facts.append(
            (
                last <= LARGEST_HEIGHT,
                f"{len(falling)} of {len(runs)} runs fall and are level from n = "
                f"{first}{f' to {last}' if last != first else ''} on "
                f"(source: about {LARGEST_HEIGHT})",
            )
        )
    facts += [(False, _rising(run, falling, unit)) for run in rising]
    return facts


def _rising(run: Curve, falling: list[Curve], unit: str) -> str:
    """Return how far a run rises, where, and how long its window is there."""
    row = run.row_of_rise
    others = [other.windows[row] for other in falling]
    beside = f" (others {min(others):.1f} to {max(others):.1f})" if others else ""
    return (
        f"{run.name}: rises by {run.rise:.2f}{unit} on its way, to {run.values[row]:.2f}{unit} at "
        f"n = {run.heights[row]}, where its window is {run.windows[row]:.1f} t0{beside}; "
        f"level from {run.level_from} on"
    )


def _row(key: str, facts: list[Fact], runs: list[Curve], remark: str = "") -> Statement:
    """Return the row: corrected if only the runs that rise are in the way."""
    wrong = [run.name for run in runs if not run.falls]
    return claim_of_facts(
        SOURCES[key],
        facts,
        remark,
        corrected_holds=len(wrong) < len(runs) and sum(not h for h, _ in facts) == len(wrong),
        correction=f"not for {'; '.join(wrong)}",
    )


def _distance(runs: list[Curve], reference: ReferencePoints) -> float:
    """Return how far points are from the mean of our runs, root mean square [deg]."""
    mean = np.mean([run.values for run in runs], axis=0)
    ours = np.interp(reference.heights, runs[0].heights, mean)
    return float(np.sqrt(np.mean((np.array(reference.angles_deg) - ours) ** 2)))


SOURCE_LAW = Tower().law
FLAT = 0.01
"""Of alpha, and of the angle over its first: what a figure shows of a plateau or a rise."""


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
    def rise(self) -> float:
        """Return the largest rise above any smaller height's value."""
        return float((self.values - np.minimum.accumulate(self.values)).max())

    @property
    def row_of_rise(self) -> int:
        """Return where in the arrays it has risen most."""
        return int((self.values - np.minimum.accumulate(self.values)).argmax())

    @property
    def falls(self) -> bool:
        """Return whether it ends lower than it begins and nowhere rises by more than FLAT."""
        limit = FLAT * float(self.values[0])
        return self.rise <= limit and self.plateau < self.values[0] - limit


def curves(frame: pd.DataFrame, column: str) -> Iterator[Curve]:
    """Yield the source's law's runs of a table of impulses, each against height."""
    part = frame[frame["law"] == SOURCE_LAW]
    for (k, v), run in part.groupby(["stiffness_N_per_m", "speed_m_per_s"], sort=False):
        ordered = run.sort_values("height")
        height, value, window = (ordered[n].to_numpy() for n in ("height", column, "window_s"))
        t0 = Tower(stiffness=k, speed=v).contact_time
        yield Curve(f"k = {k:.0e} N/m, {v:g} m/s".replace("e+0", "e"), height, value, window / t0)
