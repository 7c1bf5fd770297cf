"""The appendices, boundaries of a chain (A1) to (A11) and the window of the impulse; corrections.

Where a row is about our own restatement of the source, its ``where`` says so.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.optimize import brentq

from harness.cases.tower.run import covering, tower
from harness.comparison.convergence import slope_order
from harness.observables.tower import impulse, turnaround
from harness.parameters.tower import LAWS, Law, Tower
from harness.reproduction.claims import (
    SOURCES,
    Printed,
    Statement,
    claim,
    compare,
)
from harness.reproduction.ledger.results import row_energy
from harness.reproduction.ledger.samples import (
    MEDIAN,
    RADIUS,
    OpenPair,
    ParticleRow,
    Ratios,
    TouchingChain,
    contact_intervals,
    heights_with_structure_window,
    impulses,
    integrate,
    off_from_sweeps,
    openings,
    ratios,
    rows,
    run,
    touching_chains,
)
from harness.solvers.chain import forces
from harness.theory.chain import compliance, series_stiffness, static_forces
from harness.theory.contact import damping_ratio, restitution_clipped


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


_FLOOR = 0.1367  # the restatement's, of the clipped restitution


def beyond_statements(_: Printed) -> Iterator[Statement]:
    """Yield the corrections, those of our own restatement of the source among them."""
    contacts = 10
    yield compare(
        "erratum-13",
        printed=series_stiffness(contacts, 1.0, deformable=True),
        found=1 / (2 * row_energy(contacts)),
        contacts=contacts,
        springs=1 / contacts,
    )
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
