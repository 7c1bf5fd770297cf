"""What was recorded with MFiX, for where MFiX is not: against reference DEM and exact solver."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from harness.cases.tower.run import tower
from harness.comparison.engine_evidence import EngineAngle, EngineEvidence, EngineTower, Rules
from harness.comparison.tolerances import TOLERANCES
from harness.comparison.verdicts import (
    Check,
    Kind,
    failed_run,
    finding,
    judge,
    not_tested,
)
from harness.engines.mfix.recorded import (
    RecordedAngle,
    RecordedTower,
    recorded_angles,
    recorded_towers,
)
from harness.engines.reference.engine import Reference
from harness.errors import EngineError
from harness.reproduction.findings.mfix_scheme import EULER, angle_in_scheme

NAME = "mfix (recorded)"

COARSE = 50
"""Factor of 4.8 steps per contact: how long one waits decides there on what lasts."""

SHOWN = {"quick": ((1e6, 500),), "default": ((1e6, 500), (1e6, 5000))}
"""Stiffness [N/m] and ``DTSOLID_FACTOR`` by level; all of them in a full one."""

FINE = 5000
"""Factor of the recorded towers that are judged."""


def recorded_checks(level: str, evidence: EngineEvidence) -> list[Check]:
    """Return the rows of MFiX's recorded angles and towers; fill in the evidence."""
    return [*_angles(level, evidence), *_towers(evidence)]


def _angles(level: str, evidence: EngineEvidence) -> list[Check]:
    chosen = SHOWN.get(level)
    with Reference(EULER) as engine:
        return [
            _angle(found, engine, evidence)
            for found in recorded_angles()
            if chosen is None or (found.stiffness, found.factor) in chosen
        ]


def _angle(found: RecordedAngle, engine: Reference, evidence: EngineEvidence) -> Check:
    """Hold a recorded angle against the reference DEM, by the same route from the same start."""
    case = found.case
    name = (
        f"{NAME}: critical angle against the reference DEM, k = {found.stiffness:g} N/m, "
        f"{case.steps_per_contact:.3g} steps"
    )
    try:
        own = angle_in_scheme(found.stiffness, found.factor, engine)
    except EngineError as error:
        return failed_run(name, Kind.CROSS_CODE, error, "deg")
    if own is None:
        return not_tested(name, Kind.CROSS_CODE, "the step is unstable in the scheme", "deg")
    evidence.angles.append(
        EngineAngle(
            engine=NAME,
            contact="source, m_eff m/2",
            rules=Rules(case.contact.tail, case.contact.effective_mass, "linear"),
            stiffness=found.stiffness,
            steps_per_contact=case.steps_per_contact,
            value_deg=found.value_deg,
            uncertainty_deg=found.uncertainty_deg,
            closed_form_deg=evidence.closed_form_deg,
            integrator=EULER,
            reference_deg=own.value_deg,
            reference_uncertainty_deg=own.uncertainty_deg,
            recorded=True,
        )
    )
    if found.factor == COARSE:
        note = "4.8 steps per contact: how long one waits decides on what lasts"
        return finding(name, found.value_deg, own.value_deg, "deg", note)
    return judge(
        name,
        Kind.CROSS_CODE,
        found.value_deg,
        own.value_deg,
        TOLERANCES["critical angle, recorded MFiX"],
        uncertainty=found.uncertainty_deg,
        note=f"MFiX 21.3.2; reference DEM: {EULER}",
    )


def _towers(evidence: EngineEvidence) -> list[Check]:
    """Hold the largest recorded force on the grain against the exact one at the same times."""
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
        evidence.towers.append(found)
        rows.append(
            judge(
                f"{NAME}: tower, n = {case.height}: peak force",
                Kind.CROSS_CODE,
                found.peak_force,
                found.exact_peak_force,
                replace(TOLERANCES["tower, engines"], unit="N"),
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
