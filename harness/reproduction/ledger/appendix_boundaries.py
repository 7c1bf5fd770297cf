"""Appendix A, boundaries of one chain: equations (A1) to (A7)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from harness.chain import sweeps
from harness.reproduction import as_printed
from harness.reproduction.claims import Source, Statement, compare_everywhere
from harness.reproduction.ledger.appendix_examples import (
    four,
    lengths,
    odd_coefficients,
    swapped,
)
from harness.reproduction.ledger.methods_chain import boundary_solution
from harness.reproduction.ledger.samples import (
    RADIUS,
    TouchingChain,
    touching_chains,
)
from harness.reproduction.ledger.widths import round_off

_LAW = ("tests/chain/test_contact_solvers.py",)
_PLACE = "Appendix A, boundaries within a chain"


def statements() -> list[Statement]:
    """Return the rows in the order of the text."""
    chains = touching_chains()
    return [
        _recurrence(chains),
        _general_sum(chains),
        *lengths(),
        swapped(),
        _deformation(chains),
        _partial(chains),
        _ends(chains),
        _alternating(chains),
        *four(),
        boundary_solution("eq-a7", "Appendix A, eq. (A7)"),
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
    return compare_everywhere(
        Source("eq-a1", "Appendix A, eq. (A1)", "b_i = x_i + (x_i - b_(i-1)), i = 1 to n"),
        printed=printed,
        found=found,
        width=round_off("m"),
        computed=f"every boundary of {len(chains)} random chains of 2 to 9 particles",
        evidence=_LAW,
    )


def _general_sum(chains: Sequence[TouchingChain]) -> Statement:
    firsts = [float(c.boundaries[0]) for c in chains]
    repaired = []
    for chain, first in zip(chains, firsts, strict=True):
        n = chain.centres.size
        signs = (-1.0) ** (n - np.arange(1, n + 1))
        repaired.append(float(2 * signs @ chain.centres + (-1) ** n * first))
    return compare_everywhere(
        Source("eq-a2", "Appendix A, eq. (A2)", "b_n = sum (2 x_i (-1)^(n+1) + b_0 (-1)^n)"),
        printed=[
            as_printed.last_boundary(c.centres, b) for c, b in zip(chains, firsts, strict=True)
        ],
        found=[float(c.boundaries[-1]) for c in chains],
        width=round_off("m", 1e-11),
        computed=f"last boundary of {len(chains)} random chains; the lines for b_1 to b_3 hold, "
        "the sum gives all centres one sign and counts b_0 n times",
        corrected=repaired,
        correction="b_n = sum 2 (-1)^(n-i) x_i + (-1)^n b_0",
        evidence=_LAW,
    )


def _deformation(chains: Sequence[TouchingChain]) -> Statement:
    printed, found = [], []
    for chain in chains:
        printed += [
            as_printed.deformation(x, b, RADIUS)
            for x, b in zip(chain.centres, chain.boundaries[:-1], strict=True)
        ]
        found += list(np.convolve(chain.compressions, [1, 1]))
    return compare_everywhere(
        Source("eq-a3", "Appendix A, eq. (A3)", "dx_i = 2 (r_0 - (x_i - b_(i-1)))"),
        printed=printed,
        found=found,
        width=round_off("m"),
        computed=f"the compressions that {len(chains)} chains were built from",
        evidence=_LAW,
    )


def _partial(chains: Sequence[TouchingChain]) -> Statement:
    printed, found = [], []
    for chain in chains:
        pressed = sweeps.compressions(chain.centres, 2 * RADIUS)
        printed += list(np.pad(pressed, (1, 0)) + np.pad(pressed, (0, 1)))
        found += list(chain.deformations)
    return compare_everywhere(
        Source("eq-a4", "Appendix A, eq. (A4)", "dx_i = c_(i-1,i) + c_(i,i+1)"),
        printed=printed,
        found=found,
        width=round_off("m"),
        computed="compressions recovered from the centres against the widths built in",
        evidence=_LAW,
    )


def _ends(chains: Sequence[TouchingChain]) -> Statement:
    recovered = [sweeps.compressions(c.centres, 2 * RADIUS) for c in chains]
    return compare_everywhere(
        Source("eq-a5", "Appendix A, eq. (A5)", "dx_1 = c_(1,2), dx_n = c_(n-1,n)"),
        printed=[float(c[end]) for c in recovered for end in (0, -1)],
        found=[float(c.deformations[end]) for c in chains for end in (0, -1)],
        width=round_off("m"),
        computed="first and last particle of every chain",
        evidence=_LAW,
    )


def _alternating(chains: Sequence[TouchingChain]) -> Statement:
    return compare_everywhere(
        Source(
            "eq-a6", "Appendix A, eq. (A6)", "dx_1 = dx_2 - (dx_3 - (dx_4 - ... (dx_(n-1) - dx_n)))"
        ),
        printed=[as_printed.first_deformation(c.deformations[1:]) for c in chains],
        found=[float(c.deformations[0]) for c in chains],
        width=round_off("m"),
        computed="widths of the chains as built, 2 to 9 particles",
        evidence=_LAW,
    )
