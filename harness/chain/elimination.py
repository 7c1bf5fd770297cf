"""The contact set of a chain by one elimination from the left, without iteration.

Minimise ``f A f / 2 - overlap f`` over ``f >= 0`` with tridiagonal A, contact by
contact (Bellman). Given the force y on the next contact, the best force on
contact i is ``g_i(y)``: piecewise linear, falling, and 0 beyond some y. From
``a_i f + b_(i-1) g_(i-1)(f) = overlap_i - b_i y`` each break point (f, g) of
``g_(i-1)`` moves to ``((overlap_i - a_i f - b_(i-1) g)/b_i, f)`` of ``g_i``; at
most one is added and all beyond ``f = g_i(0)`` are dropped. The last force is
``g_n(0)``, and the others follow backwards. Cost O(N) times the break points
alive, which are two or three; never more than N.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from harness.chain.arrays import Floats
from harness.chain.compiled import compiled


@compiled
def closed_contacts(
    overlap: Floats, diagonal: Floats, beside: Floats, closed: NDArray[np.bool_]
) -> None:
    """Set ``closed`` (n,) to the contacts that carry a force under ``overlap`` (n,) [m]."""
    n = overlap.size
    start = np.zeros(n + 1, np.int64)
    y, f = np.zeros(4 * n + 8), np.zeros(4 * n + 8)
    size = 0
    for i in range(n):
        if size + (size - start[i - 1]) + 3 > y.size:
            y, f = np.append(y, np.zeros(y.size)), np.append(f, np.zeros(f.size))
        begin = start[i - 1] if i > 0 else 0
        before = beside[i - 1] if i > 0 else 0.0
        start[i] = size
        size += _next_response(y, f, begin, size, overlap[i], diagonal[i], before, beside[i])
    start[n] = size
    force = 0.0
    for i in range(n - 1, -1, -1):
        force = _evaluate(y, f, start[i], start[i + 1], force)
        closed[i] = force > 0


@compiled
def _next_response(
    y: Floats, f: Floats, begin: int, end: int,
    overlap: float, diagonal: float, before: float, beside: float,
) -> int:  # fmt: skip
    """Write the break points of ``g_i`` at ``end`` from those of ``g_(i-1)``; return how many.

    Those of ``g_(i-1)`` are ``y, f [begin:end]``, y ascending from 0.
    """
    at, total = 0.0, before * f[begin] if end > begin else 0.0
    if overlap <= total:
        y[end] = f[end] = 0.0
        return 1
    lowest, slope, k = total, diagonal, begin + 1
    while k < end:
        reached = diagonal * y[k] + before * f[k]
        if reached >= overlap:
            slope = (reached - total) / (y[k] - at)
            break
        at, total = y[k], reached
        k += 1
    y[end], f[end] = 0.0, at + (overlap - total) / slope
    if beside == 0:
        return 1
    count = 1
    for p in range(min(k, end) - 1, begin, -1):
        y[end + count] = (overlap - diagonal * y[p] - before * f[p]) / beside
        f[end + count] = y[p]
        count += 1
    y[end + count], f[end + count] = (overlap - lowest) / beside, 0.0
    return count + 1


@compiled
def _evaluate(y: Floats, f: Floats, begin: int, end: int, at: float) -> float:
    """Return ``g(at)`` of the break points ``y, f [begin:end]``."""
    for p in range(begin + 1, end):
        if at < y[p]:
            part = (at - y[p - 1]) / (y[p] - y[p - 1])
            return float(f[p - 1] + (f[p] - f[p - 1]) * part)
    return float(f[end - 1])
