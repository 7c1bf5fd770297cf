"""Arrange checks as a matrix of submodels by cases; a cell has the worst check of each system."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from harness.comparison.verdicts import Cell, Check, Verdict
from harness.report.plain import markdown_text
from harness.report.triage import happened
from harness.report.verdict_summary import SEVERITY


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
        """Return the observed order; a dash where there is none to be told."""
        return "-" if math.isnan(self.cell.order) else f"{self.cell.order:.2f}"

    @property
    def interval(self) -> str:
        """Return the interval of the order."""
        low, high = self.cell.order_low, self.cell.order_high
        return "-" if math.isnan(self.cell.order) else f"{low:.2f} to {high:.2f}"

    @property
    def title(self) -> str:
        """Return system, value, reference, error and order in a line."""
        what = self.cell.invariance or _quantity(self.check)
        told = f"{self.cell.system}, {what}: {happened(self.check)}"
        return told if self.order == "-" else f"{told}, order {self.order} ({self.interval})"


def _quantity(check: Check) -> str:
    return check.name.rpartition(": ")[2]


@dataclass(frozen=True)
class Matrix:
    """Submodels by cases for one engine, or both by engines; a cell has a mark for each system."""

    title: str
    head: str
    columns: tuple[str, ...]
    rows: Mapping[str, Mapping[str, tuple[Mark, ...]]]


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
    found = [
        _matrix(title, "submodel", [m for m in marks if m.cell.engine == engine], _by_case)
        for engine, title in written.items()
    ]
    if len(found) < 2:
        return found

    def by_engine(cell: Cell) -> tuple[str, str]:
        return f"{cell.case}: {cell.submodel}", written[cell.engine]

    whole = _matrix("engine by engine", "case and submodel", marks, by_engine)
    rows = {name: whole.rows[name] for name in sorted(whole.rows)}
    return [replace(whole, columns=tuple(written.values()), rows=rows), *found]


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
    told = {name: {column: _once(row[column]) for column in row} for name, row in rows.items()}
    return Matrix(title, head, columns, told)


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


def matrix_markdown(
    checks: Sequence[Check], titles: Mapping[str, str] | None = None
) -> Iterator[str]:
    """Yield the lines of all matrices; nothing without cells."""
    for matrix in matrices([(check, "") for check in checks], titles):
        yield from (f"## Cases and submodels, {markdown_text(matrix.title)}", "")
        yield f"| {matrix.head} | {' | '.join(map(markdown_text, matrix.columns))} |"
        yield f"|---|{'---|' * len(matrix.columns)}"
        for name, row in matrix.rows.items():
            cells = (", ".join(m.text for m in row.get(one, ())) for one in matrix.columns)
            yield f"| {markdown_text(name)} | {' | '.join(cells)} |"
        yield ""
