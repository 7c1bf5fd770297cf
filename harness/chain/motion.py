"""Arrays that the exact solver works on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from harness.chain.arrays import Chain, Floats
from harness.chain.complementarity import Flags
from harness.chain.events import ORDER
from harness.chain.record import Counts


class Motion(NamedTuple):
    """Arrays of the motion between two changes: the contact set, its forces and its modes."""

    closed: Flags  # (n,)
    factor: Floats  # (3, n)
    overlap: Floats  # (n,) [m]
    force: Floats  # (n,) [N]
    shapes: Floats  # (N, N)
    frequency: Floats  # (N,) [rad/s]
    first: Floats  # (N,)
    amplitudes: Floats  # (4, N)
    series: Floats  # (n, ORDER + 1)
    x: Floats  # (N,) [m] where the search for the next change stands
    w: Floats  # (N,) [m/s]
    y: Floats  # (N,) [m] at a sample
    z: Floats  # (N,) [m/s]
    counts: Counts  # rows of the record, samples, changes in no time
    time: Floats  # (1,) [s] of the last change


def motion_of(chain: Chain, closed: Flags) -> Motion:
    """Return the arrays of a chain at its start, with the contacts (n,) that are ``closed``."""
    u, v = chain.displacement, chain.velocity
    particles, n = u.size, u.size - 1
    return Motion(
        closed, np.zeros((3, n)), np.zeros(n), np.zeros(n),
        np.zeros((particles, particles)), np.zeros(particles), np.zeros(particles),
        np.zeros((4, particles)), np.zeros((n, ORDER + 1)),
        u.copy(), v.copy(), u.copy(), v.copy(), np.zeros(3, np.int64), np.zeros(1),
    )  # fmt: skip
