"""The runs of a verification as cases of the baseline, and the rows against it."""

from __future__ import annotations

import platform
from collections.abc import Sequence

import pandas as pd

from harness import __version__
from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.passage import PHASES
from harness.cases.incline.records import angle_case, angle_name, extrapolated_case
from harness.cases.tower.records import ratio_case
from harness.comparison.baseline_record import BaselineRecord, made_by
from harness.comparison.evidence import InclineEvidence, TowerEvidence
from harness.comparison.regression import Baseline, Regression, against_baseline
from harness.errors import EngineError
from harness.observables.provenance import Provenance
from harness.parameters.contact import PLASTIC
from harness.parameters.tower import Tower
from harness.workflows.verification.levels import Level

SOLVERS = ("exact", "rk4")
RATIO = Tower(stiffness=1e6, speed=2.0)
"""The run of the source whose impulse ratios are kept."""


def here() -> str:
    """Return the platform that a case is measured on."""
    return f"{platform.system()} {platform.machine()}"


def in_phases(phases: int) -> str:
    """Return the resolution of a passage: over how many starts within a step it is averaged."""
    return f"{phases}-phases"


def keep_errors(
    evidence: InclineEvidence,
    engine: str,
    cases: Sequence[Incline],
    angles: Sequence[CriticalAngle | EngineError],
    phases: int,
) -> None:
    """Keep the errors among the angles, by the name of their case."""
    for case, angle in zip(cases, angles, strict=True):
        if isinstance(angle, EngineError):
            evidence.errors[angle_name(case, engine, "passage", in_phases(phases))] = angle


def ratio_cases(
    frame: pd.DataFrame, who: Provenance | None, heights: Sequence[int]
) -> list[BaselineRecord]:  # fmt: skip
    """Return the impulse ratios of a table, at the run of the source that is kept, as cases."""
    chosen = frame[
        (frame["stiffness_N_per_m"] == RATIO.stiffness)
        & (frame["speed_m_per_s"] == RATIO.speed)
        & frame["height"].isin(heights)
    ]
    solver = who.engine if who else "exact"
    made = made_by(who, solver, __version__)
    return [
        ratio_case(
            RATIO.replace(height=int(row["height"]), law=row["law"]),
            solver,
            float(row["impulse_ratio"]),
            made,
        )
        for row in chosen.to_dict(orient="records")
    ]


def measured_cases(
    level: Level, inclines: InclineEvidence, towers: TowerEvidence
) -> list[BaselineRecord]:
    """Return every case for the baseline that a verification left, each once."""
    rungs = inclines.by_contact.get(PLASTIC.name, [])
    found = [angle_case(angle, in_phases(PHASES)) for angle in rungs]
    for name, angles in inclines.by_contact.items():
        if name != PLASTIC.name:
            found += [angle_case(angle, in_phases(level.phases_beside)) for angle in angles]
    if inclines.extrapolated is not None:
        found.append(extrapolated_case(inclines.extrapolated, rungs))
    found += [*inclines.measured, *towers.measured]
    once = {case.name: case.at(level.name, here()) for case in found}
    return list(once.values())


def baseline_rows(
    measured: Sequence[BaselineRecord],
    baseline: Baseline,
    level: Level,
    engine: str,
    inclines: InclineEvidence,
    towers: TowerEvidence,
    how: str,
) -> Regression:
    """Return the rows of a verification against the baseline."""

    def reason(case: BaselineRecord) -> str:
        if "deformable" in case.name and case.engine == engine and how != "in-process":
            return "an external force on LAMMPS's particles needs LAMMPS in-process"
        died = [*inclines.errors.values(), *towers.errors.values()]
        if died:
            return f"its part ended early: {died[0].kind}: {died[0]}"
        return "it was not run: the engine did not get there, or the case is not of this level now"

    return against_baseline(
        measured,
        baseline,
        level.name,
        engines={engine, *SOLVERS},
        errors={**inclines.errors, **towers.errors},
        reason=reason,
    )
