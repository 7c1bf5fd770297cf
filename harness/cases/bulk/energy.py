"""The energy of a bed: what its springs hold at rest, and whether any is gained.

Scripts of LAMMPS leave what the normal springs hold, from places alone: 8/15 E* sqrt(R*)
overlap^(5/2) of each contact, walls included. Tangential springs are not measured; Coulomb's limit
bounds them. A spring k_t(overlap) s whose contact is pressed at a fixed displacement s gains
(change of k_t) s^2/2 that no force has done work for (Elata and Berryman, Mech. Mater. 24, 229
(1996)): the law itself may add energy, which the bound leaves out, and dashpots and friction take
far more. For codes that leave nothing, a bound of the case stands in.
"""

from __future__ import annotations

import math

from harness.cases.bulk.seeds import Runs
from harness.comparison.verdicts import Check, Kind, Tolerance, judge

ELASTIC = "elastic_ratio"
"""Quantity: what the normal springs of the bed at rest hold, over the energy of the process."""


def tangential_share(friction: float, poisson_ratio: float) -> float:
    """Return what a tangential spring may hold at most, over what the normal one of a contact does.

    Hertz: F = 2/3 k_n overlap holds 3/5 F^2/k_n, k_n = 2 E* a. Mindlin: at most (mu F)^2/(2 k_t),
    k_t = 8 G* a, and k_n/k_t = (2 - nu)/(2 (1 - nu)) (Johnson, Contact Mechanics, 7.2).
    """
    stiffness_ratio = (2.0 - poisson_ratio) / (2.0 * (1.0 - poisson_ratio))
    return 5.0 / 6.0 * friction**2 * stiffness_ratio


def judge_gain(name: str, runs: Runs, quantity: str, share: float, bound: float) -> Check:
    """Return whether any seed gains more than the springs of its bed at rest hold; the worst one.

    ``share`` is that of tangential springs, ``bound`` [-] stands in where nothing is measured.
    """
    held = [row.get(ELASTIC, math.nan) * (1.0 + share) for row in runs.rows]
    reason = f"what the springs of the bed at rest hold, tangential ones at most {share:.2g} of it"
    if not all(map(math.isfinite, held)):
        held = [bound] * len(held)
        reason = "a bound of the elastic energy of the bed under its weight"
    gains = [row[quantity] for row in runs.rows]
    if any(map(math.isnan, gains)):
        return judge(name, Kind.ANALYTIC, math.nan, 0.0, Tolerance("", held[0], 0.0, reason))
    worst = max(range(len(gains)), key=lambda seed: gains[seed] - held[seed])
    return judge(name, Kind.ANALYTIC, gains[worst], 0.0, Tolerance("", held[worst], 0.0, reason))
