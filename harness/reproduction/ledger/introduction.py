"""The introduction: springs in series, equation (1), and the limit of infinite stiffness."""

from __future__ import annotations

import numpy as np

from harness.cases.tower.impulse_table import impulse_table
from harness.parameters.tower import Tower
from harness.reproduction import as_printed
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.source import SOURCES

_HEIGHTS = range(1, 21)


def statements() -> list[Statement]:
    """Return the rows of this part."""
    return [
        compare(
            SOURCES["eq-1"],
            printed=[as_printed.series_stiffness(1.0, n) for n in _HEIGHTS],
            found=[stiffness_of_springs(n) for n in _HEIGHTS],
            computed="equilibrium of n massless springs solved for n = 1 to 20; the source's own "
            "deformable particles give k/(2n - 1) instead (erratum-13)",
        ),
        _limit(),
    ]


def stiffness_of_springs(springs: int) -> float:
    """Return the end-to-end stiffness of equal springs in series, by solving their equilibrium.

    The first end is held, the last one pushed with a unit force; k = 1.
    """
    balance = 2 * np.eye(springs) - np.eye(springs, k=1) - np.eye(springs, k=-1)
    balance[-1, -1] = 1.0
    push = np.zeros(springs)
    push[-1] = 1.0
    return float(1 / np.linalg.solve(balance, push)[-1])


def _limit() -> Statement:
    stiffnesses = (1e6, 1e9, 1e12)
    ratios = [
        impulse_table(
            heights=(10,), stiffnesses=(k,), speeds=(2.0,), laws=("deformable",), solver="exact"
        )[0].ratio
        for k in stiffnesses
    ]
    rigid = impulse_table(
        heights=(10,),
        stiffnesses=(1e6,),
        speeds=(2.0,),
        laws=("deformable",),
        solver="exact",
        case=Tower(gravity=0.0),
    )[0].ratio
    numbers = ", ".join(f"{a:.5f} at {k:.0e} N/m" for k, a in zip(stiffnesses, ratios, strict=True))
    return claim(
        SOURCES["text-limit"],
        holds=abs(ratios[-1] - rigid) < 1e-4 and rigid < 0.9,
        computed=f"alpha(10) = {numbers}; {rigid:.5f} without gravity, where stiffness drops out: "
        "the limit is not 1, at which a base that is rigid from the start would stand",
    )
