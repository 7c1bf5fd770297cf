"""MFiX's scheme against its step: the source's check of the incline, and what it converges to."""

from __future__ import annotations

import math

import pandas as pd

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.recorded import case_at, recorded_angles
from harness.cases.incline.recorded_checks import EULER, angle_in_scheme
from harness.engines.reference.engine import Reference

ADAMS_BASHFORTH = "mfix-adams-bashforth"
STIFFNESSES = (1e5, 1e6, 1e7)
FACTORS = (50, 100, 200, 500, 1000, 2000, 5000)


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


def _columns(name: str, angle: CriticalAngle | None) -> dict[str, float]:
    return {
        f"{name}_deg": angle.value_deg if angle else math.nan,
        f"{name}_uncertainty_deg": angle.uncertainty_deg if angle else math.nan,
    }
