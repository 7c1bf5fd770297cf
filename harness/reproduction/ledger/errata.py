"""The errata of our restatement of the source, one row each, judged by the rows of this run.

Where a row is about the restatement, its ``where`` says so: the status is that of
the erratum, not of the source.
"""

from __future__ import annotations

import numpy as np

from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import ClaimStatus, Ledger, Statement, claim, compare
from harness.reproduction.ledger.discussion import row_energy
from harness.reproduction.source import SOURCES, Source
from harness.theory.tower import series_stiffness


def statements(printed: Printed, rows: Ledger) -> list[Statement]:
    """Return the errata; ``rows`` are those of the source."""
    named = [source for source in SOURCES.values() if source.wrong]
    return [
        *(judged(source, rows) for source in named),
        _steady_state(rows),
        _crest_time(printed, rows),
        _energies(rows),
        _series(),
    ]


def judged(erratum: Source, rows: Ledger) -> Statement:
    """Return the row of an erratum from the rows that it calls wrong, and those that are right."""
    wrong = [rows[key] for key in erratum.wrong]
    right = [rows[key] for key in erratum.right]
    return claim(
        erratum,
        holds=all(row.status is not ClaimStatus.REPRODUCED for row in wrong)
        and all(row.status is ClaimStatus.REPRODUCED for row in right),
        computed="; ".join(_line(row) for row in (*wrong, *right)),
        evidence=tuple(dict.fromkeys(link for row in wrong for link in row.evidence)),
    )


def _line(row: Statement) -> str:
    """Return key, status and the numbers of a row, in words if it has none."""
    key, unit = row.source.key, row.source.unit
    if np.isnan(row.printed):
        return f"{key}, {row.status}: {row.computed}"
    numbers = f"printed {row.printed:.6g}, found {row.found:.6g}"
    if not np.isnan(row.corrected):
        numbers += f", corrected {row.corrected:.6g}"
    return f"{key}, {row.status}: {numbers}{'' if unit == '1' else f' {unit}'}"


def _steady_state(rows: Ledger) -> Statement:
    row = rows["eq-6"]
    return claim(
        SOURCES["erratum-1"],
        holds=abs(row.printed - 13.87) < 0.005
        and abs(row.corrected - 10.21) < 0.005
        and row.status is ClaimStatus.CORRECTED,
        computed=_line(row),
        evidence=row.evidence,
    )


def _crest_time(printed: Printed, rows: Ledger) -> Statement:
    formula = rows["eq-11"].found
    ratio = formula / printed.contact_time
    separated = rows["text-separation"].status is ClaimStatus.REPRODUCED
    told = abs(formula - 0.029) < 0.0005 and round(ratio) == 4
    return claim(
        SOURCES["erratum-7"],
        holds=told and not separated,
        corrected_holds=told,
        computed=f"{_line(rows['text-t-c'])}; over t_n {ratio:.2f}; "
        + rows["text-separation"].computed,
        evidence=rows["text-separation"].evidence,
    )


def _energies(rows: Ledger) -> Statement:
    square, two = rows["eq-18"], rows["eq-u-2"]
    wrong = all(row.status is ClaimStatus.CORRECTED for row in (square, two))
    stiffness, first, n = 100.0, 0.2, 10
    with_square = n * 0.5 * stiffness * (n * first) ** 2
    right = n * 0.5 * stiffness * first**2
    return claim(
        SOURCES["erratum-12"],
        holds=wrong and abs(with_square - right) < 1e-9,
        corrected_holds=wrong,
        computed=f"{_line(square)}; {_line(two)}; n (1/2 k c_n^2) would be {with_square:g} J where "
        f"the springs store {right:g} J (n = {n})",
        evidence=square.evidence,
    )


def _series() -> Statement:
    n = 10
    found = 1 / (2 * row_energy(n, 1.0, 1.0))
    return compare(
        SOURCES["erratum-13"],
        printed=series_stiffness(n, 1.0, deformable=True),
        found=found,
        computed=f"force over approach of the outer centres of {n} contacts under the deformable "
        f"law: {found:.6f} k; k/n would be {1 / n:g} k",
    )
