"""What is sampled of the state of a system of contacts."""

from __future__ import annotations

import numpy as np

from harness.pair.geometry import geometry, normal_and_gap
from harness.pair.rates import OPEN, STATE, forces, slider_spring
from harness.pair.records import Floats, Integers, System
from harness.pair.vectors import compiled


@compiled
def sampled(y: Floats, system: System, modes: Integers) -> tuple[Floats, Floats, Floats]:
    """Return forces (bodies, 6) [N, N m], overlaps (contacts,) [m] and springs (contacts, 3, 3).

    An overlap is negative where the bodies are apart; springs are in N, N and N m.
    """
    overlaps, springs = np.empty(len(modes)), np.empty((len(modes), 3, 3))
    for c in range(len(modes)):
        if modes[c, STATE] == OPEN:
            overlaps[c] = normal_and_gap(y, system, c)[1]
        else:
            overlaps[c] = geometry(y, system, c).overlap
        for kind in range(3):
            springs[c, kind] = slider_spring(y, system, modes, c, kind)
    return forces(y, system, modes), overlaps, springs
