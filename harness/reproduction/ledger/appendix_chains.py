"""Appendix A, which particles form chains: equations (A8) to (A11)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from harness.chain import sweeps
from harness.reproduction import as_printed
from harness.reproduction.claims import Statement, bounded, claim, compare
from harness.reproduction.ledger.samples import RADIUS, Row, rows, touching_chains
from harness.reproduction.source import SOURCES


def statements() -> list[Statement]:
    """Return the rows of this part."""
    near = rows()
    return [
        _many_groupings(near),
        _bound(),
        _bound_everywhere(near),
        _sweeps(near),
        _not_in_contact(near),
        _smaller_deformation(near),
        _contradiction(near),
    ]


@dataclass(frozen=True)
class Opening:
    """Two neighbours that do not touch: their distance, and each with what presses it [m]."""

    distance: float
    deformations: tuple[float, float]
    beyond: tuple[float, float]  # distance of each to its other neighbour, infinite at an end


def openings(some: Sequence[Row]) -> list[Opening]:
    """Return every pair of neighbours of ``some`` rows that are not in contact."""
    found = []
    for row in some:
        apart = np.concatenate(([np.inf], row.distances, [np.inf]))
        for i in np.flatnonzero(row.compressions == 0):
            found.append(
                Opening(
                    float(row.distances[i]),
                    (float(row.deformations[i]), float(row.deformations[i + 1])),
                    (float(apart[i]), float(apart[i + 2])),
                )
            )
    return found


def _many_groupings(some: Sequence[Row]) -> Statement:
    """Count contact sets in which all closed contacts press and axisymmetry holds."""
    counts = []
    for row in some[:50]:
        overlap = 1.0 - row.distances
        consistent = 0
        for code in range(2**overlap.size):
            closed = np.array([code >> j & 1 for j in range(overlap.size)], dtype=bool)
            consistent += _presses(closed, overlap)
        counts.append(consistent)
    return claim(
        SOURCES["text-many-groupings"],
        holds=float(np.median(counts)) > 1,
        computed=f"contact sets in which every closed contact presses, {len(counts)} random rows: "
        f"{min(counts)} to {max(counts)}, median {np.median(counts):g}; that open contacts must "
        "not overlap leaves one",
    )


def _presses(closed: np.ndarray, overlap: np.ndarray) -> bool:
    """Return whether all contacts of ``closed`` carry a positive compression."""
    if not closed.any():
        return True
    n = closed.size
    law = np.eye(n) + 0.5 * (np.eye(n, k=1) + np.eye(n, k=-1))
    held = np.flatnonzero(closed)
    return bool((np.linalg.solve(law[np.ix_(held, held)], overlap[held]) > 0).all())


def _bound() -> Statement:
    pairs = touching_chains(50, (2,))
    return compare(
        SOURCES["eq-a8"],
        printed=[as_printed.largest_compression(RADIUS, float(p.deformations[0])) for p in pairs],
        found=[float(p.compressions[0]) for p in pairs],
        computed="two particles alone, where the bound is reached: as printed it is the length of "
        "the deformed particle, which no compression comes near",
        corrected=[2 * RADIUS - float(p.centres[1] - p.centres[0]) for p in pairs],
    )


def _bound_everywhere(some: Sequence[Row]) -> Statement:
    excess = max(
        float((row.compressions - (1.0 - row.distances))[row.compressions > 0].max())
        for row in some
        if (row.compressions > 0).any()
    )
    return claim(
        SOURCES["text-bound"],
        holds=excess < 1e-12,
        computed=f"c minus the bound is {bounded(excess)} m in {len(some)} random rows",
    )


def _sweeps(some: Sequence[Row]) -> Statement:
    off = max(
        float(np.abs(sweeps.compressions(row.centres, 2 * RADIUS) - row.compressions).max())
        for row in some
    )
    return claim(
        SOURCES["text-sweeps"],
        holds=off < 1e-12,
        computed=f"sweeps and complementarity differ by {bounded(off)} m on {len(some)} random "
        "rows, each contact kept between what its neighbours can press at most and at least; "
        "joining chains because their boundaries overlap at the moment would not do (beyond-2)",
    )


def _not_in_contact(some: Sequence[Row]) -> Statement:
    open_pairs = openings(some)
    gaps = [p.distance - (1.0 - sum(p.deformations) / 2) for p in open_pairs]
    return claim(
        SOURCES["eq-a9"],
        holds=min(gaps) > -1e-12,
        computed=f"smallest gap of {len(open_pairs)} pairs that do not touch: {min(gaps):.1e} m",
    )


def _smaller_deformation(some: Sequence[Row]) -> Statement:
    open_pairs = openings(some)
    smaller = sum(p.distance > 1.0 - min(p.deformations) for p in open_pairs)
    larger = sum(p.distance >= 1.0 - max(p.deformations) - 1e-12 for p in open_pairs)
    return claim(
        SOURCES["eq-a10"],
        holds=smaller == len(open_pairs),
        corrected_holds=larger == len(open_pairs),
        computed=f"of {len(open_pairs)} pairs that do not touch {smaller} obey it with the smaller "
        f"deformation, {larger} with the larger: the smaller one makes the right side larger, "
        "which does not keep the inequality",
    )


def _contradiction(some: Sequence[Row]) -> Statement:
    pressed = [p for p in openings(some) if max(p.deformations) > 0]

    def follows(pair: Opening, larger: bool) -> bool:
        side = int(np.argmax(pair.deformations) if larger else np.argmin(pair.deformations))
        return bool(pair.distance > pair.beyond[side])

    as_it_stands = sum(follows(p, larger=False) for p in pressed)
    repaired = sum(follows(p, larger=True) for p in pressed)
    return claim(
        SOURCES["eq-a11"],
        holds=as_it_stands == len(pressed),
        corrected_holds=repaired == len(pressed),
        computed=f"of {len(pressed)} pairs that do not touch, one of them pressed from its other "
        f"side, {as_it_stands} lie further apart than the less deformed one from its other "
        f"neighbour, {repaired} than the more deformed one",
    )
