"""Arrange checks as a matrix of submodels by cases, and as tables of the values of its cells.

A cell has the worst check of each system; the scripts of known defects lie beside the report.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from harness.comparison.known_defects import KnownDefect, defect_of
from harness.comparison.verdicts import Cell, Check, Kind, Verdict
from harness.comparison.verification import Verification
from harness.report.plain import safe_path
from harness.report.sections import Label, Table, TableCell
from harness.report.text import SEVERITY, happened
from harness.shown import in_words, number

FOLDER = "defects"

Place = tuple[str, str, str]
"""Case, submodel and engine of a cell."""

MARKS = (
    "A mark for each system of bodies: the largest error of its quantities in the limit of a small "
    "step, relative for what has a unit. It leads to {leads} with value, reference and order; a "
    "defect is one that is known."
)


def address(defect: KnownDefect) -> str:
    """Return the file of a defect's script below a report."""
    return f"{FOLDER}/{safe_path(defect.name)}/{safe_path(defect.script.rpartition('/')[2])}"


def defect_scripts(verification: Verification) -> dict[str, str]:
    """Return the scripts of the defects that checks are marked with, by their files."""
    return {address(defect): script for defect, script in verification.defects if script}


@dataclass(frozen=True)
class Mark:
    """A check that stands in a cell of the matrix, and the place of its row in the report."""

    check: Check
    place: str

    @property
    def cell(self) -> Cell:
        """Return where it stands."""
        assert self.check.cell is not None
        return self.check.cell

    @property
    def text(self) -> str:
        """Return the error of a cell that holds, else the verdict in a word or two.

        The error of what has a unit is relative: of all cells it is held against one width.
        """
        check = self.check
        if check.verdict is Verdict.PASS:
            scale = 1.0 if check.unit in ("", "1") else abs(check.expected)
            error = abs(check.difference) / (scale or 1.0)
            return f"{error:.0e}" if error else "0"
        return str(self.check.verdict).removeprefix("known ")

    @property
    def quantity(self) -> str:
        """Return what was measured; empty for a row that says that nothing was."""
        return _quantity(self.check) if math.isfinite(self.check.expected) else ""

    @property
    def order(self) -> str:
        """Return the observed order; a dash where no error is known to fall with the step."""
        return f"{self.cell.order:.2f}" if self.cell.order_low > 0.0 else "-"

    @property
    def interval(self) -> str:
        """Return the interval of the order."""
        low, high = self.cell.order_low, self.cell.order_high
        return "-" if self.order == "-" else f"{low:.2f} to {high:.2f}"

    @property
    def title(self) -> str:
        """Return system, value, reference, error and order in a line."""
        subject = self.cell.invariance or _quantity(self.check)
        words = f"{self.cell.system}, {subject}: {happened(self.check)}"
        return words if self.order == "-" else f"{words}, order {self.order} ({self.interval})"


def _quantity(check: Check) -> str:
    return check.name.rpartition(": ")[2]


@dataclass(frozen=True)
class Matrix:
    """Submodels by cases for one engine, or both by engines; a cell has a mark for each system."""

    title: str
    head: str
    columns: tuple[str, ...]
    rows: Mapping[str, Mapping[str, tuple[Mark, ...]]]

    def table(self, pages: Mapping[Place, str]) -> Table:
        """Return it as a table; its marks lead to ``pages`` of cells, or to rows without them."""

        def label(mark: Mark) -> Label:
            address = pages.get(
                (mark.cell.case, mark.cell.submodel, mark.cell.engine), f"#{mark.place}"
            )
            return Label(mark.text, mark.check.verdict, address, mark.cell.system, mark.title)

        def cells(row: Mapping[str, tuple[Mark, ...]]) -> list[TableCell]:
            return [tuple(map(label, row.get(column, ()))) for column in self.columns]

        rows = [(name, *cells(row)) for name, row in self.rows.items()]
        caption = MARKS.format(leads="the page" if pages else "the row")
        title = f"Cases and submodels, {self.title}"
        return Table(title, caption, (self.head, *self.columns), tuple(rows))


