"""Load the templates of pages, write tables as Markdown, and render Markdown as the pages show it.

Text is escaped; numbers stand to the right, and columns are aligned where a terminal shows them.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from html import escape as html_escape
from importlib import resources
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from harness.comparison.verdicts import Verdict
from harness.report.plain import markdown_text, one_line, printable, safe_path
from harness.report.sections import Label, Table, TableCell, column_look
from harness.report.text import details, explained, happened, triage
from harness.shown import in_words
from harness.shown import number as number

if TYPE_CHECKING:
    from jinja2 import Environment
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
        children[0].content = f'<a href="{html_escape(pages[words])}">{html_escape(words)}</a>'


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


CODE = re.compile(r"`([^`]+)`")
TAIL = 12_000
"""Characters of a log that a page shows; the file beside it has the whole."""


@cache
def environment(package: str = "") -> Environment:
    """Return the templates of HTML, with those of a ``package`` in its folder ``templates``."""
    return _environment(package, None)


@cache
def markdown_environment(package: str = "", *, html: bool) -> Environment:
    """Return the templates of Markdown, which is made for a page of HTML or for itself."""
    return _environment(package, partial(_in_markdown, html=html))


def _environment(package: str, finalize: Callable[[Any], Any] | None) -> Environment:
    from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

    packages = ["harness.report", *filter(None, (package,))]
    templates = Environment(
        autoescape=True,
        finalize=finalize,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=ChoiceLoader([PackageLoader(name) for name in packages]),
    )
    templates.filters |= {"number": number, "tail": tail, "safe_path": safe_path, "words": in_words}
    templates.filters |= {"triage": triage, "details": details, "explained": explained}
    templates.filters["happened"] = happened
    templates.filters["backticks"] = _code_spans if finalize else _code_elements
    templates.filters |= {"lines": _table_lines, "raw": Markup, "verbatim": _verbatim}
    templates.globals |= {"missing": math.nan, "gap": Markup("\n\n")}
    templates.globals["file"] = lambda name: Markup(_template(name))
    return templates


def _table_lines(table: Table, aligned: bool) -> Markup:
    return Markup(markdown_table(table, aligned=aligned))


def _verbatim(text: str) -> Markup:
    return Markup(one_line(text))


def _code_elements(text: str) -> Markup:
    return Markup(CODE.sub(r"<code>\1</code>", str(escape(text))))


def _code_spans(text: str) -> Markup:
    parts = CODE.split(text)  # by turns text and code
    escaped = (
        f"`{part}`" if n % 2 else _in_markdown(part, html=True) for n, part in enumerate(parts)
    )
    return Markup("".join(escaped))


def _in_markdown(value: Any, *, html: bool) -> Any:
    if isinstance(value, Markup):
        return value
    text = str(value)
    before, after = (" " if text.strip() and end == " " else "" for end in (text[:1], text[-1:]))
    escaped = f"{before}{markdown_text(text)}{after}"
    # what markdown-it renders mentions nobody
    return Markup(escaped.replace("@\u200b", "@") if html else escaped)


def tail(text: str) -> str:
    """Return the head and the end of a log that is too long for a page; printable."""
    text = printable(text)
    if len(text) <= TAIL:
        return text
    head = text[:600].rpartition("\n")[0]
    end = text[-(TAIL - 600) :].partition("\n")[2]
    return (
        f"{head}\n\n[ ... {len(text) - len(head) - len(end)} characters, in the file ... ]\n\n{end}"
    )


def style() -> str:
    """Return the style of the pages."""
    return _template("style.css")


def _template(name: str) -> str:
    return resources.files("harness.report").joinpath("templates", name).read_text("utf-8")
