"""Write the cells of the matrix as Markdown tables that a terminal shows, one a case and engine."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from harness.comparison.known_defects import KnownDefect, defect_of
from harness.comparison.verdicts import Check, Kind, Verdict
from harness.report.defects import address
from harness.report.matrix import Mark
from harness.report.plain import markdown_text
from harness.shown import in_words, number

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
NUMERIC = frozenset({3, 4, 6, 7, 8, 9})
BY = {Kind.ANALYTIC: "closed form", Kind.CROSS_CODE: "integration"}


def stands_in_cell(check: Check) -> bool:
    """Return whether a check is a value of a cell, and not something that must not change it."""
    return check.cell is not None and not check.cell.invariance


def cells_markdown(checks: Sequence[Check], titles: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines of the tables, by engine and case; nothing without cells.

    ``titles`` are how engines are written, by name.
    """
    tables: dict[tuple[str, str], list[Mark]] = {}
    for mark in (Mark(check, "") for check in checks if stands_in_cell(check)):
        tables.setdefault((mark.cell.engine, mark.cell.case), []).append(mark)
    for (engine, case), marks in tables.items():
        name = markdown_text(f"{case}, {titles.get(engine, engine)}")
        yield from (f"### Values of {name}", "", *_table(marks), "")


def defects_markdown(defects: Sequence[tuple[KnownDefect, str]]) -> Iterator[str]:
    """Yield the list of known defects that checks are marked with, each with its script."""
    if defects:
        yield from ("## Known defects", "")
        for one, script in defects:
            told = f"- {markdown_text(one.name)}: {markdown_text(one.cause)}"
            upstream = f"; upstream: {markdown_text(one.upstream)}" if one.upstream else ""
            shown = f"; [script]({address(one)})" if script else ""
            yield f"{told}{upstream}{shown}"
        yield ""


def _table(marks: Sequence[Mark]) -> list[str]:
    """Return a table whose columns are of one width, but for the last one."""
    rows = [[markdown_text(text) for text in row] for row in _rows(marks)]
    widths = [max(map(len, column)) for column in zip(HEAD, *rows, strict=True)]
    widths[-1] = len(HEAD[-1])  # what it says may be long
    rule = ["-" * (w - 1) + ":" if n in NUMERIC else "-" * w for n, w in enumerate(widths)]
    lines = [_line(row, widths) for row in (HEAD, rule, *rows)]
    return [line.rstrip() for line in lines]


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    *cells, last = [
        f"{text:>{width}}" if n in NUMERIC else f"{text:<{width}}"
        for n, (text, width) in enumerate(zip(row, widths, strict=True))
    ]
    return f"| {' | '.join(cells)} | {last.rstrip()} |"


def _rows(marks: Sequence[Mark]) -> Iterator[tuple[str, ...]]:
    """Yield a row for each value; one for all systems of a submodel that cannot be stated."""
    said: set[tuple[str, str]] = set()
    for mark in marks:
        check, cell = mark.check, mark.cell
        if not mark.quantity:
            words = _verdict(check)
            if (cell.submodel, words) not in said:
                said.add((cell.submodel, words))
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
    told = defect_of(check)
    if not told and check.verdict in (Verdict.FAIL, Verdict.NOT_TESTED):
        told = check.note or check.triage
    return f"{check.verdict}: {told}" if told else str(check.verdict)
