"""Restart files of bulk runs: long ones leave them, each after as much work; whole series."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

import numpy as np

from harness.engines.contract import RESTART_EVERY, Values
from harness.errors import EngineOutputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

WORK = 10**9
"""[particles x steps] between two restart files: seven minutes of a core in LAMMPS."""

LONG = 2 * WORK
"""[particles x steps] of the shortest run that leaves any: a quarter of an hour."""


class BulkRun(Protocol):
    """Parameters of a bulk run: grains, steps of its two stages, steps between two rows."""

    @property
    def grains(self) -> int: ...  # noqa: D102
    @property
    def settle_steps(self) -> int: ...  # noqa: D102
    @property
    def steps(self) -> int: ...  # noqa: D102
    @property
    def every(self) -> int: ...  # noqa: D102


def restart_values(p: BulkRun) -> Values:
    """Return the value of a job that says how often it leaves a restart file; none for a short run.

    They are part of the run, which begins anew at each of them: so it is the same wherever it is
    cut. They fall on rows of the series.
    """
    if p.grains * (p.settle_steps + p.steps) < LONG:
        return {}
    return {RESTART_EVERY: p.every * math.ceil(WORK / p.grains / p.every)}


def longest_part(values: Values) -> float:
    """Return the share of the steps of a job that lie between two of its restart files."""
    steps = float(values["settle_steps"]) + float(values["steps"])
    return min(1.0, float(values.get(RESTART_EVERY, steps)) / steps)


MOST = 1.5
"""Times the shortest interval between two rows, the longest; some codes are a step late."""


def check_rows(times: NDArray[np.float64], end: float, who: str) -> None:
    """Raise EngineOutputError where rows are missing from ``times`` (M,), 0 to ``end``."""
    gaps = np.diff(times, prepend=min(0.0, times[0]), append=max(end, times[-1]))
    inner = gaps[1:-1]
    if not inner.size or gaps.max() > MOST * inner.min():
        place = int(gaps.argmax())
        start = times[place - 1] if place else 0.0
        raise EngineOutputError(
            f"{who} left a series that lacks rows: none for {gaps[place]:.4g} after {start:.4g}"
        )
