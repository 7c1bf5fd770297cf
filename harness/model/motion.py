"""The motion of a scene: what a solver or an engine returns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
STAGE_COLUMNS = (
    "step", "time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s", "wz_rad_per_s",
)  # fmt: skip


@dataclass(frozen=True)
class Motion:
    """Samples of a scene's bodies, in SI units.

    ``time`` [s] has the shape (M,), ``position`` [m], ``velocity`` [m/s], ``angular_velocity``
    [rad/s], ``force`` [N] and ``torque`` [N m] have (M, N, 3), in the order of the bodies. Forces
    are those of contacts and drag, without weight. ``temperature`` [K] (M, N) is None where no
    heat flows. An engine that writes no forces leaves NaN. ``stages`` (K, 7) are the start and the
    end of each stage of a scene with stages, None of another: :data:`STAGE_COLUMNS` of the first
    body. The samples of a run that is over early end before it is.
    """

    time: Floats
    position: Floats
    velocity: Floats
    angular_velocity: Floats
    force: Floats
    torque: Floats
    temperature: Floats | None = None
    stages: Floats | None = None

    def __len__(self) -> int:
        return len(self.time)
