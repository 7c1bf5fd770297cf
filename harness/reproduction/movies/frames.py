"""Motions as frames at equal times, ready to be drawn or dumped."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.result import InclineRun
from harness.observables.tower import TowerRun
from harness.observables.trajectory import Trajectory

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class RowMotion:
    """F frames of a row of N particles; frames before time 0 show the grain's approach.

    Displacements and deformations are thousandths of a diameter. ``exaggeration``
    is how many times as large they are drawn: all of them, so that the
    drawn boundaries touch where the particles do. Raise ValueError if a
    particle would be drawn without width. ``sentence`` says what is to be seen,
    with the numbers of ``run``, which is sampled finely and has profiles.
    """

    name: str
    title: str
    sentence: str
    run: TowerRun
    exaggeration: float
    time: Floats  # (F,) [s]
    displacement: Floats  # (F, N) [m] from where all particles just touch
    velocity: Floats  # (F, N) [m/s]
    compression: Floats  # (F, N - 1) [m] partial compression of each contact, 0 where open

    def __post_init__(self) -> None:
        if not (self.exaggeration > 0 and self.drawn_widths.min() > 0):
            raise ValueError(
                f"exaggeration = {self.exaggeration}: must be greater than 0 and leave every "
                "particle a width"
            )

    @property
    def deformation(self) -> Floats:
        """Return how much each diameter is shortened (F, N) [m]."""
        both_sides = np.pad(self.compression, ((0, 0), (1, 1)))
        return np.asarray(both_sides[:, 1:] + both_sides[:, :-1])

    @property
    def force(self) -> Floats:
        """Return the force of every contact (F, N - 1) [N], of equal particles."""
        return np.asarray(self.run.tower.each("stiffness")[0] * self.compression)

    @property
    def gap(self) -> Floats:
        """Return the distance of neighbouring boundaries (F, N - 1) [m]."""
        deformation = self.deformation
        shortened = (deformation[:, 1:] + deformation[:, :-1]) / 2
        return np.asarray(np.diff(self.displacement, axis=1) + shortened)

    @property
    def drawn_centres(self) -> Floats:
        """Return the centres as drawn (F, N) [m], the grain just touching at 0."""
        diameter = np.array(self.run.tower.each("diameter"))
        touching = np.cumsum(diameter) - (diameter + diameter[0]) / 2
        return np.asarray(touching + self.exaggeration * self.displacement)

    @property
    def drawn_widths(self) -> Floats:
        """Return the widths along the row as drawn (F, N) [m]."""
        diameter = np.array(self.run.tower.each("diameter"))
        return np.asarray(diameter - self.exaggeration * self.deformation)

    @property
    def time_over_t0(self) -> Floats:
        """Return the time in contact times of grain and one fixed particle (F,) [1]."""
        return self.time / self.run.tower.contact_time


@dataclass(frozen=True)
class InclineMotion:
    """F frames of the grain over the bumps in two runs, ``below`` and ``above`` the critical angle.

    The runs have trajectories. After its end a run stays where it ended.
    """

    name: str
    title: str
    sentence: str
    below: InclineRun
    above: InclineRun
    time: Floats  # (F,) [s]

    @property
    def runs(self) -> tuple[InclineRun, InclineRun]:
        """Return both runs."""
        return self.below, self.above

    def path(self, run: InclineRun) -> Trajectory:
        """Return the run's trajectory at the frames: the last recorded row by each."""
        rows = np.searchsorted(run.path.time_s, self.time + 1e-9 * self.time[-1], side="right") - 1
        rows = rows.clip(0)
        return Trajectory(**{name: column[rows] for name, column in vars(run.path).items()})


@dataclass(frozen=True)
class Motions:
    """All motions; what no engine could run is None, and ``missing`` says why."""

    pair: RowMotion
    triple: RowMotion
    tower: RowMotion
    incline: InclineMotion | None = None
    missing: str = ""
