"""Partition of a row into blocks that a step can do one after the other.

Blocks end at an open contact: what touches on one side is not felt on the
other. One is looked for near every multiple of BLOCK particles; where there is
none, two blocks are one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.chain.arrays import Chain, Floats
from harness.chain.compiled import compiled
from harness.chain.complementarity import Flags
from harness.chain.stages import STAGES, stage_shift

Cuts = NDArray[np.int64]

BLOCK = 512  # particles: its stages fit the cache, and the work about a block is small beside it


def no_cuts(particles: int) -> Cuts:
    """Return the cuts of an undivided row, see :func:`end_of_block`."""
    return np.zeros(max(1, particles // BLOCK), np.int64)


@compiled
def end_of_block(
    u: Floats, v: Floats, closed: Flags, cuts: Cuts, window: int, step: float
) -> tuple[int, int, bool]:
    """Return the end of the block that begins in ``window``, the window there, what is new.

    ``cuts`` holds the first particle after the cut in each window of BLOCK
    particles, 0 where it has none; it is brought up to date. The end is one more
    than the last particle. New: whether a cut on the way has come, gone or moved.
    """
    moved = False
    for at in range(window + 1, cuts.size):
        cut = _safe_cut(u, v, closed, cuts[at], at * BLOCK, step)
        if cut != cuts[at]:
            cuts[at], moved = cut, True
        if cut > 0:
            return cut, at, moved
    return u.size, cuts.size, moved


@compiled
def _safe_cut(u: Floats, v: Floats, closed: Flags, cut: int, begin: int, step: float) -> int:
    """Return ``cut`` while it is safe, else the next that is, or 0."""
    if cut > 0 and _safe(u, v, closed, cut - 1, step):
        return cut
    for contact in range(begin - 1, begin + BLOCK // 2 - 1):
        if _safe(u, v, closed, contact, step):
            return contact + 1
    return 0


@compiled
def _safe(u: Floats, v: Floats, closed: Flags, contact: int, step: float) -> bool:
    """Return whether ``contact`` is open, and should be after a step."""
    overlap = u[contact] - u[contact + 1]
    later = overlap + step * (v[contact] - v[contact + 1])
    return bool(not closed[contact] and overlap <= 0 and later <= 0)


@compiled
def stays_open(
    chain: Chain, u: Floats, v: Floats, before: Floats, after: Floats,
    contact: int, step: float, tolerance: float,
) -> bool:  # fmt: skip
    """Return whether ``contact`` is open in all stages, to ``tolerance`` [m].

    ``before`` and ``after`` (STAGES,) [N] are the forces of the contacts beside it.
    """
    i, j = contact, contact + 1
    mobility, gravity, beside = chain.mobility, chain.gravity, chain.beside
    a = b = 0.0
    for stage in range(STAGES):
        shift, lift = stage_shift(stage, step)
        overlap = (u[i] - u[j]) + shift * (v[i] - v[j])
        overlap += lift * (a if stage < STAGES - 1 else b)
        if beside[i - 1] * before[stage] + beside[i] * after[stage] - overlap < -tolerance:
            return False
        pressed = before[stage] * mobility[i] + gravity[i]
        pressed -= gravity[j] - after[stage] * mobility[j]
        if stage == 0:
            a = pressed
        elif stage == 1:
            b = pressed
    return True
