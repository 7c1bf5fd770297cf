"""Render the report as Markdown: the sections of the HTML page, with links to its figures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from harness.comparison.verdicts import Check
from harness.comparison.verification import Verification
from harness.report.cell_tables import cells_markdown, defects_markdown, stands_in_cell
from harness.report.gallery import Drawn, Picture, titles
from harness.report.matrix import matrix_markdown
from harness.report.plain import markdown_text
from harness.report.sections import Table
from harness.report.text import provenance, summary
from harness.report.verdict_summary import KINDS
from harness.shown import number

CHECKS = Table(
    "",
    "",
    ("check", "value", "expected", "difference", "uncertainty", "tolerance", "unit", "verdict"),
    (),
    frozenset(range(1, 6)),
)


def report_markdown(found: Verification, parts: Sequence[Drawn]) -> str:
    """Return the whole report; all text in it is escaped."""
    lines = ["# DEM verification report", "", *opening_markdown(found), ""]
    for kind, title in KINDS.items():
        lines += _kind(title, [check for check in found.checks if check.kind is kind])
    lines += matrix_markdown(found.checks, titles(parts))
    lines += cells_markdown(found.checks, titles(parts))
    lines += defects_markdown(found.defects)
    for part in parts:
        lines += section_markdown(part)
    untitled = [picture for part in parts if not part.section.title for picture in part.pictures]
    if untitled:
        lines += ["## Figures", ""]
    for picture in untitled:
        lines += _figure(picture)
    lines += ["## Provenance", ""]
    lines += [f"- {name}: {markdown_text(text)}" for name, text in provenance(found)]
    return "\n".join([*lines, ""])


def _kind(title: str, checks: Sequence[Check]) -> Iterator[str]:
    """Yield the rows of a kind but those that stand with the cells of the matrix."""
    rows = [_check(check) for check in checks if not stands_in_cell(check)]
    others = len(checks) - len(rows)
    if checks:
        yield from (f"## {title}", "")
    if others:
        yield from (f"{others} rows stand with the cells of the matrix, below.", "")
    if rows:
        yield from (*rows_markdown(CHECKS, rows), "")


def opening_markdown(found: Verification) -> list[str]:
    """Return the outcome kind by kind, and the headlines as a list."""
    outcome, counts, *told = map(markdown_text, summary(found))
    return [f"**{outcome}**", counts, "", *(f"- {line}" for line in told)]


def table_markdown(table: Table) -> list[str]:
    """Return a table, its caption before it."""
    return [markdown_text(table.caption), "", *rows_markdown(table, table.rows), ""]


def rows_markdown(table: Table, rows: Sequence[Sequence[str]]) -> list[str]:
    """Return rows under the head of a table; columns of numbers are set to the right."""
    marks = ["--:" if i in table.numeric else "---" for i in range(len(table.head))]
    cells = [[markdown_text(cell) for cell in row] for row in (table.head, *rows)]
    head, *body = (f"| {' | '.join(row)} |" for row in cells)
    return [head, f"|{'|'.join(marks)}|", *body]


def section_markdown(part: Drawn) -> Iterator[str]:
    """Yield the lines of a section: paragraphs, items, tables, figures."""
    section = part.section
    if section.title:
        yield from (f"## {markdown_text(section.title)}", "")
        for text in section.paragraphs:
            yield from (markdown_text(text), "")
        if section.items:
            yield from (*(f"- {markdown_text(text)}" for text in section.items), "")
        for table in section.tables:
            yield from table_markdown(table)
        for picture in part.pictures:
            yield from _figure(picture)
        for reel in part.reels:
            title = markdown_text(reel.title)
            image = f"[![{title}](movies/{reel.name}.png)](movies/{reel.name}.gif)"
            yield from (f"### {title}", "", image, "", markdown_text(reel.caption), "")
    for failure in part.failures:
        yield from (markdown_text(failure), "")


def _figure(picture: Picture) -> list[str]:
    title = markdown_text(picture.title)
    image = f"![{title}](figures/{picture.name}.svg)"
    return [f"### {title}", "", image, "", markdown_text(picture.caption), ""]


def _check(check: Check) -> list[str]:
    remarks = ": ".join(text for text in (check.triage, check.note) if text)
    remark = f" ({remarks})" if remarks else ""
    numbers = [number(check.value), number(check.expected), number(check.difference, 2)]
    numbers += [number(check.uncertainty, 2), number(check.tolerance, 2)]
    return [check.name + remark, *numbers, check.unit, str(check.verdict)]
