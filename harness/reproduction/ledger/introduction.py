"""The introduction: springs in series, equation (1), and the limit of infinite stiffness."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from harness.cases.tower.impulse_table import impulse_table
from harness.parameters.tower import Tower
from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import Statement, claim, compare

_HEIGHTS = range(1, 21)


def statements(_: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield compare(
        "eq-1", found=[stiffness_of_springs(n) for n in _HEIGHTS], k=1.0, n=np.array(_HEIGHTS)
    )

    def ratio(stiffness: float, case: Tower | None = None) -> float:
        return impulse_table(
            heights=(10,), stiffnesses=(stiffness,), speeds=(2.0,), laws=("deformable",), case=case
        )[0].ratio

    ratios = {k: ratio(k) for k in (1e6, 1e9, 1e12)}
    rigid = ratio(1e6, Tower(gravity=0.0))
    yield claim(
        "text-limit",
        stiffest=ratios[1e12],
        ratios=[f"{a:.5f} at {k:.0e} N/m" for k, a in ratios.items()],
        rigid=rigid,
    )


def stiffness_of_springs(springs: int) -> float:
    """Return the end-to-end stiffness of equal springs in series, by solving their equilibrium.

    The first end is held, the last one pushed with a unit force; k = 1.
    """
    balance = 2 * np.eye(springs) - np.eye(springs, k=1) - np.eye(springs, k=-1)
    balance[-1, -1] = 1.0
    push = np.zeros(springs)
    push[-1] = 1.0
    return float(1 / np.linalg.solve(balance, push)[-1])
