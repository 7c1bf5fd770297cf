"""The four stages of RK4 in a block of a row, deformable law.

Each stage solves the contact set of the stage before, factorised once and kept,
and checks it; only when it is wrong the contact set is looked for anew.

Arrays are handed over one by one: in compiled code a tuple of them costs more
than a stage of twenty particles.
"""

from __future__ import annotations

from typing import NamedTuple

from harness.chain.arrays import Floats
from harness.chain.compiled import compiled, uncounted
from harness.chain.complementarity import Flags, solve
from harness.chain.record import chain_of_grain
from harness.chain.twisted import factorise_from_both_ends, substitute_from_both_ends

STAGES = 4


class Limits(NamedTuple):
    """What a step is held to."""

    step: float  # [s]
    tolerance: float  # [m] by which a gap may be negative
    longest: int  # touching contacts in a row


@compiled
def stage_shift(stage: int, step: float) -> tuple[float, float]:
    """Return s [s] and l [s2] of a stage at ``u + s v + l a``.

    The acceleration a is that of the stage before the last.
    """
    if stage == 0:
        return 0.0, 0.0
    shift = 0.5 * step if stage < STAGES - 1 else step
    return shift, 0.0 if stage == 1 else 0.5 * step * shift


@uncounted
def advance(
    u: Floats, v: Floats, new_u: Floats, new_v: Floats, mobility: Floats, gravity: Floats,
    diagonal: Floats, beside: Floats, closed: Flags, pivot: Floats, carry: Floats,
    overlap: Floats, padded: Floats, a: Floats, b: Floats, c: Floats, factor: Floats,
    edges: Floats, limits: Limits, stages: int,
) -> int:  # fmt: skip
    """Do so many ``stages`` in a block; with all of them, set its state after the step.

    ``closed``, ``pivot`` and ``carry`` (n,) are the contact set that is
    factorised. ``overlap`` (n,) [m], ``padded`` (n + 2,) [N], the forces between
    two zeros, and the accelerations of three stages (N,) [m/s2] have this room
    at least. ``edges`` (2, STAGES) [N] takes the forces of the first and the
    last contact. Return how many contacts touch from the first particle on;
    minus the length of a chain of touching contacts if it is longer than
    allowed; or -1 where no contact set fits.
    """
    n = diagonal.size
    padded[0] = padded[n + 1] = 0.0
    force = padded[1 : n + 1]
    touching = 0
    for stage in range(stages):
        shift, lift = stage_shift(stage, limits.step)
        _overlaps(u, v, a if stage < STAGES - 1 else b, shift, lift, overlap)
        substitute_from_both_ends(overlap, pivot, carry, force)
        if _wrong(overlap, beside, pivot, force, limits.tolerance):
            found = solve(overlap[:n], diagonal, beside, closed, factor, force, limits.tolerance)
            if found < 0 or found > limits.longest:
                return -abs(found)
            factorise_from_both_ends(closed, diagonal, beside, pivot, carry)
        edges[0, stage], edges[1, stage] = force[0], force[n - 1]
        if stage == 0:
            touching = chain_of_grain(force)
            _accelerate(padded, mobility, gravity, a)
        elif stage < STAGES - 1:
            _accelerate(padded, mobility, gravity, b if stage == 1 else c)
    if stages == STAGES:
        _finish(u, v, new_u, new_v, a, b, c, padded, mobility, gravity, limits.step)
    return touching


@compiled
def _overlaps(u: Floats, v: Floats, a: Floats, shift: float, lift: float, overlap: Floats) -> None:
    """Set the overlaps (n,) [m] at ``u + shift v + lift a``."""
    for i in range(u.size - 1):
        overlap[i] = (u[i] - u[i + 1]) + shift * (v[i] - v[i + 1]) + lift * (a[i] - a[i + 1])


@compiled
def _wrong(overlap: Floats, beside: Floats, pivot: Floats, force: Floats, tolerance: float) -> int:
    """Return how many contacts pull, or are open and overlap, by more than ``tolerance`` [m]."""
    n = force.size
    wrong = 0
    for i in range(1, n - 1):
        gap = beside[i - 1] * force[i - 1] + beside[i] * force[i + 1] - overlap[i]
        wrong += (gap if pivot[i] == 0 else force[i]) < -tolerance * (
            1.0 if pivot[i] == 0 else pivot[i]
        )
    first = beside[0] * force[1] - overlap[0] if n > 1 else -overlap[0]
    last = beside[n - 2] * force[n - 2] - overlap[n - 1] if n > 1 else first
    for i, gap in ((0, first), (n - 1, last)):
        wrong += gap < -tolerance if pivot[i] == 0 else force[i] < -tolerance * pivot[i]
    return wrong


@compiled
def _accelerate(force: Floats, mobility: Floats, gravity: Floats, acceleration: Floats) -> None:
    """Set the accelerations (N,) [m/s2] from the contact forces (N + 1,) [N], 0 at both ends."""
    for i in range(mobility.size):
        acceleration[i] = (force[i] - force[i + 1]) * mobility[i] + gravity[i]


@compiled
def _finish(
    u: Floats, v: Floats, new_u: Floats, new_v: Floats, a: Floats, b: Floats, c: Floats,
    force: Floats, mobility: Floats, gravity: Floats, step: float,
) -> None:  # fmt: skip
    """Set the state after the step from the forces (N + 1,) [N] of the fourth stage."""
    square, sixth = step**2 / 6, step / 6
    for i in range(u.size):
        d = (force[i] - force[i + 1]) * mobility[i] + gravity[i]
        new_u[i] = u[i] + step * v[i] + square * (a[i] + b[i] + c[i])
        new_v[i] = v[i] + sixth * (a[i] + 2 * (b[i] + c[i]) + d)
