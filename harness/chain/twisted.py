"""The compliance of a contact set factorised from both ends to the middle.

A substitution waits for each result and not for the arithmetic; from both ends
there are two recurrences to wait for at a time.

The contacts are those of a block of the row, n of them from ``low`` on, as in
:mod:`harness.chain.stages`.
"""

from __future__ import annotations

from harness.chain.arrays import Floats
from harness.chain.compiled import compiled
from harness.chain.complementarity import Flags


@compiled
def factorise_from_both_ends(
    closed: Flags, diagonal: Floats, beside: Floats, low: int, n: int, pivot: Floats, carry: Floats
) -> None:
    """Factorise the closed contacts of a block from both ends to its contact n // 2.

    Set ``pivot``, the inverse pivots, 0 where open, and ``carry``, what a contact
    hands on to its neighbour towards the middle; both are arrays of the row.
    """
    middle, last = low + n // 2, low + n - 1
    for i in range(low, middle):
        into = beside[i - 1] * carry[i - 1] if i > low else 0.0
        pivot[i] = 1 / (diagonal[i] - into) if closed[i] else 0.0
        carry[i] = beside[i] * pivot[i]
    for i in range(last, middle, -1):
        into = beside[i] * carry[i + 1] if i < last else 0.0
        pivot[i] = 1 / (diagonal[i] - into) if closed[i] else 0.0
        carry[i] = beside[i - 1] * pivot[i]
    left = beside[middle - 1] * carry[middle - 1] if middle > low else 0.0
    right = beside[middle] * carry[middle + 1] if middle < last else 0.0
    pivot[middle] = 1 / (diagonal[middle] - left - right) if closed[middle] else 0.0
    carry[middle] = 0.0


@compiled
def substitute_from_both_ends(
    overlap: Floats, pivot: Floats, carry: Floats, low: int, n: int, force: Floats
) -> None:
    """Set the forces (n + 2,) [N] of the contact set that is factorised, 0 where open.

    ``overlap`` (n,) [m] and ``force`` are arrays of the block.
    """
    pivot, carry = pivot[low : low + n], carry[low : low + n]
    middle = n // 2
    ends = n - 1 - middle  # contacts right of the middle, as many as left of it or one less
    left, right = overlap[0], overlap[n - 1]
    force[1], force[n] = left, right
    for i in range(1, ends):
        j = n - 1 - i
        left = overlap[i] - carry[i - 1] * left
        right = overlap[j] - carry[j + 1] * right
        force[i + 1], force[j + 1] = left, right
    for i in range(max(ends, 1), middle):
        left = overlap[i] - carry[i - 1] * left
        force[i + 1] = left
    centre = overlap[middle]
    if middle > 0:
        centre -= carry[middle - 1] * force[middle]
    if middle < n - 1:
        centre -= carry[middle + 1] * force[middle + 2]
    centre *= pivot[middle]
    force[middle + 1] = left = right = centre
    for i in range(middle - 1, ends - 1, -1):
        left = pivot[i] * force[i + 1] - carry[i] * left
        force[i + 1] = left
    for k in range(min(ends, middle)):
        i = ends - 1 - k
        j = n - ends + k
        left = pivot[i] * force[i + 1] - carry[i] * left
        right = pivot[j] * force[j + 1] - carry[j] * right
        force[i + 1], force[j + 1] = left, right
