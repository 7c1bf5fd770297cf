"""Errors found beyond the restatement's list: of the restatement, and of the source."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from harness.comparison.convergence import slope_order
from harness.reproduction.claims import Statement, claim, compare
from harness.reproduction.ledger.beyond_towers import (
    one_curve,
    static_tower,
    structure,
    tall_towers,
)
from harness.reproduction.ledger.contact import integrate
from harness.reproduction.source import SOURCES
from harness.theory.dashpot import damping_ratio, restitution_clipped
from harness.theory.free_chain import compliance

_FLOOR = 0.1367  # the restatement's, of the clipped restitution


def statements() -> list[Statement]:
    """Return the rows that need a computation of their own."""
    return [
        _clipping(),
        _joining(),
        static_tower(),
        tall_towers(),
        one_curve(),
        structure(),
        _first_order(),
    ]


def rebound_clipped(nominal: float) -> float:
    """Return the restitution of a clipped contact that is nominally ``nominal``."""
    return integrate(1.0, 1.0, 2 * damping_ratio(nominal), "released").restitution


def _clipping() -> Statement:
    named = {e: rebound_clipped(e) for e in (1e-9, 1e-20, 0.0)}
    own = brentq(lambda x: rebound_clipped(10.0**x) - _FLOOR, -19.0, -6.0)
    return compare(
        SOURCES["beyond-1"],
        printed=_FLOOR,
        found=named[0.0],
        computed="contact integrated until its force vanishes: e = "
        + ", ".join(f"{value:.4f} at nominal {e:g}" for e, value in named.items())
        + f"; exp(-2 zeta acos(zeta)/sqrt(1 - zeta^2)) gives {restitution_clipped(1.0):.4f} at "
        f"zeta = 1; {_FLOOR:g} is that of nominal {10**own:.0e}; overdamped contacts go below",
        corrected=math.exp(-2),
    )


def _joining() -> Statement:
    overlaps = np.array([0.9, 0.6, 1.0]) / 10
    law = compliance(3, deformable=True)
    joined = np.linalg.solve(law, overlaps)
    # one after the other from the closest, each joined boundary overlaps at the moment
    second = overlaps[1] - 0.5 * overlaps[2]
    first = overlaps[0] - 0.5 * float(np.linalg.solve(law[1:, 1:], overlaps[1:])[0])
    return claim(
        SOURCES["beyond-2"],
        holds=bool((joined > 0).all()),
        computed="overlaps of 0.09, 0.06 and 0.10 m: contact 3 closes, 2 then overlaps by "
        f"{second:.3f} m, 1 then by {first:.4f} m; all three closed carry "
        + ", ".join(f"{value:.4f}" for value in joined)
        + " m: the one in the middle would have to pull",
    )


def symplectic_euler_error(steps: int, shifted: bool) -> float:
    """Return the error of the displacement [v0/omega] after 0.7 of half a period.

    Velocity first, then position, for a grain with weight on a spring (omega = v0 = 1,
    g = 0.3): the scheme is a matrix, taken to the power of the steps. ``shifted``
    takes the first velocity as that of half a step before.
    """
    weight, end = 0.3, 0.7 * math.pi
    h = end / steps
    advance = np.array([[1 - h * h, h, h * h * weight], [-h, 1.0, h * weight], [0.0, 0.0, 1.0]])
    start = np.array([0.0, 1.0 - (0.5 * h * weight if shifted else 0.0), 1.0])
    place = float((np.linalg.matrix_power(advance, steps) @ start)[0])
    exact = weight * (1 - math.cos(end)) + math.sin(end)
    return abs(place - exact)


def _first_order() -> Statement:
    steps = np.array([50, 100, 200, 400, 800])
    orders = {
        shifted: slope_order(1 / steps, [symplectic_euler_error(int(n), shifted) for n in steps])
        for shifted in (False, True)
    }
    first, second = orders[False][0], orders[True][0]
    return claim(
        SOURCES["beyond-7"],
        holds=abs(first - 1) < 0.1 and abs(second - 1) < 0.1,
        corrected_holds=abs(first - 1) < 0.1 and abs(second - 2) < 0.1,
        computed=f"order {first:.3f} for a grain with weight on a spring; {second:.3f} once the "
        "first velocity is taken back by gravity's half step: it is leapfrog, started half a step "
        "late",
    )
