"""The appendices: boundaries of a chain, (A1) to (A11), and the window of the impulse."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.optimize import brentq

from harness.observables.tower import turnaround
from harness.parameters.tower import LAWS, Tower
from harness.reproduction.claims import SOURCES, Printed, Statement, claim, compare
from harness.reproduction.ledger.samples import (
    MEDIAN,
    RADIUS,
    OpenPair,
    ParticleRow,
    TouchingChain,
    contact_intervals,
    heights_with_structure_window,
    impulses,
    off_from_sweeps,
    openings,
    ratios,
    rows,
    run,
    touching_chains,
)
from harness.solvers.chain import forces


def appendix_chains_statements(_: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    yield from _boundaries(touching_chains())
    yield from _deformations(touching_chains())
    yield from _lengths()
    yield _swapped()
    yield from _four()
    yield _odd_coefficients()
    yield from _bounds(rows())
    yield _many_groupings(rows()[:50])
    yield from _proof(openings(rows()))


def _boundaries(chains: Sequence[TouchingChain]) -> Iterator[Statement]:
    centres, before, after = (
        np.concatenate(parts)
        for parts in zip(
            *((c.centres, c.boundaries[:-1], c.boundaries[1:]) for c in chains), strict=True
        )
    )
    yield compare("eq-a1", found=after, x=centres, b=before, chains=len(chains))
    law = SOURCES["eq-a2"]
    yield compare(
        law,
        printed=[law.printed(**c.symbols) for c in chains],
        found=[float(c.boundaries[-1]) for c in chains],
        corrected=[law.corrected(**c.symbols) for c in chains],
    )
    yield compare(
        "eq-a3",
        found=np.concatenate([np.convolve(c.compressions, [1, 1]) for c in chains]),
        x=centres,
        b=before,
        r_0=RADIUS,
        chains=len(chains),
    )


def _deformations(chains: Sequence[TouchingChain]) -> Iterator[Statement]:
    recovered = [forces.compressions(c.centres, 2 * RADIUS) for c in chains]
    yield compare(
        "eq-a4",
        printed=np.concatenate([np.convolve(chain, [1, 1]) for chain in recovered]),
        found=np.concatenate([c.deformations for c in chains]),
    )
    yield compare(
        "eq-a5",
        printed=[float(c[end]) for c in recovered for end in (0, -1)],
        found=[float(c.deformations[end]) for c in chains for end in (0, -1)],
    )
    yield compare(
        "eq-a6",
        printed=[
            SOURCES["eq-a6"].printed(dx=c.deformations[1:], i=np.arange(c.centres.size - 1))
            for c in chains
        ],
        found=[float(c.deformations[0]) for c in chains],
    )


def _lengths() -> Iterator[Statement]:
    """Try what the centres say of the length of a chain: that of odd chains they do not give."""

    def change(particles: int) -> float:
        """Return how b_n - b_0 of one set of centres changes as b_0 moves by 0.01 m."""
        chain = touching_chains(1, (particles,))[0]
        lengths = []
        for first in (float(chain.boundaries[0]), float(chain.boundaries[0]) + 0.01):
            edge = first
            for centre in chain.centres:
                edge = 2 * float(centre) - edge
            lengths.append(edge - first)
        return lengths[1] - lengths[0]

    triple = touching_chains(50, (3,))
    yield compare(
        "eq-chain-length",
        printed=[SOURCES["eq-chain-length"].printed(**c.symbols) for c in triple],
        found=[float(c.boundaries[3] - c.boundaries[0]) for c in triple],
    )
    odd, even = (np.array([change(n) for n in sizes]) for sizes in ((3, 5, 7), (2, 4, 6)))
    yield claim("text-odd-chains", odd=odd)
    yield claim("text-even-chains", odd=odd, even=even)


def _swapped() -> Statement:
    boundaries, swapped = (
        np.cumsum([0.0, *(1.0 - value for value in deformed)])
        for deformed in ((0.15, 0.05), (0.05, 0.15))
    )
    apart = [float(np.diff(0.5 * (b[1:] + b[:-1]))[0]) for b in (boundaries, swapped)]
    return claim("text-swapped", apart=apart, boundaries=boundaries, swapped=swapped)


def _four() -> Iterator[Statement]:
    """Try the example of four particles: its third line, solved for b_0, and its last."""
    chains = touching_chains(50, (4,))
    exact = [float(c.boundaries[0]) for c in chains]
    balance = SOURCES["eq-four-inserted"].printed
    yield compare(
        "eq-four-inserted",
        printed=[
            brentq(lambda b, c=c: balance(**c.symbols | {"b_0": b}), -100.0, 100.0) for c in chains
        ],
        found=exact,
        corrected=[SOURCES["eq-four"].printed(**c.symbols) for c in chains],
    )
    yield compare("eq-four", found=exact, x=np.array([c.centres for c in chains]).T)


def _odd_coefficients() -> Statement:
    """Find the weights of the centres by moving one centre at a time, r_0 by itself."""
    weights = {}
    for n in range(2, 8):
        balance = np.zeros((n + 1, n + 1))  # b_0 to b_n from centres and the alternating sum
        for i in range(n):
            balance[i, i : i + 2] = 1.0
        alternating = (-1.0) ** np.arange(n)
        balance[n, :-1] += alternating  # sum (-1)^i (2r_0 - (b_(i+1) - b_i)) = 0
        balance[n, 1:] -= alternating
        inverse = np.linalg.inv(balance)
        weights[n] = 2 * n * inverse[0, :n], -2 * alternating.sum() * n * inverse[0, n] + 0.0
    odd = all(
        np.allclose(centres, (-1.0) ** np.arange(n) * np.arange(2 * n - 1, 0, -2))
        for n, (centres, _) in weights.items()
    )
    return claim("text-odd-coefficients", odd=odd, weights=weights)


def _bounds(some: Sequence[ParticleRow]) -> Iterator[Statement]:
    pairs = touching_chains(50, (2,))
    yield compare(
        "eq-a8",
        found=[float(p.compressions[0]) for p in pairs],
        r_0=RADIUS,
        dx=np.array([p.deformations[0] for p in pairs]),
        x=np.array([p.centres for p in pairs]).T,
    )
    excess = max(
        float((row.compressions - (1.0 - row.distances))[row.compressions > 0].max())
        for row in some
        if (row.compressions > 0).any()
    )
    yield claim("text-bound", excess=excess, rows=len(some))
    off = off_from_sweeps(some)
    yield claim("text-sweeps", off=off, rows=len(some))


def _many_groupings(some: Sequence[ParticleRow]) -> Statement:
    """Count contact sets in which all closed contacts press and axisymmetry holds."""
    counts = []
    for row in some:
        overlap = 1.0 - row.distances
        n = overlap.size
        law = np.eye(n) + 0.5 * (np.eye(n, k=1) + np.eye(n, k=-1))
        sets = [np.flatnonzero(code >> np.arange(n) & 1) for code in range(2**n)]
        pressing = [np.linalg.solve(law[np.ix_(held, held)], overlap[held]) > 0 for held in sets]
        counts.append(sum(bool(every.all()) for every in pressing))
    median = float(np.median(counts))
    return claim("text-many-groupings", counts=sorted(counts), median=median)


def _proof(pairs: Sequence[OpenPair]) -> Iterator[Statement]:
    """Try the steps of the proof by contradiction on pairs that do not touch."""
    yield claim("eq-a9", gaps=[p.distance - (1.0 - sum(p.deformations) / 2) for p in pairs])
    yield claim(
        "eq-a10",
        smaller=[p.distance > 1.0 - min(p.deformations) for p in pairs],
        larger=[p.distance >= 1.0 - max(p.deformations) - 1e-12 for p in pairs],
    )
    deformed = [p for p in pairs if max(p.deformations) > 0]
    less, more = (
        [p.distance > p.beyond[int(side(p.deformations))] for p in deformed]
        for side in (np.argmin, np.argmax)
    )
    yield claim("eq-a11", less=less, more=more)


_SPAN = 6.0  # [t0] over which returning contacts are looked for
_HEIGHTS = (1, 2, 3, 4, 9, 10, 19)

Intervals = dict[int, list[tuple[float, float]]]


def appendix_window_statements(printed: Printed) -> Iterator[Statement]:
    """Yield the rows of this part."""
    intervals = {n: contact_intervals(run(Tower(height=n), _SPAN)) for n in _HEIGHTS}
    yield from _packets(intervals, printed)
    yield from _windows(printed)
    yield from _largest_compression(intervals, printed)


def _packets(intervals: Intervals, printed: Printed) -> Iterator[Statement]:
    end = printed.first_packet
    late = {
        n: [interval for interval in grain_contacts if interval[0] >= end]
        for n, grain_contacts in intervals.items()
    }
    last = {
        n: max(b for a, b in grain_contacts if a < end) for n, grain_contacts in intervals.items()
    }
    listing = {
        n: [f"{a:.2f} to {b:.2f}" for a, b in grain_contacts]
        for n, grain_contacts in intervals.items()
    }
    numbers: dict[str, Any] = {
        "contacts": intervals, "listing": listing, "late": late, "last": last, "end": end,
        "span": _SPAN,
    }  # fmt: skip
    for name in ("two-particles", "separated", "first-packet", "third-hump", "overlapping"):
        yield claim(f"text-{name}", **numbers)


def _windows(printed: Printed) -> Iterator[Statement]:
    low, high = (particles - 1 for particles in printed.structure_particles)
    heights = {law: heights_with_structure_window(law) for law in LAWS}
    yield claim("text-structure-window", found=heights, low=low, high=high)
    late: dict[tuple[float, float], list[int]] = {}
    for row in impulses():
        t0 = Tower(stiffness=row.stiffness, speed=row.speed).contact_time
        if row.window_s / 2 >= printed.search * (1 - 1e-9) * t0:
            late.setdefault((row.stiffness, row.speed), []).append(row.height)
    yield claim(
        "text-within-bound",
        printed=printed,
        towers=len(impulses()),
        late=late,
        listing="; ".join(
            f"{k:.0e} N/m, {v:g} m/s: n = {min(late[k, v])} and above" for k, v in sorted(late)
        ),
    )
    yield claim("text-three-fails", alpha=ratios()[MEDIAN])


def _largest_compression(intervals: Intervals, printed: Printed) -> Iterator[Statement]:
    runs = {n: run(Tower(height=n)) for n in (1, 2, 3, 19)}
    chain = {
        n: turnaround(tower_run) / tower_run.tower.contact_time for n, tower_run in runs.items()
    }
    leaves = {n: max(end for begin, end in intervals[n] if begin < 2 * chain[n]) for n in runs}
    listing = [f"n = {n}: {2 * chain[n]:.2f} and {leaves[n]:.2f} t0" for n in runs]
    yield claim("text-half-period", chain=chain, leaves=leaves, listing=listing)
    caption, text = printed.window_figure
    yield compare(
        "text-window-figure",
        printed=float(caption),
        found=float(text),
        times=" and ".join(
            f"{chain[n - 1]:.3f} t0 for {n} particles" for n in dict.fromkeys((caption, text))
        ),
    )
    grain = {
        n: float(runs[n].time_over_t0[int(np.argmax(runs[n].deformations[:, 0]))])
        for n in (1, 2, 3)
    }
    yield claim("text-maximum-of-what", grain=grain, chain=chain)
