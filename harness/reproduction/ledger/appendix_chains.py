"""Appendix A, which particles form chains: equations (A8) to (A11)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from harness.chain import sweeps
from harness.reproduction import as_printed
from harness.reproduction.claims import Source, Statement, claim, compare_everywhere
from harness.reproduction.ledger.methods_chain import closest_pair
from harness.reproduction.ledger.samples import RADIUS, Row, rows, touching_chains
from harness.reproduction.ledger.widths import round_off

_LAW = ("tests/chain/test_contact_solvers.py",)
_PLACE = "Appendix A, identifying chains"


def statements() -> list[Statement]:
    """Return the rows in the order of the text."""
    near = rows()
    return [
        _many_groupings(near),
        _bound(),
        _bound_everywhere(near),
        _sweeps(near),
        _not_in_contact(near),
        _smaller_deformation(near),
        _contradiction(near),
        closest_pair("text-closest-proof", "Appendix A, proof by contradiction"),
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
        Source(
            "text-many-groupings",
            _PLACE,
            "particles can be grouped in many ways that satisfy axisymmetry and the third law",
        ),
        holds=float(np.median(counts)) > 1,
        computed=f"contact sets in which every closed contact presses, {len(counts)} random rows: "
        f"{min(counts)} to {max(counts)}, median {np.median(counts):g}; that open contacts must "
        "not overlap leaves one",
        evidence=_LAW,
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
    return compare_everywhere(
        Source(
            "eq-a8",
            "Appendix A, eq. (A8)",
            "c_(i,j) <= 2r_0 - dx_i, reached when i has no neighbour to its left",
        ),
        printed=[as_printed.largest_compression(RADIUS, float(p.deformations[0])) for p in pairs],
        found=[float(p.compressions[0]) for p in pairs],
        width=round_off("m"),
        computed="two particles alone, where the bound is reached: as printed it is the length of "
        "the deformed particle, which no compression comes near",
        corrected=[2 * RADIUS - float(p.centres[1] - p.centres[0]) for p in pairs],
        correction="c_(i,j) <= 2r_0 - (x_j - x_i), as the proof uses it",
        evidence=_LAW,
    )


def _bound_everywhere(some: Sequence[Row]) -> Statement:
    excess = max(float((row.compressions - (1.0 - row.distances))[row.compressions > 0].max())
                 for row in some if (row.compressions > 0).any())  # fmt: skip
    return claim(
        Source(
            "text-bound",
            "Appendix A, after eq. (A8)",
            "the bound (corrected) follows from Newton's third law, for any neighbours",
        ),
        holds=excess < 1e-12,
        computed=f"c minus the bound is at most {excess:.0e} m in {len(some)} random rows",
        evidence=_LAW,
    )


def _sweeps(some: Sequence[Row]) -> Statement:
    off = max(
        float(np.abs(sweeps.compressions(row.centres, 2 * RADIUS) - row.compressions).max())
        for row in some
    )
    return claim(
        Source(
            "text-sweeps",
            _PLACE,
            "sweeps that add contacts as they become certain, closest pair first, find all chains",
        ),
        holds=off < 1e-12,
        computed=f"sweeps and complementarity agree to {off:.0e} m on {len(some)} random rows, "
        "each contact kept between what its neighbours can press at most and at least; joining "
        "chains because their boundaries overlap at the moment would not do (beyond-2)",
        evidence=_LAW,
        why="two methods that share no code, to 1e-12 m",
    )


def _not_in_contact(some: Sequence[Row]) -> Statement:
    open_pairs = openings(some)
    gaps = [p.distance - (1.0 - sum(p.deformations) / 2) for p in open_pairs]
    return claim(
        Source(
            "eq-a9",
            "Appendix A, eq. (A9)",
            "not in contact: x_j - x_i > (2r_0 - dx_i)/2 + (2r_0 - dx_j)/2",
        ),
        holds=min(gaps) > -1e-12,
        computed=f"smallest gap of {len(open_pairs)} pairs that do not touch: {min(gaps):.1e} m",
        evidence=_LAW,
    )


def _smaller_deformation(some: Sequence[Row]) -> Statement:
    open_pairs = openings(some)
    smaller = sum(p.distance > 1.0 - min(p.deformations) for p in open_pairs)
    larger = sum(p.distance >= 1.0 - max(p.deformations) - 1e-12 for p in open_pairs)
    return claim(
        Source(
            "eq-a10",
            "Appendix A, eq. (A10)",
            "with dx_i the smaller of the two, x_j - x_i > 2r_0 - dx_i",
        ),
        holds=smaller == len(open_pairs),
        corrected_holds=larger == len(open_pairs),
        computed=f"of {len(open_pairs)} pairs that do not touch {smaller} obey it with the smaller "
        f"deformation, {larger} with the larger: the smaller one makes the right side larger, "
        "which does not keep the inequality",
        correction="dx_i is the larger of the two",
        evidence=("tests/verbs/reproduction/ledger/test_appendix.py",),
    )


def _contradiction(some: Sequence[Row]) -> Statement:
    pressed = [p for p in openings(some) if max(p.deformations) > 0]

    def follows(pair: Opening, larger: bool) -> bool:
        side = int(np.argmax(pair.deformations) if larger else np.argmin(pair.deformations))
        return bool(pair.distance > pair.beyond[side])

    as_it_stands = sum(follows(p, larger=False) for p in pressed)
    repaired = sum(follows(p, larger=True) for p in pressed)
    return claim(
        Source(
            "eq-a11",
            "Appendix A, last display",
            "x_j - x_i > 2r_0 - (2r_0 - (x_i - x_h)) = x_i - x_h: the pair is not the closest",
        ),
        holds=as_it_stands == len(pressed),
        corrected_holds=repaired == len(pressed),
        computed=f"of {len(pressed)} pairs that do not touch, one of them pressed from its other "
        f"side, {as_it_stands} lie further apart than the less deformed one from its other "
        f"neighbour, {repaired} than the more deformed one",
        correction="for the more deformed one, and only if it is pressed at all: particles none of "
        "which touch are no contradiction",
        evidence=("tests/verbs/reproduction/ledger/test_appendix.py",),
    )
