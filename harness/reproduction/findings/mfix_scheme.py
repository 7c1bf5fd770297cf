"""MFiX's scheme against its step: the source's check of the incline, and what it converges to."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pandas as pd

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.incline.routes import start_in_well
from harness.cases.incline.steady import critical_angle_by_steady_motion
from harness.engines.mfix.recorded import START_SPEED, case_at, recorded_angles
from harness.engines.reference.engine import Reference
from harness.errors import EngineError, RequestError

EULER, ADAMS_BASHFORTH = "mfix-euler", "mfix-adams-bashforth"
STIFFNESSES = (1e5, 1e6, 1e7)
FACTORS = (50, 100, 200, 500, 1000, 2000, 5000)
TOLERANCE_DEG = 1e-3

FINE = 1000
"""Factor from which a passage will do: where in a step a contact begins is worth 1e-4 deg."""

WELLS = 20
"""Wells to pass in steady motion: jitter of coarse steps may carry a grain over a few."""


def mfix_table() -> pd.DataFrame:
    """Return the critical angle of MFiX's contact over stiffness and ``DTSOLID_FACTOR``.

    Columns for each integrator: value and uncertainty in deg, NaN where its step is
    unstable; and the angle that was recorded with MFiX itself, NaN where none was.
    """
    recorded = {(a.stiffness, a.factor): a.value_deg for a in recorded_angles()}
    with Reference(EULER) as euler, Reference(ADAMS_BASHFORTH) as adams:
        rows = [
            {
                "stiffness_N_per_m": k,
                "factor": factor,
                **_columns("euler", angle_in_scheme(k, factor, euler)),
                **_columns("adams_bashforth", angle_in_scheme(k, factor, adams)),
                "recorded_deg": recorded.get((k, factor), math.nan),
            }
            for k in STIFFNESSES
            for factor in FACTORS
        ]
    return pd.DataFrame(rows)


def angles_without_step() -> pd.DataFrame:
    """Return the critical angle of the same contact by the adaptive integrator, for each k."""
    with Reference("adaptive") as engine:
        # no step: where in one a contact begins does not matter
        cases = [case_at(10.2, k, 50) for k in STIFFNESSES]
        angles = [critical_angle(case, phases=1, engine=engine) for case in cases]
    return pd.DataFrame(
        {
            "stiffness_N_per_m": STIFFNESSES,
            "critical_angle_deg": [angle.value_deg for angle in angles],
            "uncertainty_deg": [angle.uncertainty_deg for angle in angles],
        }
    )


def angle_in_scheme(stiffness: float, factor: int, engine: Reference) -> CriticalAngle | None:
    """Return the critical angle at a stiffness [N/m] and factor; None for an unstable step.

    Coarse steps by steady motion from MFiX's own start (1.5 m/s in a well), as the
    recorded angles were found; fine ones by passage, which is the same there and
    asks for a tenth of the steps.
    """
    case = case_at(10.2, stiffness, factor).replace(wells=WELLS, time_limit=100.0 * WELLS)
    try:
        if factor >= FINE:
            return critical_angle(case, engine=engine)
        return critical_angle_by_steady_motion(
            lambda cases: _as_in_mfix(cases, engine), case, tolerance_deg=TOLERANCE_DEG
        )
    except RequestError:
        return None


def _as_in_mfix(cases: Sequence[Incline], engine: Reference) -> list[InclineRun]:
    start = start_in_well(cases[0], START_SPEED)
    runs: list[InclineRun] = []
    for run in engine.inclines(cases, "steady", start=start):
        if isinstance(run, EngineError):
            raise run
        runs.append(run)
    return runs


def _columns(name: str, angle: CriticalAngle | None) -> dict[str, float]:
    return {
        f"{name}_deg": angle.value_deg if angle else math.nan,
        f"{name}_uncertainty_deg": angle.uncertainty_deg if angle else math.nan,
    }
