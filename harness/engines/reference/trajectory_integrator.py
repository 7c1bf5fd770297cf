"""The interface of the integrators of the grain's trajectory: fixed steps, or adaptive."""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from harness.engines.reference.row import Grain, Row
from harness.engines.reference.smooth_motion import energy
from harness.errors import EngineMemoryError, EngineTimeoutError
from harness.observables.trajectory import Trajectory

MOST_SAMPLES = 10_000_000


class TrajectoryIntegrator(ABC):
    """A grain in motion: ``grain``, ``steps`` taken, ``time`` [s], and its samples."""

    grain: Grain
    steps: int = 0

    def __init__(self, grain: Grain, seconds: float) -> None:
        self.grain = grain
        self._deadline = time.monotonic() + seconds
        self._seconds = seconds
        self._samples: list[NDArray[np.float64]] = []
        self._count = 0

    @property
    @abstractmethod
    def time(self) -> float:
        """Return the time [s] since the start."""

    @property
    @abstractmethod
    def over(self) -> bool:
        """Return whether the time limit is reached."""

    @property
    def touching(self) -> bool | None:
        """Return whether the grain is in contact; None where its place tells."""
        return None

    @np.errstate(over="ignore", invalid="ignore")  # NaN is the method's to name
    def energy(self, row: Row) -> float:
        """Return the mechanical energy [J] that decides whether a grain that moves back is lost."""
        x, y, vx, vy = self.grain[:4]
        behind = 0 if row.single or not math.isfinite(x) else math.floor(x / row.diameter)
        return energy(np.array([x - behind * row.diameter, y, vx, vy]), behind, row)

    @abstractmethod
    def watch(self, place: float, floor: float) -> None:
        """Move until x > ``place`` [m], the grain turns back, or the time limit.

        A grain that moves back is given up when its energy falls below ``floor``
        [J]: a method without steps needs to be told. Raise EngineNaNError when
        the state overflows, EngineTimeoutError when it takes too long.
        """

    @abstractmethod
    def finish(self) -> None:
        """Move to the time limit, whatever the grain does. Errors as for ``watch``."""

    def trajectory(self) -> Trajectory:
        """Return the samples taken."""
        return Trajectory(*np.concatenate(self._samples).T)

    def _keep(self, rows: NDArray[np.float64]) -> None:
        """Keep samples, shape (rows, 5)."""
        self._count += len(rows)
        if self._count > MOST_SAMPLES:
            raise EngineMemoryError(f"reference: more than {MOST_SAMPLES:g} samples of one run")
        self._samples.append(rows)

    def _look_at_clock(self) -> None:
        if time.monotonic() > self._deadline:
            raise EngineTimeoutError(
                f"reference: not finished after {self._seconds:g} s of wall time, "
                f"at step {self.steps}"
            )


class InFixedSteps(TrajectoryIntegrator):
    """The grain in steps of ``step`` [s], at most ``longest`` of them, sampled every so many."""

    def __init__(
        self, grain: Grain, step: float, longest: int, every: int | None, seconds: float
    ) -> None:
        super().__init__(grain, seconds)
        self._step, self._longest, self._every = step, longest, every or 0
        if every:
            self._keep(np.array([[0.0, *grain[:4]]]))

    @property
    def time(self) -> float:
        """Return the time [s] since the start."""
        return self.steps * self._step

    @property
    def over(self) -> bool:
        """Return whether the time limit is reached."""
        return self.steps >= self._longest

    def finish(self) -> None:
        """Move to the time limit."""
        self._go(math.inf, watched=False)

    @abstractmethod
    def _go(self, place: float, *, watched: bool = True) -> None:
        """Move to the time limit, or where ``watch`` ends if it is watched."""
