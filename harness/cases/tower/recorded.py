"""Towers recorded with MFiX-DEM 21.3.2, for where that is not: against the exact propagator.

The tables lie in the engine's folder ``recorded``, which says where they come from.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from harness.cases.runs import recorded_text
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

CASE = Tower(height=1, stiffness=1e5, speed=2.0, law="overlap")
"""The recorded towers but for their heights: 1 kg, 1 m, undamped, all just touching."""

FACTORS = (50, 5000)
"""``DTSOLID_FACTOR`` of the recorded towers; only the finer ones are judged."""


def recorded_tower(factor: int) -> NDArray[np.void]:
    """Return the recorded force on a tower's grain: ``t_s`` [s], ``F_top_N2`` ... [N].

    At the positions of that time, eight digits; every step at f = 50, every 100th at f = 5000.
    Raise RequestError for a factor other than 50 and 5000.
    """
    if factor not in FACTORS:
        raise RequestError(f"f = {factor}: no tower was recorded, must be 50 or 5000")
    text = recorded_text(MFIX, f"tower_k1e5_euler_f{factor}.csv")
    table: NDArray[np.void] = np.genfromtxt(text.splitlines(), delimiter=",", names=True)
    return table


def recorded_checks(towers: list[EngineTower]) -> list[Check]:
    """Hold the largest recorded force on the grain against the exact one at the same times.

    What was found is added to ``towers``.
    """
    factor, rows = FACTORS[-1], []
    table, steps = recorded_tower(factor), steps_per_contact(factor, UNDAMPED)
    for column in (table.dtype.names or ())[1:]:
        case = CASE.replace(height=int(column.removeprefix("F_top_N")) - 1)
        peak, exact = float(table[column].max()), _exact_peak(case, table["t_s"])
        towers.append(EngineTower(NAME, case.height, steps, peak, exact, recorded=True))
        rows.append(
            judge(
                f"{NAME}: tower, n = {case.height}: peak force",
                Kind.CROSS_CODE,
                peak,
                exact,
                replace(tolerances.FINEST, unit="N"),
                note="largest of the samples, against the exact one at the same times",
            )
        )
    return rows


def _exact_peak(case: Tower, times: NDArray[np.float64]) -> float:
    duration = float(times[-1]) / case.contact_time
    run = tower(case, solver="exact", duration=duration, samples=times.size - 1)
    # the exact run adds samples where contacts change; those are not MFiX's
    at = np.abs(run.time[:, None] - times).argmin(axis=0)
    return float(run.grain_force[at].max())
