"""A grain's motion until it passes a place or turns back: the interface, and motion in fixed steps.

As in the LAMMPS script, it is looked at every 50 steps whether the grain has passed a place or
turned back. :mod:`harness.solvers.grain.adaptive` has the same interface without steps.
"""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from harness.errors import EngineMemoryError, EngineNaNError, EngineTimeoutError
from harness.observables.reference import Trajectory
from harness.solvers.grain.row import Grain, Row, energy
from harness.solvers.grain.schemes import VELOCITY_VERLET, End, Scheme, begin, stretch

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


AT_ONCE = 20_000_000
"""Steps between two looks at the clock."""

ROWS = 65_536
"""Samples kept at once."""


class FixedStep(InFixedSteps):
    """The grain over a row, in fixed steps of a method."""

    def __init__(
        self, method: int, grain: Grain, row: Row, step: float, longest: int,
        every: int | None, seconds: float,
    ) -> None:  # fmt: skip
        super().__init__(begin(method, grain, row), step, longest, every, seconds)
        self._method, self._row = method, row
        self._buffer = np.empty((ROWS if every else 1, 5))

    def watch(self, place: float, floor: float) -> None:  # noqa: ARG002 - looked at every 50 steps
        """Move until x > ``place`` [m], the grain moves back, or the time limit."""
        if self._method == VELOCITY_VERLET:  # LAMMPS's ``run`` takes the forces anew
            self.grain = begin(self._method, self.grain, self._row)
        self._go(place)

    def _go(self, place: float, *, watched: bool = True) -> None:
        end, scheme = End.FULL, Scheme(self._method, self._row, self._step)
        while end is End.FULL or (end is End.LAST_STEP and not self.over):
            self._look_at_clock()
            last = min(self._longest, self.steps + AT_ONCE)
            self.grain, self.steps, taken, code = stretch(
                scheme, self.grain, self.steps, last, watched, place, self._every, self._buffer
            )
            end = End(code)
            if taken:
                self._keep(self._buffer[:taken].copy())
        if end is End.NOT_A_NUMBER:
            raise EngineNaNError(
                f"reference: the grain's state overflowed (NaN) by step {self.steps}"
            )
