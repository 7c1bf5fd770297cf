"""Errors found beyond the restatement's list: of the restatement, and of the source."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from harness.comparison.convergence import slope_order
from harness.reproduction.claims import (
    Ledger,
    Source,
    Statement,
    Width,
    claim,
    compare,
)
from harness.reproduction.ledger.beyond_towers import (
    one_curve,
    static_tower,
    structure,
    tall_towers,
)
from harness.reproduction.ledger.contact import integrate
from harness.reproduction.ledger.errata import Erratum
from harness.theory.dashpot import damping_ratio, restitution_clipped
from harness.theory.free_chain import compliance

_RESTATEMENT = "Errata, of our restatement"
_SOURCE = "Errata, of the source, new"
_FLOOR = 0.1367  # the restatement's, of the clipped restitution


def statements(rows: Ledger) -> list[Statement]:
    """Return the rows; ``rows`` are those of the source."""
    return [
        _clipping(),
        _joining(),
        Erratum(
            "beyond-3",
            "the closest pair touches only if it is closer than a diameter",
            ("text-closest-pair", "text-closest-proof"),
            where=_SOURCE,
        ).judged(rows),
        static_tower(),
        tall_towers(),
        one_curve(),
        structure(),
        _first_order(),
        *(erratum.judged(rows) for erratum in _OF_THE_SOURCE),
    ]


_OF_THE_SOURCE = tuple(
    Erratum(key, says, wrong, where=_SOURCE)
    for key, says, wrong in (
        ("beyond-8", "RK4's error of the peak does not fall with stiffness", ("text-error-falls",)),
        ("beyond-9", "the sum of eq. (2) repeats a power; eq. (3) counts one more term",
         ("eq-2", "eq-3-index")),
        ("beyond-10", "the example of four has 2b_0 where its next line needs b_0",
         ("eq-four-inserted",)),
        ("beyond-11", "the proof needs the larger deformation of the two, not the smaller",
         ("eq-a10", "eq-a11")),
        ("beyond-12", "the centres do not give the length of a chain", ("text-odd-chains",)),
        ("beyond-13", "k/P is a length unless P is a force per length", ("eq-10",)),
        ("beyond-14", "1e4 to 1e6 are two orders of magnitude", ("text-orders-of-magnitude",)),
        ("beyond-15", "J_0 of an ideal shock is half of the elastic J(1) that replaces it",
         ("eq-13-reference",)),
        ("beyond-16", "an impulse acts along the contact's normal: 1/4 + 3/4 (1 - alpha)^2",
         ("eq-13-direction",)),
        ("beyond-17", "reduced stiffness of one particle cannot make the grain rebound",
         ("text-softer",)),
        ("beyond-18", "the source's particles store (2n - 1) U_1", ("text-u-n-particles",)),
        ("beyond-19", "the grain's chain levels off at four contacts, not ten", ("text-plateau",)),
        ("beyond-20", "the window is no collision and rebound, and what is compressed most is not "
         "the same in caption and text", ("text-half-period", "text-maximum-of-what")),
        ("beyond-21", "deformations differ by a thousand times what the conclusion says",
         ("text-differences",)),
        ("beyond-22", "the third particle is the least deformed at first only",
         ("text-least-deformed",)),
    )
)  # fmt: skip


def rebound_clipped(nominal: float) -> float:
    """Return the restitution of a clipped contact that is nominally ``nominal``."""
    return integrate(1.0, 1.0, 2 * damping_ratio(nominal), "released").restitution


def _clipping() -> Statement:
    named = {e: rebound_clipped(e) for e in (1e-9, 1e-20, 0.0)}
    own = brentq(lambda x: rebound_clipped(10.0**x) - _FLOOR, -19.0, -6.0)
    return compare(
        Source(
            "beyond-1",
            _RESTATEMENT,
            "clipping puts a floor of 0.1367 under the restitution, for any nominal e",
        ),
        printed=_FLOOR,
        found=named[0.0],
        width=Width(5e-5, "1", "half of the last digit given"),
        computed="contact integrated until its force vanishes: e = "
        + ", ".join(f"{value:.4f} at nominal {e:g}" for e, value in named.items())
        + f"; exp(-2 zeta acos(zeta)/sqrt(1 - zeta^2)) gives {restitution_clipped(1.0):.4f} at "
        f"zeta = 1; {_FLOOR:g} is that of nominal {10**own:.0e}; overdamped contacts go below",
        corrected=math.exp(-2),
        correction="exp(-2) = 0.1353 at critical damping; the number was measured at a larger e",
        evidence=("tests/theory/test_dashpot.py",),
    )


def _joining() -> Statement:
    overlaps = np.array([0.9, 0.6, 1.0]) / 10
    law = compliance(3, deformable=True)
    joined = np.linalg.solve(law, overlaps)
    # one after the other from the closest, each joined boundary overlaps at the moment
    second = overlaps[1] - 0.5 * overlaps[2]
    first = overlaps[0] - 0.5 * float(np.linalg.solve(law[1:, 1:], overlaps[1:])[0])
    return claim(
        Source(
            "beyond-2",
            "the source, Appendix A, read by what overlaps now",
            "chains may be joined wherever their boundaries overlap at the moment",
        ),
        holds=bool((joined > 0).all()),
        computed="overlaps of 0.09, 0.06 and 0.10 m: contact 3 closes, 2 then overlaps by "
        f"{second:.3f} m, 1 then by {first:.4f} m; all three closed carry "
        + ", ".join(f"{value:.4f}" for value in joined)
        + " m: the one in the middle would have to pull",
        correction="close what is certain, whatever the undecided contacts do",
        evidence=("tests/chain/test_contact_solvers.py",),
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
        Source("beyond-7", _RESTATEMENT, "MFiX's Euler scheme is of first order"),
        holds=abs(first - 1) < 0.1 and abs(second - 1) < 0.1,
        corrected_holds=abs(first - 1) < 0.1 and abs(second - 2) < 0.1,
        computed=f"order {first:.3f} for a grain with weight on a spring; {second:.3f} once the "
        "first velocity is taken back by gravity's half step: it is leapfrog, started half a step "
        "late",
        correction="second order but for the first half step of gravity",
        evidence=("tests/regression/test_mfix_tower.py",),
        why="a tenth of an order",
    )
