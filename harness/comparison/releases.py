"""The same cases in several releases of an engine: what changed, and which cells do not hold.

A matrix has the values of records release by release, each against the first release that ran
(:func:`release_matrix`), and the cells of cases and submodels that do not hold in every release,
with the known defects that were found in them (:func:`cell_rows`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from harness.comparison.compare import Change, Pair, compare
from harness.comparison.known_defects import defect_of
from harness.comparison.regression import (
    BaselineRecord,
    ByCase,
    allowed_change,
    earliest,
    name_in_cell,
)
from harness.comparison.series import compare_series
from harness.comparison.verdicts import RANK, Check, Kind, Verdict
from harness.errors import RequestError
from harness.observables.provenance import Provenance
from harness.observables.row import Row
from harness.shown import Record, Result, to_json

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure


Place = tuple[str, str, str]

JUDGED = frozenset({Verdict.PASS, Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED})
"""Verdicts of rows that were held against something."""


@dataclass(frozen=True)
class CellRow(Record):
    """A cell in every release: the worst verdict of its checks, empty where it has none.

    ``reasons`` say why it was not tested, release by release; empty where it was.
    """

    case: str
    submodel: str
    system: str
    verdicts: tuple[str, ...]
    defects: tuple[str, ...]
    """Names of known defects, in any release."""
    reasons: tuple[str, ...] = ()


def cell_rows(checks: Sequence[Sequence[Check]]) -> list[CellRow]:
    """Return the cells that do not hold in every release; ``checks`` are those of each release."""
    columns = [_by_place(of_release) for of_release in checks]
    rows = []
    for place in sorted({place for column in columns for place in column}):
        cells = [column.get(place, []) for column in columns]
        verdicts = tuple(_worst(cell) for cell in cells)
        if {*verdicts} != {str(Verdict.PASS)}:
            names = {defect_of(check) for cell in cells for check in cell} - {""}
            reasons = tuple(map(_reason, cells))
            rows.append(CellRow(*place, verdicts, tuple(sorted(names)), reasons))
    return rows


def untested(rows: Sequence[CellRow], release: int) -> dict[str, list[CellRow]]:
    """Return the cells that a release leaves untested, by the reason."""
    by_reason: dict[str, list[CellRow]] = {}
    for row in rows:
        if row.reasons[release]:
            by_reason.setdefault(row.reasons[release], []).append(row)
    return by_reason


def reasons_of_records(checks: Sequence[Check]) -> dict[str, str]:
    """Return why records have no values, by the name of the record of each untested cell."""
    values = [check for check in checks if check.cell is not None and not check.cell.invariance]
    return {
        name_in_cell(cell[0].cell): _reason(cell)
        for cell in _by_place(values).values()
        if cell[0].cell is not None and _reason(cell)
    }


def defects_of(checks: Sequence[Sequence[Check]]) -> dict[str, list[int]]:
    """Return in how many cells of each release a known defect was found, by its name."""
    by_release: list[set[tuple[str, Place]]] = [
        {
            (defect_of(check), place)
            for place, cell in _by_place(of_release).items()
            for check in cell
            if check.verdict is Verdict.KNOWN_DEFECT
        }
        for of_release in checks
    ]
    names = sorted({name for defects in by_release for name, _ in defects})
    return {
        name: [sum(1 for other, _ in defects if other == name) for defects in by_release]
        for name in names
    }


def _by_place(checks: Sequence[Check]) -> dict[Place, list[Check]]:
    by_place: dict[Place, list[Check]] = {}
    for check in checks:
        if check.cell is not None:
            by_place.setdefault(check.cell.place[:3], []).append(check)
    return by_place


def _worst(cell: Sequence[Check]) -> str:
    deciding = _deciding(cell)
    # of equals what has a value counts before what has not
    ranks = {c.verdict: (RANK[c.verdict], c.verdict is Verdict.NOT_TESTED) for c in deciding}
    return str(min(ranks, key=lambda verdict: ranks[verdict])) if ranks else ""


def _reason(cell: Sequence[Check]) -> str:
    if _worst(cell) != Verdict.NOT_TESTED:
        return ""
    rows = [check for check in cell if check.verdict is Verdict.NOT_TESTED]
    values = [check for check in rows if check.kind is not Kind.INVARIANCE]
    return "; ".join(dict.fromkeys(check.note for check in values or rows))


def _deciding(cell: Sequence[Check]) -> Sequence[Check]:
    """Return the rows that decide a cell: of what was judged, no invariance that was not tested.

    One that no width follows for, or that an engine refuses, says nothing of values that hold.
    """
    if all(check.verdict not in JUDGED for check in cell):
        return cell
    return [c for c in cell if not (c.kind is Kind.INVARIANCE and c.verdict is Verdict.NOT_TESTED)]


class ReleaseChange(StrEnum):
    """The class of a change against the reference release."""

    REFERENCE = "reference"
    SAME = Change.SAME
    ROUNDING = Change.ROUNDING
    TOLERATED = Change.TOLERATED
    MOVED = Change.MOVED
    DIED = "engine error"
    NOT_TESTED = "not tested"


def parted(record: BaselineRecord, reference: BaselineRecord, tolerances: ByCase) -> str:
    """Say when the series of a record that moved left that of the reference."""
    if record.series is None or reference.series is None:
        return ""
    width = allowed_change(tolerances, record.case, "series")
    try:
        columns = compare_series(reference.name, record.series, reference.series, width.relative)
    except RequestError as error:
        return str(error)
    return earliest(columns)


@dataclass(frozen=True)
class Column:
    """A release: who it is and what it measured, or why it has nothing to say.

    ``errors`` are those of single records, by name; ``checks`` the rows of its cells in the matrix
    of cases and submodels, and those of cases that left none: failed as a whole, or without rows
    of their plan.
    """

    release: str
    provenance: Provenance | None
    records: tuple[BaselineRecord, ...] = ()
    error: str = ""
    errors: Mapping[str, str] = field(default_factory=dict)
    checks: tuple[Check, ...] = ()

    @property
    def title(self) -> str:
        """Return the release with the version that the engine itself gives."""
        provenance = self.provenance
        return f"{self.release} ({provenance.engine_version})" if provenance else self.release

    @cached_property
    def reasons(self) -> dict[str, str]:
        """Return why records of cells that were not tested are missing, by name."""
        return reasons_of_records(self.checks)

    @property
    def lost(self) -> str:
        """Return what failed beside the cells: why a record without a reason may be missing."""
        failed = [c for c in self.checks if c.cell is None and c.verdict is Verdict.FAIL]
        return "; ".join(f"{check.name}: {check.note or check.triage}" for check in failed)


@dataclass(frozen=True)
class ReleaseCell(Pair[Row], Record):
    """A value of one release (``after``) and that of the reference (``before``).

    ``note`` says what happened to one that has no value or moved.
    """

    change: ReleaseChange
    note: str = ""

    JSON: ClassVar = {
        "value": "value",
        "difference": "difference",
        "change": "change",
        "note": "note",
    }

    @property
    def value(self) -> float | None:
        """Return the value of the release, None where it has none."""
        return self.after.value if self.after else None

    @property
    def difference(self) -> float | None:
        """Return how far it is from that of the reference, None where one is missing."""
        return self.moved_by if self.before and self.after else None


@dataclass(frozen=True)
class ReleaseRow:
    """A quantity of a record in every release; ``label`` says in short what the record is."""

    record: str
    label: str
    quantity: str
    unit: str
    tolerance: float
    cells: tuple[ReleaseCell, ...]


@dataclass(frozen=True, repr=False)
class ReleaseMatrix(Result):
    """Records by releases of ``engine``; the first release that ran is the reference."""

    level: str
    platform: str
    columns: tuple[Column, ...]
    reference: int
    rows: tuple[ReleaseRow, ...]
    engine: str = "engine"
    cases: str = ""

    @property
    def status(self) -> int:
        """Return the exit status: 3 when a release could not be run, 1 when a value moved.

        1, too, when a cell fails and no known defect explains it, or a case left no rows.
        """
        if any(column.error or column.errors for column in self.columns):
            return 3
        failed = any(c.verdict is Verdict.FAIL for column in self.columns for c in column.checks)
        moved = any(c.change is ReleaseChange.MOVED for row in self.rows for c in row.cells)
        return 1 if failed or moved else 0

    @property
    def cells(self) -> list[CellRow]:
        """Return the cells of the matrix of cases and submodels that do not hold everywhere."""
        return cell_rows([column.checks for column in self.columns])

    @property
    def defects(self) -> dict[str, list[int]]:
        """Return in how many cells each known defect was found, release by release."""
        return defects_of([column.checks for column in self.columns])

    def counts(self, column: int) -> dict[str, int]:
        """Return how many cells of a column are of each class."""
        changes = [row.cells[column].change for row in self.rows]
        return {str(change): changes.count(change) for change in ReleaseChange if change in changes}

    def summary(self) -> dict[str, str]:
        """Return what moved in each release, against which one."""
        counts = {
            column.title: column.error or ", ".join(f"{n} {c}" for c, n in self.counts(i).items())
            for i, column in enumerate(self.columns)
        }
        return {**counts, "engine": self.engine, "cases": f"{self.level} on {self.platform}"}

    def draw(self) -> Figure:
        """Draw by how many tolerances each quantity moved, release by release."""
        from harness.shown.figure import beside_tolerance

        moved = [(row.cells, row.tolerance) for row in self.rows if row.tolerance]
        groups = {
            column.title: [(cells[i].difference or 0.0) / width for cells, width in moved]
            for i, column in enumerate(self.columns)
        }
        return beside_tolerance(groups, "change over its tolerance")

    def to_frame(self) -> pd.DataFrame:
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

    def to_json(self) -> dict[str, Any]:
        """Return the matrix as a JSON-ready mapping."""
        return {
            "level": self.level,
            "platform": self.platform,
            "status": self.status,
            "reference": self.columns[self.reference].release,
            "releases": [
                {
                    "release": column.release,
                    "engine": to_json(column.provenance),
                    "error": column.error,
                    "changes": self.counts(i),
                }
                for i, column in enumerate(self.columns)
            ],
            "rows": [self._row(row) for row in self.rows],
            "known_defects": self.defects,
            "cells": to_json(self.cells),
        }

    def _row(self, row: ReleaseRow) -> dict[str, Any]:
        releases = [column.release for column in self.columns]
        cells = [
            {**cell.to_json(), "release": release}
            for cell, release in zip(row.cells, releases, strict=True)
        ]
        fields = {name: value for name, value in vars(row).items() if name != "record"}
        return {**fields, "case": row.record, "cells": cells}


def release_matrix(
    level: str,
    platform: str,
    columns: Sequence[Column],
    tolerances: ByCase,
    engine: str = "engine",
    cases: str = "",
) -> ReleaseMatrix:
    """Return the matrix of what each release measured, against the first that ran.

    ``engine`` is its name as reports write it, ``cases`` what was asked for.
    """
    reference = next((i for i, column in enumerate(columns) if column.records), 0)
    measured = [{record.name: record for record in column.records} for column in columns]
    rows = []
    for name in sorted({name for records in measured for name in records}):
        of_reference = measured[reference].get(name)
        first = of_reference or next(records[name] for records in measured if name in records)

        def width(wanted: Row, _: Row | None = None, of: BaselineRecord = first) -> float:
            return allowed_change(tolerances, of.case, wanted.name).width(wanted.value)

        before = of_reference.quantities if of_reference else {}
        pairs = [
            compare(before, records[name].quantities if name in records else {}, width)
            for records in measured
        ]
        for quantity, wanted in first.quantities.items():
            cells = tuple(
                _cell(column, name, of_release.get(quantity), column is columns[reference])
                for column, of_release in zip(columns, pairs, strict=True)
            )
            cells = tuple(
                replace(cell, note=parted(records[name], of_reference, tolerances))
                if cell.change is ReleaseChange.MOVED and of_reference
                else cell
                for cell, records in zip(cells, measured, strict=True)
            )
            unit, wide = wanted.unit, width(wanted)
            rows.append(ReleaseRow(name, first.label, quantity, unit, wide, cells))
    return ReleaseMatrix(level, platform, tuple(columns), reference, tuple(rows), engine, cases)


def _cell(column: Column, name: str, pair: Pair[Row] | None, reference: bool) -> ReleaseCell:
    if pair is None or pair.after is None:
        before = pair.before if pair else None
        if error := column.error or column.errors.get(name, ""):
            return ReleaseCell(before, None, ReleaseChange.DIED, note=error)
        why = column.reasons.get(name, column.lost)
        return ReleaseCell(before, None, ReleaseChange.NOT_TESTED, note=why)
    if pair.before is None:
        why = "the reference has no value"
        return ReleaseCell(None, pair.after, ReleaseChange.NOT_TESTED, note=why)
    change = ReleaseChange.MOVED if math.isnan(pair.moved_by) else ReleaseChange(pair.change)
    if reference:
        change = ReleaseChange.REFERENCE
    return ReleaseCell(pair.before, pair.after, change, pair.width)
