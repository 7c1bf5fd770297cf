"""The compliance of a contact set factorised from both ends to the middle.

A substitution waits for each result and not for the arithmetic; from both ends
there are two recurrences to wait for at a time.
"""

from __future__ import annotations

from harness.chain.arrays import Floats
from harness.chain.compiled import compiled
from harness.chain.complementarity import Flags


@compiled
def factorise_from_both_ends(
    closed: Flags, diagonal: Floats, beside: Floats, pivot: Floats, carry: Floats
) -> None:
    """Factorise the closed contacts from both ends to contact n // 2.

    Set ``pivot`` (n,), the inverse pivots, 0 where open, and ``carry`` (n,), what
    a contact hands on to its neighbour towards the middle.
    """
    n = closed.size
    middle = n // 2
    for i in range(middle):
        into = beside[i - 1] * carry[i - 1] if i > 0 else 0.0
        pivot[i] = 1 / (diagonal[i] - into) if closed[i] else 0.0
        carry[i] = beside[i] * pivot[i]
    for i in range(n - 1, middle, -1):
        into = beside[i] * carry[i + 1] if i < n - 1 else 0.0
        pivot[i] = 1 / (diagonal[i] - into) if closed[i] else 0.0
        carry[i] = beside[i - 1] * pivot[i]
    left = beside[middle - 1] * carry[middle - 1] if middle > 0 else 0.0
    right = beside[middle] * carry[middle + 1] if middle < n - 1 else 0.0
    pivot[middle] = 1 / (diagonal[middle] - left - right) if closed[middle] else 0.0
    carry[middle] = 0.0


@compiled
def substitute_from_both_ends(overlap: Floats, pivot: Floats, carry: Floats, force: Floats) -> None:
    """Set the forces (n,) [N] of the contact set that is factorised, 0 where open."""
    n = force.size
    middle = n // 2
    ends = n - 1 - middle  # contacts right of the middle, as many as left of it or one less
    force[0], force[n - 1] = overlap[0], overlap[n - 1]
    left, right = overlap[0], overlap[n - 1]
    for i in range(1, ends):
        j = n - 1 - i
        left = overlap[i] - carry[i - 1] * left
        right = overlap[j] - carry[j + 1] * right
        force[i], force[j] = left, right
    for i in range(max(ends, 1), middle):
        left = overlap[i] - carry[i - 1] * left
        force[i] = left
    centre = overlap[middle]
    if middle > 0:
        centre -= carry[middle - 1] * force[middle - 1]
    if middle < n - 1:
        centre -= carry[middle + 1] * force[middle + 1]
    centre *= pivot[middle]
    force[middle] = left = right = centre
    for i in range(middle - 1, ends - 1, -1):
        left = pivot[i] * force[i] - carry[i] * left
        force[i] = left
    for k in range(min(ends, middle)):
        i = ends - 1 - k
        j = n - ends + k
        left = pivot[i] * force[i] - carry[i] * left
        right = pivot[j] * force[j] - carry[j] * right
        force[i], force[j] = left, right
