"""How much of each engine a level of verification runs."""

from __future__ import annotations

from dataclasses import dataclass

FINEST = 10_000.0
"""Steps per contact time of the towers whose force and impulse are judged."""

ORDER_HEIGHT = 4
"""Height of the tower whose error is measured over a ladder of steps."""


@dataclass(frozen=True)
class Extent:
    """Stiffness [N/m] and steps per contact of the angles; heights and steps of the towers.

    The first of ``angles`` is the stated one: engines are held against one another at it.
    """

    angles: tuple[tuple[float, float], ...]
    phases: int
    heights: tuple[int, ...]
    ladder: tuple[float, ...]


LADDER = tuple(250.0 * 2.0 ** (i / 2) for i in range(7))
STATED = (1e6, 100.0)
EXTENTS = {
    "quick": Extent((STATED,), 2, (1, 4, 19), LADDER),
    "default": Extent((STATED,), 4, (1, 2, 4, 9, 19), LADDER),
    "full": Extent(
        (
            STATED,
            *((k, n) for k in (1e5, 1e6, 1e7) for n in (50.0, 100.0, 200.0) if (k, n) != STATED),
        ),
        4,
        (1, 2, 4, 9, 19),
        LADDER,
    ),
}
"""By the name of the level."""
