"""Appendix A, boundaries of one chain: equations (A1) to (A7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from harness.chain import sweeps
from harness.reproduction import as_printed
from harness.reproduction.claims import Statement, compare
from harness.reproduction.ledger.appendix_examples import four, lengths, odd_coefficients, swapped
from harness.reproduction.ledger.samples import RADIUS, TouchingChain, touching_chains
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
