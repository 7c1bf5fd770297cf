"""The same records in several releases of an engine: a matrix of values and what moved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, Any

from harness.comparison.baseline_record import BaselineRecord, Quantity
from harness.comparison.divergence import compare_series
from harness.comparison.published import published
from harness.comparison.regression import earliest
from harness.comparison.regression_tolerances import Allowed, ByCase
from harness.errors import RequestError
from harness.observables.provenance import Provenance
from harness.shown import Shown

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure

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

    ``errors`` are those of single records, by name.
    """

    release: str
    provenance: Provenance | None
    records: tuple[BaselineRecord, ...] = ()
    error: str = ""
    errors: Mapping[str, str] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """Return the release with the version that the engine itself gives."""
        who = self.provenance
        return f"{self.release} ({who.engine_version})" if who else self.release


@dataclass(frozen=True)
class Cell:
    """A value of one release, its change against the reference, and the class of it."""

    value: float | None
    difference: float | None
    change: Change
    note: str = ""


@dataclass(frozen=True)
class Row:
    """A quantity of a record in every release; ``label`` says in short what the record is."""

    record: str
    label: str
    quantity: str
    unit: str
    tolerance: float
    cells: tuple[Cell, ...]


@dataclass(frozen=True, repr=False)
class ReleaseMatrix(Shown):
    """Records by releases of ``engine``; the first release that ran is the reference."""

    level: str
    platform: str
    columns: tuple[Column, ...]
    reference: int
    rows: tuple[Row, ...]
    engine: str = "engine"

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

    def told(self) -> dict[str, str]:
        """Return what moved in each release, against which one."""
        counts = {
            column.title: column.error or ", ".join(f"{n} {c}" for c, n in self.counts(i).items())
            for i, column in enumerate(self.columns)
        }
        return {**counts, "engine": self.engine, "cases": f"{self.level} on {self.platform}"}

    def drawn(self) -> Figure:
        """Draw by how many tolerances each quantity moved, release by release."""
        from harness.shown.figure import beside_tolerance

        moved = [(row.cells, row.tolerance) for row in self.rows if row.tolerance]
        groups = {
            column.title: [(cells[i].difference or 0.0) / width for cells, width in moved]
            for i, column in enumerate(self.columns)
        }
        return beside_tolerance(groups, "change over its tolerance")

    def frame(self) -> pd.DataFrame:
        """Return the cells as a table, one row each."""
        import pandas as pd

        return pd.DataFrame(
            [
                {
                    "case": row.record,
                    "quantity": row.quantity,
                    "unit": row.unit,
                    "release": column.release,
                    "engine_version": column.provenance.engine_version if column.provenance else "",
                    "value": cell.value,
                    "difference": cell.difference,
                    "tolerance": row.tolerance,
                    "change": str(cell.change),
                    "note": cell.note,
                    "label": row.label,
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
                    "engine": published(column.provenance) if column.provenance else None,
                    "error": column.error,
                    "changes": self.counts(i),
                }
                for i, column in enumerate(self.columns)
            ],
            "rows": [self._row(row) for row in self.rows],
        }

    def _row(self, row: Row) -> dict[str, Any]:
        told = published(row)
        told["case"] = told.pop("record")
        for cell, column in zip(told["cells"], self.columns, strict=True):
            cell["release"] = column.release
        return told


def release_matrix(
    level: str, platform: str, columns: Sequence[Column], tolerances: ByCase, engine: str = "engine"
) -> ReleaseMatrix:
    """Return the matrix of what each release measured, against the first that ran.

    ``engine`` is its name as reports write it.
    """
    allowed = Allowed(tolerances)
    reference = next((i for i, column in enumerate(columns) if column.records), 0)
    measured = [{record.name: record for record in column.records} for column in columns]
    rows = []
    for name in sorted({name for records in measured for name in records}):
        known = measured[reference].get(name)
        first = known or next(records[name] for records in measured if name in records)
        for quantity, wanted in first.quantities.items():
            width = allowed.of(first.case, name, quantity)[0].width(wanted.value)
            cells = tuple(
                Cell(wanted.value, 0.0, Change.REFERENCE)
                if i == reference and known is not None
                else _cell(
                    column, measured[i].get(name), known, Judged(name, quantity, width), allowed
                )
                for i, column in enumerate(columns)
            )
            rows.append(Row(name, first.label, quantity, wanted.unit, width, cells))
    return ReleaseMatrix(level, platform, tuple(columns), reference, tuple(rows), engine)


@dataclass(frozen=True)
class Judged:
    """A quantity of a record, and how far it may move."""

    record: str
    quantity: str
    width: float


def _cell(
    column: Column,
    record: BaselineRecord | None,
    known: BaselineRecord | None,
    judged: Judged,
    allowed: Allowed,
) -> Cell:
    said = column.error or column.errors.get(judged.record, "")
    if record is None or judged.quantity not in record.quantities:
        return Cell(None, None, Change.DIED if said else Change.NOT_TESTED, said)
    here = record.quantities[judged.quantity]
    wanted = known.quantities.get(judged.quantity) if known else None
    if known is None or wanted is None:
        return Cell(here.value, None, Change.NOT_TESTED, "the reference has no value")
    change = classify(here, wanted, judged.width)
    note = _when(record, known, allowed) if change is Change.MOVED else ""
    return Cell(here.value, here.value - wanted.value, change, note)


def classify(here: Quantity, wanted: Quantity, width: float) -> Change:
    """Return the class of the change from one number to another."""
    difference = abs(here.value - wanted.value)
    if difference == 0.0:
        return Change.SAME
    if difference <= ROUND_OFF * abs(wanted.value):
        return Change.ROUNDING
    return Change.TOLERATED if difference <= width else Change.MOVED


def _when(record: BaselineRecord, known: BaselineRecord, allowed: Allowed) -> str:
    """Say when the series of a record that moved left that of the reference."""
    if record.series is None or known.series is None:
        return ""
    width = allowed.of(record.case, known.name, "series")[0]
    try:
        columns = compare_series(known.name, record.series, known.series, width.relative)
    except RequestError as error:
        return str(error)
    return earliest(columns)
