"""The tables behind the page of findings."""

from __future__ import annotations

from harness.cases.tower.impulse_angles import impulse_angles
from harness.engines.contract import Engine
from harness.observables.windows import WINDOWS
from harness.reproduction.findings.mfix_scheme import angles_without_step, mfix_table
from harness.reproduction.findings.restitution import restitution_table
from harness.reproduction.findings.tables import Findings
from harness.theory.critical_angle import critical_angle
from harness.workflows.progress import Progress, silent

STAGE = "findings"

STIFFNESS, SPEED = 1e6, 2.0
"""[N/m], [m/s]: the run of the source's figures of force and contacts."""


def findings(engine: Engine, progress: Progress = silent) -> Findings:
    """Return the tables; ``engine`` is held beside the reference DEM in the first of them."""
    progress(STAGE, 0, 4)
    restitution = restitution_table(engine)
    progress(STAGE, 1, 4)
    heights = impulse_angles(
        stiffnesses=(STIFFNESS,), speeds=(SPEED,), windows=WINDOWS, solver="exact"
    )
    progress(STAGE, 2, 4)
    mfix = mfix_table()
    progress(STAGE, 3, 4)
    limits = angles_without_step()
    progress(STAGE, 4, 4)
    return Findings(restitution, heights, mfix, limits, critical_angle())
