"""Motion in fixed steps, by any of the compiled integrators."""

from __future__ import annotations

import numpy as np

from harness.engines.reference.row import Grain, Row
from harness.engines.reference.stretch import VELOCITY_VERLET, End, Scheme, begin, stretch
from harness.engines.reference.trajectory_integrator import InFixedSteps
from harness.errors import EngineNaNError

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
