"""What a rebound does to the angle: two readings of the source's shock, and two DEMs."""

from __future__ import annotations

import math

import pandas as pd

from harness.cases.incline.critical_angle import CriticalAngle
from harness.cases.incline.critical_angles import critical_angle
from harness.cases.incline.parameters import Incline
from harness.engines.contract import Engine
from harness.engines.reference.engine import Reference
from harness.parameters.contact import Contact
from harness.theory.critical_angle import critical_angle as closed_form
from harness.theory.shock import shock_from_restitution

RESTITUTIONS = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
IN_THE_ENGINE = (0.1, 0.5)
STIFFNESS, STEPS_PER_CONTACT = 1e6, 100.0
TOLERANCE_DEG = 5e-3


def restitution_table(engine: Engine) -> pd.DataFrame:
    """Return a row for each restitution: both readings, the reference DEM, the engine (some).

    Measured by steady motion: a grain that rebounds may fly over the crest, where
    a passage means nothing. Angles and uncertainties in deg, NaN where not measured.
    """
    with Reference() as reference:
        rows = [_row(e, engine, reference) for e in RESTITUTIONS]
    return pd.DataFrame(rows)


def _row(restitution: float, engine: Engine, reference: Engine) -> dict[str, float]:
    own = _measured(restitution, reference)
    other = _measured(restitution, engine) if restitution in IN_THE_ENGINE else None
    return {
        "restitution": restitution,
        "kept_deg": closed_form(shock_from_restitution(restitution, "kept")),
        "lost_deg": closed_form(shock_from_restitution(restitution, "lost")),
        "reference_deg": own.value_deg,
        "reference_uncertainty_deg": own.uncertainty_deg,
        "engine_deg": other.value_deg if other else math.nan,
        "engine_uncertainty_deg": other.uncertainty_deg if other else math.nan,
        "steps_per_contact": STEPS_PER_CONTACT,
    }


def _measured(restitution: float, engine: Engine) -> CriticalAngle:
    contact = Contact(name="rebound", restitution=restitution, damping_ratio=None)
    case = Incline(contact=contact, stiffness=STIFFNESS, steps_per_contact=STEPS_PER_CONTACT)
    return critical_angle(case, method="steady", tolerance_deg=TOLERANCE_DEG, engine=engine)
