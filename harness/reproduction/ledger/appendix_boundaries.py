"""Appendix A, boundaries of one chain: equations (A1) to (A7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq

from harness.chain import sweeps
from harness.reproduction import as_printed
from harness.reproduction.claims import Statement, bounded, claim, compare
from harness.reproduction.ledger.samples import RADIUS, Floats, TouchingChain, touching_chains
from harness.reproduction.source import SOURCES


def statements() -> list[Statement]:
    """Return the rows of this part."""
    chains = touching_chains()
    return [
        _recurrence(chains),
        _general_sum(chains),
        *lengths(),
        swapped(),
        _deformation(chains),
        _partial(chains),
        _ends(chains),
        compare(
            SOURCES["eq-a6"],
            printed=[as_printed.first_deformation(c.deformations[1:]) for c in chains],
            found=[float(c.deformations[0]) for c in chains],
            computed="widths of the chains as built, 2 to 9 particles",
        ),
        *four(),
        odd_coefficients(),
    ]


def _recurrence(chains: Sequence[TouchingChain]) -> Statement:
    printed, found = [], []
    for chain in chains:
        edges = chain.boundaries
        printed += [
            as_printed.next_boundary(x, b) for x, b in zip(chain.centres, edges[:-1], strict=True)
        ]
        found += list(edges[1:])
    return compare(
        SOURCES["eq-a1"],
        printed=printed,
        found=found,
        computed=f"every boundary of {len(chains)} random chains of 2 to 9 particles",
    )


def _general_sum(chains: Sequence[TouchingChain]) -> Statement:
    firsts = [float(c.boundaries[0]) for c in chains]
    repaired = []
    for chain, first in zip(chains, firsts, strict=True):
        n = chain.centres.size
        signs = (-1.0) ** (n - np.arange(1, n + 1))
        repaired.append(float(2 * signs @ chain.centres + (-1) ** n * first))
    return compare(
        SOURCES["eq-a2"],
        printed=[
            as_printed.last_boundary(c.centres, b) for c, b in zip(chains, firsts, strict=True)
        ],
        found=[float(c.boundaries[-1]) for c in chains],
        computed=f"last boundary of {len(chains)} random chains; the lines for b_1 to b_3 hold, "
        "the sum gives all centres one sign and counts b_0 n times",
        corrected=repaired,
    )


def _deformation(chains: Sequence[TouchingChain]) -> Statement:
    printed, found = [], []
    for chain in chains:
        printed += [
            as_printed.deformation(x, b, RADIUS)
            for x, b in zip(chain.centres, chain.boundaries[:-1], strict=True)
        ]
        found += list(np.convolve(chain.compressions, [1, 1]))
    return compare(
        SOURCES["eq-a3"],
        printed=printed,
        found=found,
        computed=f"the compressions that {len(chains)} chains were built from",
    )


def _partial(chains: Sequence[TouchingChain]) -> Statement:
    printed, found = [], []
    for chain in chains:
        pressed = sweeps.compressions(chain.centres, 2 * RADIUS)
        printed += list(np.pad(pressed, (1, 0)) + np.pad(pressed, (0, 1)))
        found += list(chain.deformations)
    return compare(
        SOURCES["eq-a4"],
        printed=printed,
        found=found,
        computed="compressions recovered from the centres against the widths built in",
    )


def _ends(chains: Sequence[TouchingChain]) -> Statement:
    recovered = [sweeps.compressions(c.centres, 2 * RADIUS) for c in chains]
    return compare(
        SOURCES["eq-a5"],
        printed=[float(c[end]) for c in recovered for end in (0, -1)],
        found=[float(c.deformations[end]) for c in chains for end in (0, -1)],
        computed="first and last particle of every chain",
    )


def from_first(centres: Floats, first: float) -> Floats:
    """Return the boundaries (n+1,) [m] that mirror ``first`` at one centre after the other."""
    found = [first]
    for centre in centres:
        found.append(2 * float(centre) - found[-1])
    return np.array(found)


def lengths() -> list[Statement]:
    """Return the rows on the length of a chain, which its centres do not give."""

    def both_lengths(particles: int) -> tuple[float, float]:
        """Return b_n - b_0 of one set of centres for two choices of b_0, 0.01 m apart."""
        chain = touching_chains(1, (particles,))[0]
        first = float(chain.boundaries[0])
        both = [from_first(chain.centres, first + shift) for shift in (0.0, 0.01)]
        return float(both[0][-1] - both[0][0]), float(both[1][-1] - both[1][0])

    change = {n: both_lengths(n)[1] - both_lengths(n)[0] for n in range(2, 8)}
    odd = [change[n] for n in change if n % 2]
    even = [change[n] for n in change if n % 2 == 0]
    triple = touching_chains(50, (3,))
    return [
        compare(
            SOURCES["eq-chain-length"],
            printed=[
                2 * c.centres[2] - 2 * c.centres[1] + 2 * c.centres[0] - 2 * c.boundaries[0]
                for c in triple
            ],
            found=[float(c.boundaries[3] - c.boundaries[0]) for c in triple],
            computed=f"{len(triple)} random chains of three",
        ),
        claim(
            SOURCES["text-odd-chains"],
            holds=max(abs(value) for value in odd) < 1e-12,
            computed="centres held and b_0 moved by 0.01 m, the lengths of chains of 3, 5 and 7 "
            "change by " + ", ".join(f"{value:.2f}" for value in odd) + " m: the centres do not "
            "give the length, which takes the deformations of the two ends",
        ),
        claim(
            SOURCES["text-even-chains"],
            holds=max(abs(value) for value in even) < 1e-12 and min(map(abs, odd)) > 1e-3,
            computed="the same in chains of 2, 4 and 6: the length changes by "
            f"{bounded(max(map(abs, even)))} m, b_0 cancels",
        ),
    ]


def swapped() -> Statement:
    """Return the row of two particles that swap their deformations."""

    def laid(deformed: tuple[float, float]) -> Floats:
        widths = [1.0 - value for value in deformed]
        return np.array([0.0, widths[0], sum(widths)])

    one, other = laid((0.15, 0.05)), laid((0.05, 0.15))
    centres = [0.5 * (b[1:] + b[:-1]) for b in (one, other)]
    apart = [float(np.diff(x)[0]) for x in centres]
    return claim(
        SOURCES["text-swapped"],
        holds=abs(apart[0] - apart[1]) < 1e-12
        and abs(one[-1] - other[-1]) < 1e-12
        and abs(one[1] - other[1]) > 0.01,
        computed=f"deformations 0.15 and 0.05 m in either order: centres {apart[0]:.3f} and "
        f"{apart[1]:.3f} m apart, lengths {one[-1]:.3f} and {other[-1]:.3f} m, boundary between "
        f"them at {one[1]:.3f} and {other[1]:.3f} m",
    )


def four() -> list[Statement]:
    """Return the rows of the example of four particles."""
    chains = touching_chains(50, (4,))
    exact = [float(c.boundaries[0]) for c in chains]

    def solved(centres: Floats) -> float:
        return float(
            brentq(lambda b: as_printed.imbalance_of_four(centres, b, RADIUS), -100.0, 100.0)
        )

    return [
        compare(
            SOURCES["eq-four-inserted"],
            printed=[solved(c.centres) for c in chains],
            found=exact,
            computed="the line solved for b_0 by root finding: b_1 = 2x_1 - b_0 brings one b_0, "
            "the line has two",
            corrected=[as_printed.boundary_of_four(c.centres) for c in chains],
        ),
        compare(
            SOURCES["eq-four"],
            printed=[as_printed.boundary_of_four(c.centres) for c in chains],
            found=exact,
            computed=f"{len(chains)} random chains of four; no r_0 in it, as eq. (A7) has",
        ),
    ]


def odd_coefficients() -> Statement:
    """Find the weights of the centres by moving one centre at a time, r_0 by itself."""
    weights: dict[int, list[float]] = {}
    for n in range(2, 8):
        balance = np.zeros((n + 1, n + 1))  # b_0 to b_n from centres and the alternating sum
        for i in range(n):
            balance[i, i : i + 2] = 1.0
        alternating = (-1.0) ** np.arange(n)
        balance[n, :-1] += alternating  # sum (-1)^i (2r_0 - (b_(i+1) - b_i)) = 0
        balance[n, 1:] -= alternating
        inverse = np.linalg.inv(balance)
        weights[n] = [*(2 * n * inverse[0, :n]), -2 * alternating.sum() * n * inverse[0, n]]
    odd = all(
        np.allclose(w[:-1], [(-1.0) ** i * (2 * (n - i) - 1) for i in range(n)])
        for n, w in weights.items()
    )
    return claim(
        SOURCES["text-odd-coefficients"],
        holds=odd and all(abs(w[-1]) < 1e-9 for w in weights.values()),
        corrected_holds=odd
        and all(abs(w[-1] - ((-1) ** n - 1) / 2) < 1e-9 for n, w in weights.items()),
        computed="the equations of 2 to 7 particles inverted: n b_0 has the weights "
        + "; ".join(
            f"{', '.join(f'{v:.0f}' for v in w[:-1])} and {w[-1] + 0.0:.0f} r_0"
            for n, w in weights.items()
            if n in (3, 4)
        )
        + " for 3 and 4",
    )
