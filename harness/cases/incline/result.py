"""What a run of the incline yields, whichever engine made it."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from harness.cases.incline.parameters import Incline
from harness.observables.provenance import Provenance
from harness.observables.trajectory import Trajectory


class Motion(StrEnum):
    """The outcome of a run. Cut off by time is undecided, never trapped."""

    MOVES_ON = "moves_on"
    TRAPPED = "trapped"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Crests:
    """The crests that the grain passed, one entry each.

    ``time_s`` [s]; ``margin_J`` [J], the mechanical energy above that of a
    grain at rest on the crest; both of shape (crests,).
    """

    time_s: NDArray[np.float64]
    margin_J: NDArray[np.float64]


@dataclass(frozen=True)
class InclineRun:
    """One run of the grain over the row.

    ``margin_J`` [J] is the mechanical energy at the end above that of a grain
    at rest on the crest ahead (in the passage route: the one to pass);
    ``touching`` tells whether the grain was in contact then.
    """

    case: Incline
    motion: Motion
    margin_J: float
    touching: bool
    crests: Crests
    time_s: float
    steps: int
    seconds: float
    provenance: Provenance
    trajectory: Trajectory | None = field(default=None, repr=False)

    @property
    def path(self) -> Trajectory:
        """Return the trajectory; raise ValueError for a run that kept none."""
        if self.trajectory is None:
            raise ValueError("this run kept no trajectory")
        return self.trajectory

    @property
    def margin(self) -> float:
        """Return the margin in units of m g d."""
        return self.margin_J / self.case.weight_energy

    @property
    def quantities(self) -> dict[str, float]:
        """Return what the case declares to measure, by name."""
        return {
            "margin_over_mgd": self.margin,
            "moves_on": float(self.motion is Motion.MOVES_ON),
            "touching": float(self.touching),
            "time_s": self.time_s,
            "steps": float(self.steps),
        }
