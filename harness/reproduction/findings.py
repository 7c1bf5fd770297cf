"""Compute the tables of the page of findings: restitution, height, MFiX's step, stiffness."""

from __future__ import annotations

import math
from dataclasses import dataclass

import pandas as pd

from harness.cases.incline.angle import CriticalAngle, critical_angle
from harness.cases.incline.system import Incline
from harness.cases.incline.verification import EULER, angle_in_scheme, case_at, recorded_angles
from harness.cases.tower.impulse import impulse_angles
from harness.engines.contract import Engine
from harness.engines.reference import Reference
from harness.observables.tower import WINDOWS
from harness.parameters.law import Contact
from harness.theory.chain import shock_from_restitution
from harness.theory.incline import critical_angle as closed_form
from harness.workflows.progress import Progress, silent

ADAMS_BASHFORTH = "mfix-adams-bashforth"
STIFFNESSES = (1e5, 1e6, 1e7)
FACTORS = (50, 100, 200, 500, 1000, 2000, 5000)
RESTITUTIONS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
IN_THE_ENGINE = (0.1, 0.5)
STEPS_PER_CONTACT = 100.0
TOLERANCE_DEG = 5e-3
STIFFNESS, SPEED = 1e6, 2.0
"""[N/m], [m/s]: the run of the source's figures of force and contacts."""


@dataclass(frozen=True)
class FindingTables:
    """Tables behind the page of findings; angles in deg.

    ``restitution`` (a row for each e): the angle of both readings of the shock,
    and what the reference DEM and the engine measure; ``heights`` (height, law,
    window): impulse ratio and angle of both readings; ``mfix`` (stiffness, step
    factor, scheme): critical angle of our integrator in MFiX's scheme, with the
    recorded one where there is one; ``limits`` (stiffness): the angle of the same
    contact without a step.
    """

    restitution: pd.DataFrame
    heights: pd.DataFrame
    mfix: pd.DataFrame
    limits: pd.DataFrame
    closed_form_deg: float

    def at_height(self, height: int, law: str, window: str = "turnaround") -> pd.Series:
        """Return the row of a tower; raise IndexError if it was not run."""
        frame = self.heights
        selected = (frame["height"] == height) & (frame["law"] == law) & (frame["window"] == window)
        return frame[selected].iloc[0]


def findings(engine: Engine, progress: Progress = silent) -> FindingTables:
    """Return the tables; the first compares ``engine`` with the reference DEM."""
    frames: list[pd.DataFrame] = []
    tables = (lambda: restitution_table(engine), _heights, mfix_table, angles_without_step)
    for done, table in enumerate(tables):
        progress("findings", done, len(tables))
        frames.append(table())
    progress("findings", len(tables), len(tables))
    restitution, heights, mfix, limits = frames
    return FindingTables(restitution, heights, mfix, limits, closed_form())


def restitution_table(engine: Engine) -> pd.DataFrame:
    """Return a row for each restitution: both readings, the reference DEM, the engine (some).

    Measured by steady motion: a grain that rebounds may fly over the crest, where
    a passage means nothing. Angles and uncertainties in deg, NaN where not measured.
    """

    def measured(restitution: float, by: Engine) -> CriticalAngle:
        contact = Contact(name="rebound", restitution=restitution, damping_ratio=None)
        case = Incline(contact=contact, stiffness=STIFFNESS, steps_per_contact=STEPS_PER_CONTACT)
        return critical_angle(case, method="steady", tolerance_deg=TOLERANCE_DEG, engine=by)

    with Reference() as reference:
        rows = [
            {
                "restitution": e,
                "kept_deg": closed_form(shock_from_restitution(e, "kept")),
                "lost_deg": closed_form(shock_from_restitution(e, "lost")),
                **_columns("reference", measured(e, reference)),
                **_columns("engine", measured(e, engine) if e in IN_THE_ENGINE else None),
                "steps_per_contact": STEPS_PER_CONTACT,
            }
            for e in RESTITUTIONS
        ]
    return pd.DataFrame(rows)


def _heights() -> pd.DataFrame:
    return impulse_angles(
        stiffnesses=(STIFFNESS,), speeds=(SPEED,), windows=WINDOWS, solver="exact"
    )


def mfix_table() -> pd.DataFrame:
    """Return the critical angle of MFiX's contact over stiffness and ``DTSOLID_FACTOR``.

    Columns for each integrator: value and uncertainty in deg, NaN where its step is
    unstable; and the angle that was recorded with MFiX itself, NaN where none was.
    """
    recorded = {at: angle.value for at, angle in recorded_angles().items()}
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
        rows = [
            {
                "stiffness_N_per_m": k,
                "critical_angle_deg": critical_angle(
                    case_at(10.2, k, 50), phases=1, engine=engine
                ).value_deg,
            }
            for k in STIFFNESSES
        ]
    return pd.DataFrame(rows)


def _columns(name: str, angle: CriticalAngle | None) -> dict[str, float]:
    return {
        f"{name}_deg": angle.value_deg if angle else math.nan,
        f"{name}_uncertainty_deg": angle.uncertainty_deg if angle else math.nan,
    }
