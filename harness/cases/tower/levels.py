"""How much of the tower a verification runs: quick, default or full."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from harness.cases.contract import LevelName

GAMMAS = tuple(float(gamma) for gamma in np.geomspace(1e-4, 0.3, 25))
"""From stiff and fast to soft and slow: the source's six runs lie between 0.0008 and 0.016."""

FINEST = 10_000.0
"""Steps per contact time of the towers of engines beside the main one."""

ORDER_HEIGHT = 4
"""Height of the tower whose error is measured over a ladder of steps, in those engines."""

LADDER = tuple(250.0 * 2.0 ** (i / 2) for i in range(7))
"""Steps per contact time over which the order of an engine's error is measured."""

OWN_LADDER = tuple(125.0 * 2.0 ** (i / 4) for i in range(25))
"""Those of RK4, whose errors scatter more: of fourth order but where a contact changes."""


@dataclass(frozen=True)
class Level:
    """Heights of the towers, of those in engines beside the main one, and Gammas of alpha's map."""

    heights: tuple[int, ...]
    beside: tuple[int, ...]
    gammas: tuple[float, ...]
    chain_figures: bool = True


LEVELS: dict[LevelName, Level] = {
    "quick": Level((1, 2, 19), (1, 4, 19), (), chain_figures=False),
    "default": Level((1, 2, 3, 10, 19), (1, 2, 4, 9, 19), GAMMAS[::3]),
    "full": Level(tuple(range(1, 20)), (1, 2, 4, 9, 19), GAMMAS),
}
