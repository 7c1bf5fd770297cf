"""Write tables as Markdown: escaped, numbers to the right, aligned where a terminal shows them."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from harness.report.plain import markdown_text


def table_lines(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    numeric: Collection[int] = (),
    *,
    aligned: bool = False,
) -> list[str]:
    """Return the lines of a table; text in it is escaped, but for two stars that make it bold.

    Columns of ``numeric`` are set to the right. An ``aligned`` one has columns of one width, which
    a terminal shows as well, but for the last: what it says may be long.
    """
    cells = [[_cell(text) for text in row] for row in (head, *rows)]
    widths = [max(map(len, column)) if aligned else 3 for column in zip(*cells, strict=True)]
    widths[-1] = len(cells[0][-1]) if aligned else 3
    rule = ["-" * (w - 1) + ":" if n in numeric else "-" * w for n, w in enumerate(widths)]
    if not aligned:
        return [_line(cells[0]), f"|{'|'.join(rule)}|", *map(_line, cells[1:])]
    padded = [
        [
            text.rjust(width) if n in numeric else text.ljust(width)
            for n, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        for row in (cells[0], rule, *cells[1:])
    ]
    return [_line([*row[:-1], row[-1].rstrip()]) for row in padded]


def _line(row: Sequence[str]) -> str:
    return f"| {' | '.join(row)} |"


def _cell(text: str) -> str:
    if text.startswith("**") and (end := text.find("**", 2)) > 0:
        rest = markdown_text(text[end + 2 :])
        gap = " " if text[end + 2 :].startswith(" ") else ""
        return f"**{markdown_text(text[2:end])}**{gap}{rest}"
    return markdown_text(text)
