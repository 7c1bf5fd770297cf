"""Towers recorded with MFiX-DEM 21.3.2, for where that is not: against the exact propagator.

The tables lie in the engine's folder ``recorded``, which says where they come from.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from importlib import resources

import numpy as np
from numpy.typing import NDArray

from harness.cases.tower import tolerances
from harness.cases.tower.evidence import EngineTower
from harness.cases.tower.run import tower
from harness.comparison.verdicts import Check, Kind, judge
from harness.engines.mfix.step import steps_per_contact
from harness.errors import RequestError
from harness.parameters.contact import Contact
from harness.parameters.tower import Tower

MFIX = "mfix"
NAME = "mfix (recorded)"

UNDAMPED = Contact(name="undamped", restitution=1.0, damping_ratio=None, effective_mass="half")

STIFFNESS, SPEED = 1e5, 2.0
"""[N/m] and [m/s] of the recorded towers: 1 kg, 1 m, undamped, all just touching."""

FACTORS = (50, 5000)
"""``DTSOLID_FACTOR`` of the recorded towers."""

FINE = 5000
"""Factor of those that are judged."""


@dataclass(frozen=True)
class RecordedTower:
    """A recorded tower: its case, the factor and step [s], and the force on the grain in time.

    ``time`` (M,) [s] and ``force`` (M,) [N], at the positions of that time, eight digits;
    every step at f = 50, every 100th at f = 5000.
    """

    case: Tower
    factor: int
    step: float
    time: NDArray[np.float64]
    force: NDArray[np.float64]


def recorded_tower(factor: int) -> NDArray[np.void]:
    """Return the recorded force on a tower's grain: ``t_s`` [s], ``F_top_N2`` ... [N].

    Raise RequestError for a factor other than 50 and 5000.
    """
    if factor not in FACTORS:
        raise RequestError(f"f = {factor}: no tower was recorded, must be 50 or 5000")
    folder = resources.files("harness.engines.mfix").joinpath("recorded")
    text = folder.joinpath(f"tower_k1e5_euler_f{factor}.csv").read_text(encoding="utf-8")
    table: NDArray[np.void] = np.genfromtxt(text.splitlines(), delimiter=",", names=True)
    return table


def recorded_towers() -> list[RecordedTower]:
    """Return the recorded towers, one for each factor and number of particles."""
    found = []
    for factor in FACTORS:
        table, steps = recorded_tower(factor), steps_per_contact(factor, UNDAMPED)
        for column in (table.dtype.names or ())[1:]:
            height = int(column.removeprefix("F_top_N")) - 1
            case = Tower(height=height, stiffness=STIFFNESS, speed=SPEED, law="overlap")
            step = case.contact_period / steps
            found.append(RecordedTower(case, factor, step, table["t_s"], table[column]))
    return found


def recorded_checks(towers: list[EngineTower]) -> list[Check]:
    """Hold the largest recorded force on the grain against the exact one at the same times.

    What was found is added to ``towers``.
    """
    rows = []
    for recorded in recorded_towers():
        if recorded.factor != FINE:
            continue
        case = recorded.case
        found = EngineTower(
            NAME,
            case.height,
            case.contact_period / recorded.step,
            float(recorded.force.max()),
            _exact_peak(recorded),
            recorded=True,
        )
        towers.append(found)
        rows.append(
            judge(
                f"{NAME}: tower, n = {case.height}: peak force",
                Kind.CROSS_CODE,
                found.peak_force,
                found.exact_peak_force,
                replace(tolerances.FINEST, unit="N"),
                note="largest of the samples, against the exact one at the same times",
            )
        )
    return rows


def _exact_peak(recorded: RecordedTower) -> float:
    times, case = recorded.time, recorded.case
    run = tower(
        case,
        solver="exact",
        duration=float(times[-1]) / case.contact_time,
        samples=times.size - 1,
    )
    # the exact run adds samples where contacts change; those are not MFiX's
    at = np.abs(run.time[:, None] - times).argmin(axis=0)
    return float(run.grain_force[at].max())
