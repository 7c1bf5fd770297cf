"""Motion of the grain over columns in fixed steps, and what of it tables tell."""

from __future__ import annotations

import math

import numpy as np

from harness.engines.reference.columns import Held, advance_by, begin
from harness.engines.reference.row import Grain, Row
from harness.engines.reference.stretch import WATCH
from harness.engines.reference.trajectory_integrator import InFixedSteps
from harness.engines.scene import Scene
from harness.errors import EngineNaNError

CLOCK = 10_000
"""Steps between two looks at the clock."""


def held_of(scene: Scene, row: Row) -> Held:
    """Return the columns of a scene as the kernels take them."""
    assert scene.columns is not None
    n = scene.columns.height
    y = scene.position[1:, 1].reshape(-1, n).copy()
    return Held(
        y=y,
        v=np.zeros_like(y),
        a=np.zeros_like(y),
        damping=row.damping if scene.columns.damped else 0.0,
        deformable=scene.columns.law == "deformable",
        closed=np.ones(y.shape, dtype=np.bool_),
        work=np.zeros((4, n)),
        awake=np.zeros(len(y), dtype=np.bool_),
    )


class OverColumns(InFixedSteps):
    """The grain over columns in steps of a scene, looked at and sampled as over a row."""

    def __init__(self, grain: Grain, row: Row, scene: Scene, seconds: float) -> None:
        self._row, self._held = row, held_of(scene, row)
        grain = begin(grain, row, self._held)
        super().__init__(grain, scene.step, scene.steps, scene.every, seconds)

    @property
    def touching(self) -> bool:
        """Return whether the grain overlaps a top."""
        d, (count, _) = self._row.diameter, self._held.y.shape
        first = math.floor(self.grain.x / d)
        tops = [(i * d, self._held.y[i % count, 0]) for i in (first, first + 1)]
        return any(math.hypot(self.grain.x - x, self.grain.y - y) < d for x, y in tops)

    def energy(self, row: Row) -> float:
        """Return the energy [J] of the motion and the height of the grain."""
        x, y, vx, vy = self.grain[:4]
        return 0.5 * row.mass * (vx * vx + vy * vy) - row.mass * (row.along * x + row.normal * y)

    def watch(self, place: float, floor: float) -> None:  # noqa: ARG002 - looked at every 50 steps
        """Move until x > ``place`` [m], the grain moves back, or the time limit."""
        self.grain = begin(self.grain, self._row, self._held)  # LAMMPS's run takes forces anew
        self._go(place)

    def _go(self, place: float, *, watched: bool = True) -> None:
        while not self.over:
            steps = min(WATCH - self.steps % WATCH, self._longest - self.steps)
            if self._every:
                steps = min(steps, self._every - self.steps % self._every)
            self.grain = advance_by(self.grain, self._row, self._held, self._step, steps)
            self.steps += steps
            if not math.isfinite(sum(self.grain[:4])):
                raise EngineNaNError(
                    f"reference: the grain's state is not a number (NaN) by step {self.steps}"
                )
            if self._every and self.steps % self._every == 0:
                self._keep(np.array([[self.time, *self.grain[:4]]]))
            look = self.steps % WATCH == 0 or self.over
            if watched and look and (self.grain.x > place or self.grain.vx < 0.0):
                return
            if self.steps % CLOCK == 0:
                self._look_at_clock()
