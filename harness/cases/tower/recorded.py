"""Towers that were recorded with an engine, for where that engine is not: against the exact ones."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.tower import tolerances
from harness.cases.tower.evidence import EngineTower, OwnEvidence
from harness.cases.tower.run import tower
from harness.comparison.verdicts import Check, Kind, judge

if TYPE_CHECKING:
    from harness.engines.mfix.recorded import RecordedTower

FINE = 100.0
"""Steps per contact from which recorded towers are judged; at fewer the step decides."""


def recorded_checks(engine: str, evidence: OwnEvidence) -> list[Check]:
    """Hold the largest recorded force on the grain against the exact one at the same times.

    Return no row for an engine of which no tower was recorded.
    """
    rows = []
    for recorded in _recorded(engine):
        case, who = recorded.case, f"{engine} (recorded)"
        steps = case.contact_period / recorded.step
        if steps < FINE:
            continue
        found = EngineTower(
            who,
            case.height,
            steps,
            float(recorded.force.max()),
            _exact_peak(recorded),
            recorded=True,
        )
        evidence.towers.append(found)
        rows.append(
            judge(
                f"{who}: tower, n = {case.height}: peak force",
                Kind.CROSS_CODE,
                found.peak_force,
                found.exact_peak_force,
                replace(tolerances.FINEST, unit="N"),
                note="largest of the samples, against the exact one at the same times",
            )
        )
    return rows


def _recorded(engine: str) -> list[RecordedTower]:
    """Return the recorded towers in an engine's folder, none where it keeps none."""
    name = f"harness.engines.{engine}"
    if not engine.isidentifier() or not find_spec(name) or not find_spec(f"{name}.recorded"):
        return []
    towers: list[RecordedTower] = import_module(f"{name}.recorded").recorded_towers()
    return towers


def _exact_peak(recorded: RecordedTower) -> float:
    times, case = recorded.time, recorded.case
    run = tower(
        case,
        solver="exact",
        duration=float(times[-1]) / case.contact_time,
        samples=times.size - 1,
    )
    # the exact run adds samples where contacts change; those are not the recorded ones
    at = np.abs(run.time[:, None] - times).argmin(axis=0)
    return float(run.grain_force[at].max())
