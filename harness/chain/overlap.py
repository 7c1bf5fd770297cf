"""The overlap law of DEM codes: the force of a contact depends on its own overlap only."""

from __future__ import annotations

import numpy as np

from harness.chain.arrays import Floats
from harness.chain.compiled import compiled


@compiled
def forces(overlap: Floats, diagonal: Floats, force: Floats) -> None:
    """Set ``force = max(overlap, 0) / diagonal`` (n,) [N] from the overlaps (n,) [m]."""
    for i in range(overlap.size):
        force[i] = max(overlap[i], 0.0) / diagonal[i]


def compressions(positions: Floats, diameter: float) -> Floats:
    """Return the overlaps of equal spheres where positive, else 0 (n,) [m].

    ``positions`` are the centres (N,) [m], ascending.
    """
    return np.maximum(diameter - np.diff(positions), 0.0)
