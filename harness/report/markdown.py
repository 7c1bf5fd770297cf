"""Write the blocks of a page as Markdown, and render Markdown as the pages show it.

Text is escaped; of tables numbers stand to the right, and columns are aligned where a terminal
shows them.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

from harness.comparison.verdicts import Verdict
from harness.report.plain import markdown_text, one_line
from harness.report.sections import Label, Table, TableCell, column_look

if TYPE_CHECKING:
    from markdown_it.token import Token
    from markupsafe import Markup

    from harness.report.causes import Cause
    from harness.report.gallery import Picture, Reel

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
    """Return the lines of a table; text in it is escaped, but for two stars that make it bold.

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
    if text.startswith("**") and (end := text.find("**", 2)) > 0:
        rest = markdown_text(text[end + 2 :])
        gap = " " if text[end + 2 :].startswith(" ") else ""
        return f"**{markdown_text(text[2:end])}**{gap}{rest}"
    return markdown_text(text)


class MarkdownBlocks:
    """How Markdown writes the blocks of a page that is written once, for it and for HTML.

    A template calls them as those of :class:`harness.report.templating.HtmlBlocks`: what Markdown
    cannot show is left out, or its words alone are.
    """

    html = False

    def heading(self, title: str, *_: object, level: int = 2, verdict: str = "") -> Markup:
        """Write a heading, of a cause with its verdict."""
        told = f"{verdict}: {title}" if verdict else title
        return _block(f"{'#' * level} {markdown_text(told)}")

    def soft(self, text: str) -> Markup:
        """Write what a page says in a lighter colour."""
        return _block(markdown_text(text))

    def table(self, table: Table, *_: object, aligned: bool = False) -> Markup:
        """Write a table below its caption."""
        shown = table.without_empty_columns
        numeric = [n for n, look in enumerate(shown.looks) if look == "n"]
        lines = table_lines(shown.head, shown.rows, numeric, aligned=aligned)
        caption = [markdown_text(table.caption), ""] if table.caption else []
        return _block(*caption, *lines)

    def facts(self, pairs: Iterable[tuple[str, str]], *_: object) -> Markup:
        """Write names, each with what it is."""
        return _block(*(f"- {name}: {markdown_text(text)}" for name, text in pairs))

    def code(self, lines: Iterable[str], *_: object) -> Markup:
        """Write commands."""
        written = [one_line(line) for line in lines]
        return _block("```sh", *written, "```") if written else _text("")

    def figures(
        self, pictures: Iterable[Picture], failures: Iterable[str] = (), **_: object
    ) -> Markup:
        """Write figures, each below its title, and why others could not be drawn."""
        blocks = [markdown_text(failure) for failure in failures]
        for picture in pictures:
            title = markdown_text(picture.title)
            image = f"![{title}](figures/{picture.name}.svg)"
            blocks += [f"### {title}", image, markdown_text(picture.caption)]
        return _block("\n\n".join(blocks))

    def films(self, reels: Iterable[Reel], *_: object) -> Markup:
        """Write films, each as its poster, which leads to it."""
        blocks = []
        for reel in reels:
            title = markdown_text(reel.title)
            image = f"[![{title}](movies/{reel.name}.png)](movies/{reel.name}.gif)"
            blocks += [f"### {title}", image, markdown_text(reel.caption)]
        return _block("\n\n".join(blocks))

    def hero(self, headline: str, *values: Any) -> Markup:
        """Write the outcome in bold, and below it name, expectation and result of headlines."""
        lines = [f"{name}: expected {told}; {measured}" for name, told, measured in values[-1]]
        return _block(
            f"**{markdown_text(headline)}**", "", *(f"- {markdown_text(line)}" for line in lines)
        )

    def cause_rows(self, cause: Cause, *_: object) -> Markup:
        """Write how many rows a cause has, and in how many cells."""
        return _block(f"{cause.count[:1].upper()}{cause.count[1:]}.")

    def begin(self, *_: object, **__: object) -> Markup:
        """Leave out what a page alone has: what stands about blocks, and what is drawn."""
        return _text("\n\n")

    end = fold = sketch = cause_cells = include = begin


def _block(*lines: str) -> Markup:
    """Return lines as a block of their own, nothing where there are none."""
    text = "\n".join(lines)
    return _text(f"\n\n{text}\n\n" if text else "")


def _text(text: str) -> Markup:
    from markupsafe import Markup

    return Markup(text)  # escaped where it was made
