"""The matrix of cases and submodels: what became of each cell, in each system of bodies."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from harness.comparison.verdicts import Cell, Check, Verdict
from harness.report.plain import markdown_text
from harness.report.triage import happened
from harness.report.verdict_summary import SEVERITY


@dataclass(frozen=True)
class Mark:
    """What became of a cell in one system: its worst check, told by the place of its row."""

    check: Check
    place: str

    @property
    def cell(self) -> Cell:
        """Return where it stands."""
        assert self.check.cell is not None
        return self.check.cell

    @property
    def text(self) -> str:
        """Return the error of a cell that holds, else the verdict in a word or two."""
        if self.check.verdict is Verdict.PASS:
            return f"{abs(self.check.difference):.0e}"
        return str(self.check.verdict).removeprefix("known ")

    @property
    def title(self) -> str:
        """Return system, value, reference, error and order in a line."""
        quantity = self.check.name.rpartition(": ")[2]
        cell = self.cell
        order = f", order {cell.order:.2f} ({cell.order_low:.2f} to {cell.order_high:.2f})"
        told = f"{cell.system}, {cell.invariance or quantity}: {happened(self.check)}"
        return told + ("" if math.isnan(cell.order) else order)


@dataclass(frozen=True)
class Matrix:
    """Submodels by cases for one engine, by its title; each cell has a mark for each system."""

    engine: str
    title: str
    cases: tuple[str, ...]
    rows: Mapping[str, Mapping[str, tuple[Mark, ...]]]


def matrices(
    placed: Sequence[tuple[Check, str]], titles: Mapping[str, str] | None = None
) -> list[Matrix]:
    """Return a matrix for each engine of checks that stand in cells, each with its place.

    ``titles`` are how engines are written, by name. An invariance is seen where it fails only:
    what is known of those would hide the values.
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
    engines = dict.fromkeys(mark.cell.engine for mark in worst.values())
    return [
        _matrix(e, (titles or {}).get(e, e), [m for m in worst.values() if m.cell.engine == e])
        for e in engines
    ]


def _matrix(engine: str, title: str, marks: Sequence[Mark]) -> Matrix:
    cases = tuple(sorted({mark.cell.case for mark in marks}))
    rows: dict[str, dict[str, tuple[Mark, ...]]] = {}
    for mark in sorted(marks, key=lambda m: (m.cell.submodel, m.cell.system)):
        row = rows.setdefault(mark.cell.submodel, {})
        row[mark.cell.case] = (*row.get(mark.cell.case, ()), mark)
    return Matrix(engine, title, cases, rows)


def _severity(mark: Mark) -> tuple[int, float]:
    """Return the place in the order of reading: worse verdicts, then larger errors, first."""
    check = mark.check
    used = abs(check.difference) / check.tolerance if check.tolerance > 0.0 else 0.0
    return SEVERITY.index(check.verdict), -used if math.isfinite(used) else 0.0


def matrix_markdown(
    checks: Sequence[Check], titles: Mapping[str, str] | None = None
) -> Iterator[str]:
    """Yield the lines of all matrices; nothing without cells."""
    for matrix in matrices([(check, "") for check in checks], titles):
        yield from (f"## Cases and submodels, {markdown_text(matrix.title)}", "")
        yield f"| submodel | {' | '.join(map(markdown_text, matrix.cases))} |"
        yield f"|---|{'---|' * len(matrix.cases)}"
        for name, row in matrix.rows.items():
            cells = (", ".join(m.text for m in row.get(case, ())) for case in matrix.cases)
            yield f"| {markdown_text(name)} | {' | '.join(cells)} |"
        yield ""
