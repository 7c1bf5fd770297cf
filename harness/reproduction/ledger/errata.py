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
    balance, separation, square = rows["eq-6"], rows["text-separation"], rows["eq-18"]
    yield claim("erratum-1", evidence=balance.evidence, row=balance, line=_line)
    yield claim(
        "erratum-7",
        evidence=separation.evidence,
        row=rows["text-t-c"],
        formula=rows["eq-11"].found,
        ratio=rows["eq-11"].found / printed.contact_time,
        separation=separation,
        line=_line,
    )
    stiffness, first, n = 100.0, 0.2, 10
    yield claim(
        "erratum-12",
        evidence=square.evidence,
        rows=(square, rows["eq-u-2"]),
        with_square=n * 0.5 * stiffness * (n * first) ** 2,
        right=n * 0.5 * stiffness * first**2,
        springs=n,
        line=_line,
    )
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
