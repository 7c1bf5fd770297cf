"""Section Methods: three particles and more, equations (16) and (17)."""

from __future__ import annotations

import numpy as np

from harness.chain import boundaries, sweeps
from harness.reproduction import as_printed
from harness.reproduction.claims import Statement, bounded, claim, compare
from harness.reproduction.ledger.methods_outcome import listed
from harness.reproduction.ledger.runs import free_collision
from harness.reproduction.ledger.samples import RADIUS, Row, rows, touching_chains
from harness.reproduction.source import SOURCES
from harness.theory.free_chain import compliance, final_velocities


def statements() -> list[Statement]:
    """Return the rows of this part."""
    return [
        _not_unique(),
        *_deformations(),
        _partial(),
        *_closest_pair(),
        *_boundary_solution(),
        _recurrence(),
        _unique(),
    ]


def _not_unique() -> Statement:
    finals = [final_velocities(3, deformable=law) for law in (False, True)]
    conserved = [float(abs(v.sum() - 1)) + float(abs(v @ v - 1)) for v in finals]
    apart = float(np.abs(finals[0] - finals[1]).max())
    return claim(
        SOURCES["text-not-unique"],
        holds=apart > 1e-3 and max(conserved) < 1e-9,
        computed=f"three particles end with {listed(finals[0])} (overlap) and {listed(finals[1])} "
        "(deformable law) of the grain's speed, both with its momentum and energy",
    )


def _deformations() -> list[Statement]:
    three = free_collision(3)
    first, second, third = three.deformations.T
    scale = float(first.max())
    both = (three.profiles.forces > 0).all(axis=1) if three.profiles else np.zeros(0, bool)
    start = int(np.argmax(both))
    before = float(np.abs(first - second)[:start].max()) / scale
    more = bool((second[both] > first[both]).all())
    least = float(np.mean(third[both] < first[both]))
    early = bool((third[both] < first[both])[1:20].all())
    return [
        claim(
            SOURCES["text-asymmetric"],
            holds=before < 1e-9 and more,
            computed=f"difference before it joins (at {three.time_over_t0[start]:.3f} t0): "
            f"{bounded(before)} of the peak; second above first while all touch: {more}",
        ),
        claim(
            SOURCES["text-least-deformed"],
            holds=least == 1.0,
            corrected_holds=early,
            computed=f"true of {100 * least:.0f} % of the time in which all three touch: it is "
            "while the third is being caught up with, not once the grain rebounds",
        ),
    ]


def _partial() -> Statement:
    chains = touching_chains(particles=(3,))
    return compare(
        SOURCES["text-partial-equal"],
        printed=[chain.deformations[2] for chain in chains],
        found=[sweeps.compressions(chain.centres, 2 * RADIUS)[1] for chain in chains],
        computed=f"partial compressions of {len(chains)} random chains recovered from the centres",
    )


def _closest_pair() -> list[Statement]:
    """Return both rows of the claim that the closest two particles touch, anywhere in a row."""
    near, far = rows(closest=(0.9, 1.1)), rows(closest=(1.0001, 1.2))
    found = [
        [bool(row.compressions[np.argmin(row.distances)] > 0) for row in some]
        for some in (near, far)
    ]
    within = [
        touches for row, touches in zip(near, found[0], strict=True) if row.distances.min() < 1.0
    ]
    return [
        claim(
            SOURCES[key],
            holds=all(found[0]) and all(found[1]),
            corrected_holds=all(within) and bool(within),
            computed=f"of {len(within)} random rows whose closest pair is closer than d, "
            f"{sum(within)} have it in contact; of {len(far)} rows without such a pair, "
            f"{sum(found[1])}",
        )
        for key in ("text-closest-pair", "text-closest-proof")
    ]


def _boundary_solution() -> list[Statement]:
    """Return both rows of the formula for the first boundary of a chain."""
    chains = touching_chains()
    return [
        compare(
            SOURCES[key],
            printed=[as_printed.first_boundary(c.centres, RADIUS) for c in chains],
            found=[float(c.boundaries[0]) for c in chains],
            computed=f"{len(chains)} chains of 2 to 9 particles laid side by side from b_0; the "
            "formula is right for odd n and r_0/n too far right for even n",
            corrected=[boundaries.first_boundary(c.centres, RADIUS) for c in chains],
        )
        for key in ("eq-16", "eq-a7")
    ]


def _recurrence() -> Statement:
    chains = touching_chains()
    return compare(
        SOURCES["eq-17"],
        printed=[as_printed.next_boundary(c.centres[-1], c.boundaries[-2]) for c in chains],
        found=[float(c.boundaries[-1]) for c in chains],
        computed=f"last boundary of {len(chains)} random chains",
    )


def _unique() -> Statement:
    lowest = [float(np.linalg.eigvalsh(compliance(n, True))[0]) for n in range(1, 20)]
    some = rows()
    off = max(
        float(np.abs(sweeps.compressions(row.centres, 1.0) - row.compressions).max())
        for row in some
    )
    return claim(
        SOURCES["text-unique"],
        holds=min(lowest) > 0 and off < 1e-12,
        computed="the compressions solve a linear complementarity problem whose matrix "
        f"tridiag(1/2, 1, 1/2) is positive definite (smallest eigenvalue {min(lowest):.4f} at "
        f"19 contacts), hence one solution; sweeps and pivoting differ by {bounded(off)} m on "
        f"{len(some)} random rows",
    )
