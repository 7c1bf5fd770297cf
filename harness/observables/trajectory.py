"""The path of a grain in the plane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Trajectory:
    """The grain's path: time [s], position [m] and velocity [m/s], each of shape (rows,).

    x runs along the row (unwrapped over the periodic boundary) from the centre
    of a fixed sphere, y normal to it from the line of centres.
    """

    time_s: NDArray[np.float64]
    x_m: NDArray[np.float64]
    y_m: NDArray[np.float64]
    vx_m_per_s: NDArray[np.float64]
    vy_m_per_s: NDArray[np.float64]

    @property
    def speed_m_per_s(self) -> NDArray[np.float64]:
        """Return the speed [m/s], shape (rows,)."""
        return np.hypot(self.vx_m_per_s, self.vy_m_per_s)

    def frame(self) -> pd.DataFrame:
        """Return the path as a table, one row per sample."""
        import pandas as pd

        return pd.DataFrame({**vars(self), "speed_m_per_s": self.speed_m_per_s})
