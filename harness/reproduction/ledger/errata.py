"""The errata of our restatement of the source, one row each, judged by the rows of this run.

Where a row is about the restatement, its ``where`` says so: the status is that of
the erratum, not of the source.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from harness.reproduction.as_printed import Printed
from harness.reproduction.claims import ClaimStatus, Ledger, Statement, claim, compare
from harness.reproduction.ledger.discussion import row_energy
from harness.reproduction.source import SOURCES, Source
from harness.theory.tower import series_stiffness


def statements(printed: Printed, rows: Ledger) -> Iterator[Statement]:
    """Yield the errata; ``rows`` are those of the source."""
    yield from (judged(source, rows) for source in SOURCES.values() if source.wrong)
    balance = rows["eq-6"]
    yield claim(
        "erratum-1",
        holds=abs(balance.printed - 13.87) < 0.005
        and abs(balance.corrected - 10.21) < 0.005
        and balance.status is ClaimStatus.CORRECTED,
        evidence=balance.evidence,
        row=_line(balance),
    )
    yield _crest_time(printed, rows)
    yield _energies(rows)
    contacts = 10
    yield compare(
        "erratum-13",
        printed=series_stiffness(contacts, 1.0, deformable=True),
        found=1 / (2 * row_energy(contacts, 1.0, 1.0)),
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
    """Return key, status and the numbers of a row, in words if it has none."""
    key, unit = row.source.key, row.source.unit
    if np.isnan(row.printed):
        return f"{key}, {row.status}: {row.computed}"
    numbers = f"printed {row.printed:.6g}, found {row.found:.6g}"
    if not np.isnan(row.corrected):
        numbers += f", corrected {row.corrected:.6g}"
    return f"{key}, {row.status}: {numbers}{'' if unit == '1' else f' {unit}'}"


def _crest_time(printed: Printed, rows: Ledger) -> Statement:
    formula, separation = rows["eq-11"].found, rows["text-separation"]
    ratio = formula / printed.contact_time
    told = abs(formula - 0.029) < 0.0005 and round(ratio) == 4
    return claim(
        "erratum-7",
        holds=told and separation.status is not ClaimStatus.REPRODUCED,
        corrected_holds=told,
        evidence=separation.evidence,
        row=_line(rows["text-t-c"]),
        ratio=ratio,
        separation=separation.computed,
    )


def _energies(rows: Ledger) -> Statement:
    square, two = rows["eq-18"], rows["eq-u-2"]
    wrong = all(row.status is ClaimStatus.CORRECTED for row in (square, two))
    stiffness, first, n = 100.0, 0.2, 10
    with_square, right = (n * 0.5 * stiffness * c**2 for c in (n * first, first))
    return claim(
        "erratum-12",
        holds=wrong and abs(with_square - right) < 1e-9,
        corrected_holds=wrong,
        evidence=square.evidence,
        rows=f"{_line(square)}; {_line(two)}",
        with_square=with_square,
        right=right,
        springs=n,
    )