def matrices(
    placed: Sequence[tuple[Check, str]], titles: Mapping[str, str] | None = None
) -> list[Matrix]:
    """Return a matrix for each engine of checks that stand in cells, each with its place.

    Where there are several, one with a column for each comes first. ``titles`` are how engines
    are written, by name. An invariance is seen where it fails only: what is known of those would
    hide the values.
    """
    worst: dict[tuple[str, ...], Mark] = {}
    for check, place in placed:
        if check.cell is not None:
            if check.cell.invariance and check.verdict is not Verdict.FAIL:
                continue
            mark = Mark(check, place)
            key = check.cell.place[:4]
            if key not in worst or _severity(mark) < _severity(worst[key]):
                worst[key] = mark
    marks = sorted(worst.values(), key=lambda m: (m.cell.submodel, m.cell.system))
    engines = dict.fromkeys(mark.cell.engine for mark in worst.values())
    written = {engine: (titles or {}).get(engine, engine) for engine in engines}
    tables = [
        _matrix(title, "submodel", [m for m in marks if m.cell.engine == engine], _by_case)
        for engine, title in written.items()
    ]
    if len(tables) < 2:
        return tables

    def by_engine(cell: Cell) -> tuple[str, str]:
        return f"{cell.case}: {cell.submodel}", written[cell.engine]

    overall = _matrix("engine by engine", "case and submodel", marks, by_engine)
    rows = {name: overall.rows[name] for name in sorted(overall.rows)}
    return [replace(overall, columns=tuple(written.values()), rows=rows), *tables]


def _by_case(cell: Cell) -> tuple[str, str]:
    return cell.submodel, cell.case


def _matrix(
    title: str, head: str, marks: Sequence[Mark], place: Callable[[Cell], tuple[str, str]]
) -> Matrix:
    """Return the matrix of marks, each in the row and the column that ``place`` tells."""
    rows: dict[str, dict[str, tuple[Mark, ...]]] = {}
    for mark in marks:
        name, column = place(mark.cell)
        row = rows.setdefault(name, {})
        row[column] = (*row.get(column, ()), mark)
    columns = tuple(sorted({column for row in rows.values() for column in row}))
    merged = {name: {column: _once(row[column]) for column in row} for name, row in rows.items()}
    return Matrix(title, head, columns, merged)


def _once(marks: tuple[Mark, ...]) -> tuple[Mark, ...]:
    """Return marks, one for all systems where none was tested."""
    untested = all(mark.check.verdict is Verdict.NOT_TESTED for mark in marks)
    return marks[:1] if untested else marks


def _severity(mark: Mark) -> tuple[bool, int, float]:
    """Return the place in the order of reading: worse verdicts, then larger errors, first.

    What was not tested comes last: a quantity that a code does not tell hides no other.
    """
    check = mark.check
    used = abs(check.difference) / check.tolerance if check.tolerance > 0.0 else 0.0
    untested = check.verdict is Verdict.NOT_TESTED
    return untested, SEVERITY.index(check.verdict), -used if math.isfinite(used) else 0.0


HEAD = (
    "submodel",
    "system",
    "quantity",
    "value",
    "reference",
    "by",
    "error",
    "tolerance",
    "order",
    "95 % interval",
    "verdict",
)
BY = {Kind.ANALYTIC: "closed form", Kind.CROSS_CODE: "integration"}


def stands_in_cell(check: Check) -> bool:
    """Return whether a check is a value of a cell, and not something that must not change it."""
    return check.cell is not None and not check.cell.invariance


def values(checks: Sequence[Check], titles: Mapping[str, str]) -> list[Table]:
    """Return a table for each engine and case of what stands in cells: value, reference, order.

    ``titles`` are how engines are written, by name.
    """
    tables: dict[tuple[str, str], list[Mark]] = {}
    for mark in (Mark(check, "") for check in checks if stands_in_cell(check)):
        tables.setdefault((mark.cell.engine, mark.cell.case), []).append(mark)
    return [
        Table(f"Values of {case}, {titles.get(engine, engine)}", "", HEAD, tuple(_rows(marks)))
        for (engine, case), marks in tables.items()
    ]


def _rows(marks: Sequence[Mark]) -> Iterator[tuple[str, ...]]:
    """Yield a row for each value; one for all systems of a submodel that cannot be stated."""
    refused: set[tuple[str, str]] = set()
    for mark in marks:
        check, cell = mark.check, mark.cell
        if not mark.quantity:
            words = _verdict(check)
            if (cell.submodel, words) not in refused:
                refused.add((cell.submodel, words))
                yield (cell.submodel, cell.system, *["-"] * (len(HEAD) - 3), words)
            continue
        words = in_words(mark.quantity, check.unit)
        yield (
            cell.submodel,
            cell.system,
            f"{words} ({check.unit})" if check.unit else words,
            number(check.value),
            number(check.expected),
            BY.get(check.kind, str(check.kind)),
            number(check.difference, 2),
            number(check.tolerance, 2),
            mark.order,
            mark.interval,
            _verdict(check),
        )


def _verdict(check: Check) -> str:
    """Return the verdict with the name of the defect, or why there is no value."""
    reason = defect_of(check)
    if not reason and check.verdict in (Verdict.FAIL, Verdict.NOT_TESTED):
        reason = check.note or check.triage
    return f"{check.verdict}: {reason}" if reason else str(check.verdict)
