"""Runs of the tower, and impulse ratios, as records of the baseline."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd

from harness import __version__
from harness.cases.tower.comparison import SeriesComparison
from harness.cases.tower.contact_events import contact_events
from harness.comparison.baseline_record import BaselineRecord, Quantity, made_by
from harness.comparison.divergence import Comparison, Series
from harness.errors import RequestError
from harness.observables.impulse import impulse
from harness.observables.provenance import Provenance
from harness.observables.summary import peak_force
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

NAME = "tower"
"""Name of the case."""

LEAST_FORCE = 1e-6
"""Contacts that press with less, over the peak, are not counted: rounding decides on them."""

WITH_SERIES = (2, 19)
"""Heights whose force is kept over time: three particles, and the source's tallest."""

RATIO = Tower(stiffness=1e6, speed=2.0)
"""The run of the source whose impulse ratios are kept."""


def record_name(case: Tower, solver: str, what: str = NAME) -> str:
    """Return the name of the record of a tower run; ``what`` is what it tells of the tower."""
    return f"{solver}/{what}-{case.law}-n{case.height}-k{_short(case)}-v{case.speed:g}"


def label(case: Tower) -> str:
    """Return what tells a tower from others of its solver, in words."""
    return f"{case.law} law, n = {case.height}, k = {_short(case)} N/m, {case.speed:g} m/s"


def _short(case: Tower) -> str:
    """Return the stiffness of the grain [N/m], as in 1e6 or 3.16e5."""
    return f"{case.each('stiffness')[0]:.3g}".replace("e+0", "e").replace("e+", "e")


def tower_record(run: TowerRun) -> BaselineRecord:
    """Return the record of a run with profiles: peak force, impulse, changes of contacts, series.

    The impulse is NaN where the run shows no window.
    """
    try:
        found = impulse(run)
    except RequestError:
        found = math.nan
    series = {"grain_force_N": run.grain_force, "grain_velocity_m_per_s": run.grain_velocity}
    least = LEAST_FORCE * peak_force(run)
    events = contact_events(run, least)
    quantities = {
        "peak_force_N": Quantity(peak_force(run), 0.0, "N"),
        "impulse_Ns": Quantity(found, 0.0, "N s"),
        "contact_changes": Quantity(float(len(events)), 0.0, ""),
    }
    if events:
        quantities["last_change_s"] = Quantity(events[-1].time, 0.0, "s")
    return BaselineRecord(
        name=record_name(run.tower, run.solver),
        parameters={
            **run.tower.model_dump(mode="json"),
            "duration_t0": round(float(run.time_over_t0[-1]), 9),
            "step_s": run.step,
        },
        quantities=quantities,
        case=NAME,
        label=label(run.tower),
        family=(run.tower.law,),
        series=Series(run.time, series) if run.tower.height in WITH_SERIES else None,
        **made_by(run.provenance, run.solver, __version__),
    )


def ratio_records(
    frame: pd.DataFrame, who: Provenance | None, heights: Sequence[int]
) -> list[BaselineRecord]:  # fmt: skip
    """Return the records of the impulse ratios of a table, at the run of the source that is kept.

    ``who`` is the engine that made the table, None for the exact propagator.
    """
    solver, records = who.engine if who else "exact", []
    for row in of_ratio(frame).to_dict(orient="records"):
        case = RATIO.replace(height=int(row["height"]), law=row["law"])
        if case.height not in heights:
            continue
        records.append(
            BaselineRecord(
                name=record_name(case, solver, "impulse-ratio"),
                parameters={**case.model_dump(mode="json"), "window": "turnaround"},
                quantities={"impulse_ratio": Quantity(float(row["impulse_ratio"]), 0.0, "")},
                case=NAME,
                label=f"impulse ratio, {label(case)}",
                family=(case.law,),
                **made_by(who, solver, __version__),
            )
        )
    return records


def of_ratio(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of a table of impulse ratios that are at the run of :data:`RATIO`."""
    stiffness, speed = frame["stiffness_N_per_m"], frame["speed_m_per_s"]
    return frame[(stiffness == RATIO.stiffness) & (speed == RATIO.speed)]


def force_comparison(name: str, found: SeriesComparison, band: float) -> Comparison:
    """Return the force of two runs, over the reference's peak, as a series with its band."""
    wanted = np.interp(found.time, found.reference.time, found.reference.grain_force)
    reference = wanted / found.force.scale
    return Comparison(
        case=name,
        column="grain_force_over_peak",
        time=found.time,
        value=reference + found.force_difference,
        reference=reference,
        band=band,
        run_label=found.run.solver,
        reference_label=found.reference.solver,
    )
