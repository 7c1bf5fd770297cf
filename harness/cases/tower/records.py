"""Runs of the tower, and impulse ratios, as cases of the baseline."""

from __future__ import annotations

import math

import numpy as np

from harness.cases.incline.records import short
from harness.cases.tower.comparison import SeriesComparison
from harness.cases.tower.contact_events import contact_events
from harness.comparison.baseline_record import BaselineRecord, Made, Quantity, made_by
from harness.comparison.divergence import Comparison, Series
from harness.errors import RequestError
from harness.observables.impulse import impulse
from harness.observables.summary import peak_force
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

LEAST_FORCE = 1e-6
"""Contacts that press with less, over the peak, are not counted: rounding decides on them."""

WITH_SERIES = (2, 19)
"""Heights whose force is kept over time: three particles, and the source's tallest."""


def tower_name(case: Tower, solver: str) -> str:
    """Return the name of a tower run."""
    return (
        f"{solver}/tower-{case.law}-n{case.height}-k{short(case.each('stiffness')[0])}"
        f"-v{case.speed:g}"
    )


def tower_case(run: TowerRun, version: str) -> BaselineRecord:
    """Return a run with profiles as a case: peak force, impulse, changes of contacts, force series.

    ``version`` is that of this harness, for its own solvers. The impulse is NaN where
    the run shows no window.
    """
    events = contact_events(run, LEAST_FORCE * peak_force(run))
    last = events[-1] if events else None
    quantities = {
        "peak_force_N": Quantity(peak_force(run), 0.0, "N"),
        "impulse_Ns": Quantity(_impulse(run), 0.0, "N s"),
        "contact_changes": Quantity(float(len(events)), 0.0, ""),
    }
    if last is not None:
        t0 = run.tower.contact_time
        quantities["last_change_t0"] = Quantity(last.time / t0, last.resolution / t0, "t0")
    return BaselineRecord(
        name=tower_name(run.tower, run.solver),
        parameters={
            **run.tower.model_dump(mode="json"),
            "duration_t0": round(float(run.time_over_t0[-1]), 9),
            "step_s": run.step,
        },
        quantities=quantities,
        series=_series(run) if run.tower.height in WITH_SERIES else None,
        **made_by(run.provenance, run.solver, version),
    )


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


def ratio_case(case: Tower, solver: str, ratio: float, made: Made) -> BaselineRecord:
    """Return an impulse ratio alpha(n), turnaround window, as a case."""
    name = tower_name(case, solver).replace("/tower-", "/impulse-ratio-")
    return BaselineRecord(
        name=name,
        parameters={**case.model_dump(mode="json"), "window": "turnaround"},
        quantities={"impulse_ratio": Quantity(ratio, 0.0, "")},
        **made,
    )  # fmt: skip


def _impulse(run: TowerRun) -> float:
    try:
        return impulse(run)
    except RequestError:
        return math.nan


def _series(run: TowerRun) -> Series:
    return Series(
        run.time,
        {"grain_force_N": run.grain_force, "grain_velocity_m_per_s": run.grain_velocity},
    )
