"""Errata of our restatement of the source, and errors of the source beyond them.

Where a row is about the restatement, its ``where`` says so: the status is that of the erratum,
not of the source.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from harness.cases.tower.run import covering, tower
from harness.comparison.convergence import slope_order
from harness.observables.tower import impulse
from harness.parameters.tower import LAWS, Law, Tower
from harness.reproduction.claims import (
    SOURCES,
    ClaimStatus,
    Ledger,
    Printed,
    Source,
    Statement,
    claim,
    compare,
)
from harness.reproduction.ledger.results import row_energy
from harness.reproduction.ledger.samples import (
    MEDIAN,
    Ratios,
    heights_with_structure_window,
    integrate,
    ratios,
)
from harness.theory.chain import compliance, series_stiffness, static_forces
from harness.theory.contact import damping_ratio, restitution_clipped


def restatement_statements(printed: Printed, rows: Ledger) -> Iterator[Statement]:
    """Yield the errata; ``rows`` are those of the source."""
    yield from (judged(source, rows) for source in SOURCES.values() if source.wrong)
    balance, separation, square = rows["eq-6"], rows["text-separation"], rows["eq-18"]
    yield claim("erratum-1", evidence=balance.evidence, row=balance, line=_line)
    yield claim(
        "erratum-7",
        evidence=separation.evidence,
        row=rows["text-t-c"],
        formula=rows["eq-11"].found,
        ratio=rows["eq-11"].found / printed.contact_time,
        separation=separation,
        line=_line,
    )
    stiffness, first, n = 100.0, 0.2, 10
    yield claim(
        "erratum-12",
        evidence=square.evidence,
        rows=(square, rows["eq-u-2"]),
        with_square=n * 0.5 * stiffness * (n * first) ** 2,
        right=n * 0.5 * stiffness * first**2,
        springs=n,
        line=_line,
    )
    contacts = 10
    yield compare(
        "erratum-13",
        printed=series_stiffness(contacts, 1.0, deformable=True),
        found=1 / (2 * row_energy(contacts)),
        contacts=contacts,
        springs=1 / contacts,
    )


def judged(erratum: Source, rows: Ledger) -> Statement:
    """Return the row of an erratum from the rows that it calls wrong, and those that are right."""
    wrong = [rows[key] for key in erratum.wrong]
    right = [rows[key] for key in erratum.right]
    return claim(
        erratum,
        holds=all(row.status is not ClaimStatus.REPRODUCED for row in wrong)
        and all(row.status is ClaimStatus.REPRODUCED for row in right),
        evidence=tuple(dict.fromkeys(link for row in wrong for link in row.evidence)),
        computed="; ".join(_line(row) for row in (*wrong, *right)),
    )


def _line(row: Statement) -> str:
    key, unit = row.source.key, row.source.unit
    if np.isnan(row.printed):
        return f"{key}, {row.status}: {row.computed}"
    numbers = f"printed {row.printed:.6g}, found {row.found:.6g}"
    if not np.isnan(row.corrected):
        numbers += f", corrected {row.corrected:.6g}"
    return f"{key}, {row.status}: {numbers}{'' if unit == '1' else f' {unit}'}"


_FLOOR = 0.1367  # the restatement's, of the clipped restitution


def beyond_statements(_: Printed) -> Iterator[Statement]:
    """Yield the rows that need a computation of their own."""
    yield _clipping()
    yield _joining()
    yield from _towers()
    yield _one_curve()
    yield _first_order()


def rebound_clipped(nominal: float) -> float:
    """Return the restitution of a clipped contact that is nominally ``nominal``."""
    return integrate(1.0, 1.0, 2 * damping_ratio(nominal), "released").restitution


def _clipping() -> Statement:
    named = {e: rebound_clipped(e) for e in (1e-9, 1e-20, 0.0)}
    root = brentq(lambda x: rebound_clipped(10.0**x) - _FLOOR, -19.0, -6.0)
    return compare(
        "beyond-1",
        printed=_FLOOR,
        found=named[0.0],
        named=[f"{value:.4f} at nominal {e:g}" for e, value in named.items()],
        closed=restitution_clipped(1.0),
        nominal=10**root,
    )


def _joining() -> Statement:
    overlaps = np.array([0.9, 0.6, 1.0]) / 10
    law = compliance(3, deformable=True)
    joined = np.linalg.solve(law, overlaps)
    # one after the other from the closest, each joined boundary overlaps at the moment
    return claim(
        "beyond-2",
        second=overlaps[1] - 0.5 * overlaps[2],
        first=overlaps[0] - 0.5 * float(np.linalg.solve(law[1:, 1:], overlaps[1:])[0]),
        joined=joined,
    )


def _towers() -> Iterator[Statement]:
    """Hold the numbers that the restatement gives for towers to runs and statics."""
    heights = np.arange(2, 20)
    yield compare(
        "beyond-4",
        found=[
            float((compliance(int(n), deformable=True) @ static_forces(int(n), 1.0, 1.0))[-1])
            for n in heights
        ],
        n=heights,
    )
    runs = ratios()

    def settled(some: Ratios, lowest: int) -> int:
        """Return how many runs stay within 0.53 and 0.54 from a height on."""
        return sum(
            all(0.525 <= a < 0.545 for n, a in alpha.items() if n >= lowest)
            for alpha in some.values()
        )

    yield claim("beyond-5", runs=runs, tall=runs[MEDIAN], soft=runs[1e5, 2.0], settled=settled)
    yield claim("beyond-6", found={law: heights_with_structure_window(law) for law in LAWS})


def impulse_ratio_at(gamma: float, height: int, law: Law, stiffness: float = 1e6) -> float:
    """Return alpha(n), turnaround window, at m g/(v0 sqrt(k m)) = gamma."""
    speed = 9.81 / (gamma * math.sqrt(stiffness))
    tall, single = (
        impulse(covering(tower(case, solver="exact", samples=1000), "turnaround"))
        for case in (
            Tower(height=n, law=law, stiffness=stiffness, speed=speed) for n in (height, 1)
        )
    )
    return tall / single


def _jump(law: Law, low: float, high: float) -> tuple[float, float, float]:
    """Return where alpha(6) jumps between two gammas, and its values on both sides."""
    below, above = impulse_ratio_at(low, 6, law), impulse_ratio_at(high, 6, law)
    while high - low > 1e-5:
        middle = 0.5 * (low + high)
        value = impulse_ratio_at(middle, 6, law)
        if value - below < 0.5 * (above - below):
            low, below = middle, value
        else:
            high, above = middle, value
    return 0.5 * (low + high), below, above


def _one_curve() -> Statement:
    gamma = 0.009
    same = [impulse_ratio_at(gamma, 6, "deformable", k) for k in (1e4, 1e6, 1e8)]
    spread = max(same) - min(same)
    jumps: dict[Law, tuple[float, float, float]] = {
        "deformable": _jump("deformable", 0.009, 0.014),
        "overlap": _jump("overlap", 0.018, 0.026),
    }
    return claim(
        "beyond-5-curve",
        gamma=gamma,
        spread=spread,
        jumps=jumps,
        listing=" and ".join(
            f"from {below:.3f} to {above:.3f} at {at:.4f} ({law} law)"
            for law, (at, below, above) in jumps.items()
        ),
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
    first, second = (
        slope_order(1 / steps, [symplectic_euler_error(int(n), shifted) for n in steps])[0]
        for shifted in (False, True)
    )
    return claim("beyond-7", first=first, second=second)
