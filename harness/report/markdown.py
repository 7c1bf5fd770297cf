"""Write tables as Markdown, and render Markdown as the pages show it.

Text is escaped; numbers stand to the right, and columns are aligned where a terminal shows them.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

from harness.comparison.verdicts import Verdict
from harness.report.plain import markdown_text
from harness.report.sections import Label, Table, TableCell, column_look

if TYPE_CHECKING:
    from markdown_it.token import Token

BOLD = re.compile(r"(?<!\w)\\\*\\\*(\w[^*]*?)\\\*\\\*(?!\w)")
"""Of a table, two stars about words, as they are escaped."""

NOT_IN_A_PLACE = re.compile(r"[^\w\- ]")
"""What GitHub leaves out of a heading where it makes a place to link to."""


@dataclass(frozen=True)
class Document:
    """A Markdown text as HTML: its title, and the places and words of the headings below it."""

    title: str
    headings: tuple[tuple[str, str], ...]
    body: str


def document(text: str, pages: Mapping[str, str] | None = None, *, html: bool = False) -> Document:
    """Return Markdown as HTML, without the first heading, which is the title.

    Raw HTML is escaped unless ``html``. Headings have GitHub's places; tables scroll by themselves,
    and have the names of their columns in each cell, which a phone shows; verdicts are badges. A
    cell that is a name of ``pages`` links to its page.
    """
    from markdown_it import MarkdownIt

    parser = MarkdownIt("commonmark", {"html": html}).enable("table")
    tokens = parser.parse(text)
    title, headings, places = "", [], Counter[str]()
    for n, token in enumerate(tokens):
        if token.type == "heading_open":
            words = _words(tokens[n + 1])
            place = NOT_IN_A_PLACE.sub("", words.lower()).replace(" ", "-")
            places[place] += 1
            place += f"-{places[place] - 1}" if places[place] > 1 else ""
            if not html:
                token.attrs["id"] = place
            if token.tag == "h1" and not title:
                title = words
            elif token.tag == "h2":
                headings.append((place, words))
    if title:
        first = next(n for n, token in enumerate(tokens) if token.tag == "h1")
        del tokens[first : first + 3]
    _tables(tokens, pages or {})
    body: str = parser.renderer.render(tokens, parser.options, {})
    body = body.replace("<table", '<div class="table" tabindex="0"><table')
    body = body.replace("</table>", "</table></div>").replace("<pre>", '<pre tabindex="0">')
    return Document(title, tuple(headings), body)


def tables(text: str) -> dict[str, list[dict[str, str]]]:
    """Return the first table below each heading of a Markdown text, as rows by column."""
    from markdown_it import MarkdownIt

    rows: dict[str, list[dict[str, str]]] = {}
    heading, heads, cells = "", list[str](), list[str]()
    tokens = MarkdownIt("commonmark").enable("table").parse(text)
    for token, inline in zip(tokens, [*tokens[1:], tokens[-1]], strict=True):
        if token.type == "heading_open":
            heading = _words(inline)
        elif token.type == "table_open":
            heads = []
        elif token.type == "tr_open":
            cells = []
        elif token.type in ("th_open", "td_open"):
            cells.append(_words(inline))
        elif token.type == "thead_close":
            heads = [] if heading in rows else cells
            rows.setdefault(heading, [])
        elif token.type == "tr_close" and heads:
            rows[heading].append(dict(zip(heads, cells, strict=True)))
    return rows


def _words(inline: Token) -> str:
    """Return the words of a token without their markup."""
    return "".join(child.content for child in inline.children or ())


def _tables(tokens: Sequence[Token], pages: Mapping[str, str]) -> None:
    """Name the columns in each cell; mark numbers, sentences and verdicts."""
    heads: list[str] = []
    column = 0
    for token, inline in zip(tokens, [*tokens[1:], None], strict=True):
        if token.type == "table_open":
            heads, token.attrs["class"] = [], "wordy"
        elif token.type == "tr_open":
            column = 0
        elif token.type in ("th_open", "td_open") and inline is not None:
            right = "right" in str(token.attrs.pop("style", ""))
            words = _words(inline)
            if token.type == "th_open":
                heads.append(words)
                token.attrs["scope"] = "col"
            else:
                token.attrs["data-n"] = heads[column]
                _badge(inline, words, pages)
            look = "n" if right else column_look((words,)).replace("n", "")
            if look:
                token.attrs["class"] = look
            column += 1


def _badge(inline: Token, words: str, pages: Mapping[str, str]) -> None:
    """Make a cell that is a verdict a badge, and one that names a page a link."""
    children = inline.children or []
    if len(children) != 1 or children[0].type != "text":
        return
    if words in frozenset(Verdict):
        children[0].type = "html_inline"
        children[0].content = f'<span class="badge {words.replace(" ", "-")}">{words}</span>'
    elif words in pages:
        children[0].type = "html_inline"
        children[0].content = f'<a href="{escape(pages[words])}">{escape(words)}</a>'


def table_lines(
    head: Sequence[str],
    rows: Sequence[Sequence[TableCell]],
    numeric: Collection[int] = (),
    *,
    aligned: bool = False,
) -> list[str]:
    """Return the lines of a table; text in it is escaped, but for pairs of stars about words.

    Columns of ``numeric`` are set to the right. An ``aligned`` one has columns of one width, which
    a terminal shows as well, but for the last: what it says may be long.
    """
    cells = [[_cell(cell) for cell in row] for row in (head, *rows)]
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


def _cell(cell: TableCell) -> str:
    return _escaped(cell) if isinstance(cell, str) else ", ".join(map(_label, cell))


def _label(label: Label) -> str:
    """Return a label as a link; a row of a page, ``#``, is none in Markdown."""
    text = markdown_text(label.text)
    leads = label.address and not label.address.startswith("#")
    return f"[{text}]({label.address})" if leads else text


def _escaped(text: str) -> str:
    return BOLD.sub(r"**\1**", markdown_text(text))


def markdown_table(table: Table, *, aligned: bool = False) -> str:
    """Return a table, numbers to the right."""
    numeric = [n for n, look in enumerate(table.looks) if look == "n"]
    return "\n".join(table_lines(table.head, table.rows, numeric, aligned=aligned))
