"""Motion in fixed steps, by any of the compiled integrators."""

from __future__ import annotations

import math

import numpy as np

from harness.engines.reference.row import Grain, Row
from harness.engines.reference.stretch import VELOCITY_VERLET, End, Scheme, begin, stretch
from harness.engines.reference.trajectory_integrator import TrajectoryIntegrator
from harness.errors import EngineNaNError

AT_ONCE = 20_000_000
"""Steps between two looks at the clock."""

ROWS = 65_536
"""Samples kept at once."""


class FixedStep(TrajectoryIntegrator):
    """The grain in steps of ``step`` [s], at most ``longest`` of them, sampled every so many."""

    def __init__(
        self, method: int, grain: Grain, row: Row, step: float, longest: int,
        every: int | None, seconds: float,
    ) -> None:  # fmt: skip
        super().__init__(begin(method, grain, row), seconds)
        self._method, self._row, self._step, self._longest = method, row, step, longest
        self._every = every or 0
        self._buffer = np.empty((ROWS if every else 1, 5))
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

    def watch(self, place: float, floor: float) -> None:  # noqa: ARG002 - looked at every 50 steps
        """Move until x > ``place`` [m], the grain moves back, or the time limit."""
        if self._method == VELOCITY_VERLET:  # LAMMPS's ``run`` takes the forces anew
            self.grain = begin(self._method, self.grain, self._row)
        self._go(watched=True, place=place)

    def finish(self) -> None:
        """Move to the time limit."""
        self._go(watched=False, place=math.inf)

    def _go(self, *, watched: bool, place: float) -> None:
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
