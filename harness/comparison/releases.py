"""The same cases in several releases of an engine: a matrix of values and what moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from harness.comparison.baseline_record import BaselineRecord, Quantity
from harness.comparison.divergence import compare_series
from harness.comparison.regression import earliest
from harness.comparison.regression_tolerances import regression_tolerance
from harness.observables.provenance import Provenance

if TYPE_CHECKING:
    import pandas as pd

ROUND_OFF = 1e-12
"""Relative change that is taken for rounding: some thousand units in the last place."""


class Change(StrEnum):
    """The class of a change against the reference release."""

    REFERENCE = "reference"
    SAME = "same to the last bit"
    ROUNDING = "within round-off"
    TOLERATED = "within tolerance"
    MOVED = "moved"
    DIED = "engine error"
    NOT_TESTED = "not tested"


@dataclass(frozen=True)
class Column:
    """A release: who it is and what it measured, or why it has nothing to say.

    ``errors`` are those of single cases, by name.
    """

    release: str
    provenance: Provenance | None
    cases: tuple[BaselineRecord, ...] = ()
    error: str = ""
    errors: Mapping[str, str] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """Return the release with the version that the engine itself gives."""
        return (
            f"{self.release} ({self.provenance.engine_version})"
            if self.provenance
            else self.release
        )


@dataclass(frozen=True)
class Cell:
    """A value of one release, its change against the reference, and the class of it."""

    value: float | None
    difference: float | None
    change: Change
    note: str = ""


@dataclass(frozen=True)
class Row:
    """A quantity of a case in every release."""

    case: str
    quantity: str
    unit: str
    tolerance: float
    cells: tuple[Cell, ...]


@dataclass(frozen=True)
class ReleaseMatrix:
    """Cases by releases; the first release that ran is the reference."""

    level: str
    platform: str
    columns: tuple[Column, ...]
    reference: int
    rows: tuple[Row, ...]

    @property
    def status(self) -> int:
        """Return the exit status: 3 when a release could not be run, 1 when a value moved."""
        if any(column.error or column.errors for column in self.columns):
            return 3
        return 1 if any(c.change is Change.MOVED for row in self.rows for c in row.cells) else 0

    def counts(self, column: int) -> dict[str, int]:
        """Return how many cells of a column are of each class."""
        found = [row.cells[column].change for row in self.rows]
        return {str(change): found.count(change) for change in Change if change in found}

    def frame(self) -> pd.DataFrame:
        """Return the cells as a table, one row each."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "case": row.case,
                    "quantity": row.quantity,
                    "unit": row.unit,
                    "release": column.release,
                    "engine_version": column.provenance.engine_version if column.provenance else "",
                    "value": cell.value,
                    "difference": cell.difference,
                    "tolerance": row.tolerance,
                    "change": str(cell.change),
                    "note": cell.note,
                }
                for row in self.rows
                for column, cell in zip(self.columns, row.cells, strict=True)
            ]
        )

    def record(self) -> dict[str, Any]:
        """Return the matrix as a JSON-ready mapping."""
        return {
            "level": self.level,
            "platform": self.platform,
            "status": self.status,
            "reference": self.columns[self.reference].release,
            "releases": [
                {
                    "release": column.release,
                    "engine": column.provenance.record() if column.provenance else None,
                    "error": column.error,
                    "changes": self.counts(i),
                }
                for i, column in enumerate(self.columns)
            ],
            "rows": [
                {
                    "case": row.case,
                    "quantity": row.quantity,
                    "unit": row.unit,
                    "tolerance": row.tolerance,
                    "cells": [
                        {**vars(cell), "change": str(cell.change), "release": column.release}
                        for column, cell in zip(self.columns, row.cells, strict=True)
                    ],
                }
                for row in self.rows
            ],
        }


def release_matrix(level: str, platform: str, columns: Sequence[Column]) -> ReleaseMatrix:
    """Return the matrix of what each release measured, against the first that ran."""
    reference = next((i for i, column in enumerate(columns) if column.cases), 0)
    measured = [{case.name: case for case in column.cases} for column in columns]
    rows = []
    for name in sorted({name for cases in measured for name in cases}):
        known = measured[reference].get(name)
        first = known or next(cases[name] for cases in measured if name in cases)
        for quantity, wanted in first.quantities.items():
            width = regression_tolerance(name, quantity)[0].width(wanted.value)
            cells = tuple(
                Cell(wanted.value, 0.0, Change.REFERENCE)
                if i == reference and known is not None
                else _cell(column, name, measured[i].get(name), known, quantity, width)
                for i, column in enumerate(columns)
            )
            rows.append(Row(name, quantity, wanted.unit, width, cells))
    return ReleaseMatrix(level, platform, tuple(columns), reference, tuple(rows))


def _cell(
    column: Column,
    name: str,
    case: BaselineRecord | None,
    known: BaselineRecord | None,
    quantity: str,
    width: float,
) -> Cell:
    said = column.error or column.errors.get(name, "")
    if case is None or quantity not in case.quantities:
        return Cell(None, None, Change.DIED if said else Change.NOT_TESTED, said)
    here = case.quantities[quantity]
    wanted = known.quantities.get(quantity) if known else None
    if known is None or wanted is None:
        return Cell(here.value, None, Change.NOT_TESTED, "the reference has no value")
    change = classify(here, wanted, width)
    note = _when(case, known) if change is Change.MOVED else ""
    return Cell(here.value, here.value - wanted.value, change, note)


def classify(here: Quantity, wanted: Quantity, width: float) -> Change:
    """Return the class of the change from one number to another."""
    difference = abs(here.value - wanted.value)
    if difference == 0.0:
        return Change.SAME
    if difference <= ROUND_OFF * abs(wanted.value):
        return Change.ROUNDING
    return Change.TOLERATED if difference <= width else Change.MOVED


def _when(case: BaselineRecord, known: BaselineRecord) -> str:
    """Say when the series of a case that moved left that of the reference."""
    if case.series is None or known.series is None:
        return ""
    width = regression_tolerance(known.name, "series")[0]
    columns = compare_series(known.name, case.series, known.series, width.relative)
    return earliest(columns)
