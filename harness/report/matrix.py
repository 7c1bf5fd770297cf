"""Group the rows of a run: by the cells of a matrix, and what does not hold by its cause.

A known defect is one cause in whatever cells it shows, and so is a reason for which rows were not
tested. Failures without a known cause are grouped by their class, of what kind it is, and the cell
that they stand in; the first row of a group tells its numbers.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from shlex import quote

from harness.comparison.known_defects import KnownDefect, defect_of
from harness.comparison.verdicts import Cell, Check, Kind, Verdict
from harness.comparison.verification import Verification
from harness.engines.registry import DEFAULT, engine_title
from harness.report import text
from harness.report.plain import printable, safe_path
from harness.report.sections import Label, Table, TableCell
from harness.report.text import SEVERITY, happened
from harness.shown import in_words, number

FOLDER = "defects"

Place = tuple[str, str, str]
"""Case, submodel and engine of a cell."""

MARKS = (
    "A mark for each system of bodies: the largest error of its quantities in the limit of a small "
    "step, relative for what has a unit. It leads to the row; a defect is one that is known."
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

    def table(self) -> Table:
        """Return it as a table; its marks lead to rows."""

        def label(mark: Mark) -> Label:
            address = f"#{mark.place}"
            return Label(mark.text, mark.check.verdict, address, mark.cell.system, mark.title)

        def cells(row: Mapping[str, tuple[Mark, ...]]) -> list[TableCell]:
            return [tuple(map(label, row.get(column, ()))) for column in self.columns]

        rows = [(name, *cells(row)) for name, row in self.rows.items()]
        title = f"Cases and submodels, {self.title}"
        return Table(title, MARKS, (self.head, *self.columns), tuple(rows))


def matrices(placed: Sequence[tuple[Check, str]]) -> list[Matrix]:
    """Return a matrix for each engine of checks that stand in cells, each with its place.

    Where there are several, one with a column for each comes first. An invariance is seen where
    it fails only: what is known of those would hide the values.
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
    written = {engine: engine_title(engine) for engine in engines}
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


def values(checks: Sequence[Check]) -> list[Table]:
    """Return a table for each engine and case of what stands in cells: value, reference, order."""
    tables: dict[tuple[str, str], list[Mark]] = {}
    for mark in (Mark(check, "") for check in checks if stands_in_cell(check)):
        tables.setdefault((mark.cell.engine, mark.cell.case), []).append(mark)
    return [
        Table(f"Values of {case}, {engine_title(engine)}", "", HEAD, tuple(_rows(marks)))
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


APART = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)
"""Verdicts that need a cause, in the order of reading."""

COMMENT = re.compile(r"^(?:#|//|!)+ ?")
REMARK = re.compile(r" {3,}(?!#)")
"""What stands between a command and a remark on it."""


@dataclass(frozen=True)
class Cause:
    """Rows of one verdict and one cause.

    ``title`` names it, ``sentences`` explain it. ``commands`` run it again, each on a line;
    ``script`` is the address of the script that shows a known defect, empty without one. ``cells``
    are the cells that it stands in, in the order of the rows.
    """

    verdict: Verdict
    title: str
    sentences: tuple[str, ...]
    rows: tuple[Check, ...]
    commands: tuple[str, ...] = ()
    script: str = ""

    @property
    def cells(self) -> tuple[Place, ...]:
        """Return case, submodel and engine of each cell once."""
        places = (row.cell.place[:2] + row.cell.place[3:4] for row in self.rows if row.cell)
        return tuple(dict.fromkeys((case, name, engine) for case, name, engine in places))

    @property
    def count(self) -> str:
        """Return how many rows there are, in how many cells of the matrix."""
        rows, cells = len(self.rows), len(self.cells)
        counted = f"{rows} row{'s' * (rows != 1)}"
        return f"{counted} in {cells} cell{'s' * (cells != 1)} of the matrix" if cells else counted


def causes(verification: Verification) -> list[Cause]:
    """Return the causes of what does not hold, the most severe first."""
    groups: dict[tuple[str, ...], list[Check]] = {}
    for check in text.by_severity(verification.checks):
        if check.verdict in APART:
            groups.setdefault((check.verdict, *_key(check)), []).append(check)
    defects = {defect.name: (defect, script) for defect, script in verification.defects}
    return [_cause(rows, defects) for rows in groups.values()]


def _key(check: Check) -> tuple[str, ...]:
    """Return what rows of one cause have in common."""
    if defect := defect_of(check):
        return (defect,)
    if check.verdict is Verdict.NOT_TESTED and check.cell and math.isnan(check.value):
        return (check.cell.engine,)
    if check.verdict is Verdict.NOT_TESTED:
        return (check.note,)
    cell = check.cell.place[:2] if check.cell else ()
    if check.engine_died:
        return (check.triage, check.note, *cell)
    return (check.kind, check.triage, *cell)


def _cause(rows: Sequence[Check], defects: Mapping[str, tuple[KnownDefect, str]]) -> Cause:
    first = rows[0]
    name = defect_of(first)
    if name in defects:
        return _of_defect(rows, *defects[name])
    sentences: tuple[str, ...] = ()
    if first.verdict is Verdict.NOT_TESTED:
        title = first.note or "no reason was given"
        if len({row.note for row in rows}) > 1 and first.cell:
            title = f"What {first.cell.engine} does not state, or left without a value"
    else:
        title = text.triage(first) or str(first.verdict)
        if first.cell:
            title = f"{title}: {first.cell.case}, {first.cell.submodel}"
        else:
            title = f"{title}: {first.name}"
        remarks = (text.explained(first), text.details(first), text.happened(first))
        sentences = tuple(dict.fromkeys(_sentence(remark) for remark in remarks if remark))
    again = (_command(first.cell),) if first.verdict is Verdict.FAIL and first.cell else ()
    return Cause(first.verdict, title, sentences, tuple(rows), again)


def _command(cell: Cell) -> str:
    """Return the command that makes the rows of a cell's system again."""
    place = quote(f"{cell.case}/{cell.submodel}/{cell.system}")
    engine = "" if cell.engine == DEFAULT else f" --engine {cell.engine}"
    return f"dem-harness verify --only {place}{engine}"


def _of_defect(rows: Sequence[Check], defect: KnownDefect, script: str) -> Cause:
    """Return a known defect with what its script says of itself."""
    releases = " ".join(
        f"{word} {release}"
        for word, release in (("from", defect.since), ("to", defect.until))
        if release
    )
    sentences = [f"{defect.kind.capitalize()}: {defect.cause}."]
    if releases:
        sentences.append(f"Releases {releases}.")
    sentences.append(f"Upstream: {defect.upstream}.")
    file = address(defect) if script else ""
    folder = file.rpartition("/")[0]
    lines = (f"cd {folder}", *runs_of_script(script)) if script else ()
    return Cause(rows[0].verdict, defect.name, tuple(sentences), tuple(rows), lines, file)


def runs_of_script(script: str) -> Iterator[str]:
    """Yield the commands that a script gives in its opening comment: its indented lines."""
    for line in printable(script).splitlines():
        text = COMMENT.sub("", line, count=1)
        if text == line:
            return
        if text.startswith("    "):
            yield REMARK.sub("   # ", text.strip())


def _sentence(words: str) -> str:
    return f"{words.rstrip('.')}."
