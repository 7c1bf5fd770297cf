"""What a drop on one fixed sphere yields, whichever engine made it."""

from __future__ import annotations

from dataclasses import dataclass

from harness.cases.drop.parameters import Drop
from harness.observables.provenance import Provenance
from harness.observables.trajectory import Trajectory


@dataclass(frozen=True)
class DropRun:
    """The grain's path, origin in the fixed sphere's centre; ``seconds`` of wall time it took."""

    case: Drop
    path: Trajectory
    seconds: float
    provenance: Provenance
