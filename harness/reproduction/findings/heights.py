"""Law, window and reading: what each does to the angle against height."""

from __future__ import annotations

import pandas as pd

from harness.cases.tower.impulse_angles import impulse_angles
from harness.observables.windows import WINDOWS

STIFFNESS, SPEED = 1e6, 2.0
"""[N/m], [m/s]: the run of the source's figures of force and contacts."""


def heights_table() -> pd.DataFrame:
    """Return alpha(n) and the angles of both readings for both laws and all windows.

    Columns of :func:`harness.cases.tower.impulse_angles.impulse_angles`, by the exact
    propagator; NaN where a window does not exist.
    """
    return impulse_angles(
        stiffnesses=(STIFFNESS,), speeds=(SPEED,), windows=WINDOWS, solver="exact"
    )
