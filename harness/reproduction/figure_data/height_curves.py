"""Quantities over height: where they level off, and whether they fall all the way."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.parameters.tower import Tower

SOURCE_LAW = Tower().law
FLAT = 0.01
"""Of alpha, and of the angle over its first: what a figure shows of a plateau or a rise."""


class Curve(NamedTuple):
    """One run over height: plateau at the tallest, and what disturbs the way to it."""

    name: str
    heights: NDArray[np.int64]
    values: NDArray[np.float64]
    windows: NDArray[np.float64]  # [t0]

    @property
    def plateau(self) -> float:
        """Return the value of the tallest tower."""
        return float(self.values[-1])

    @property
    def level_from(self) -> int:
        """Return the first height from which on all values are within FLAT of the plateau."""
        off = np.flatnonzero(np.abs(self.values - self.values[-1]) > FLAT * self.values[0])
        return int(self.heights[off[-1] + 1]) if off.size else int(self.heights[0])

    @property
    def rise(self) -> float:
        """Return the largest rise above any smaller height's value."""
        return float((self.values - np.minimum.accumulate(self.values)).max())

    @property
    def row_of_rise(self) -> int:
        """Return where in the arrays it has risen most."""
        return int((self.values - np.minimum.accumulate(self.values)).argmax())

    @property
    def falls(self) -> bool:
        """Return whether it ends lower than it begins and nowhere rises by more than FLAT."""
        limit = FLAT * float(self.values[0])
        return self.rise <= limit and self.plateau < self.values[0] - limit


def curves(frame: pd.DataFrame, column: str) -> Iterator[Curve]:
    """Yield the source's law's runs of a table of impulses, each against height."""
    part = frame[frame["law"] == SOURCE_LAW]
    for (k, v), run in part.groupby(["stiffness_N_per_m", "speed_m_per_s"], sort=False):
        ordered = run.sort_values("height")
        height, value, window = (ordered[n].to_numpy() for n in ("height", column, "window_s"))
        t0 = Tower(stiffness=k, speed=v).contact_time
        yield Curve(f"k = {k:.0e} N/m, {v:g} m/s".replace("e+0", "e"), height, value, window / t0)
