"""Parts of pages in HTML and in Markdown: templates, tables, escaped text, rendered Markdown."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from importlib import resources
from itertools import pairwise
from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import quote

import pandas as pd
from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup

from harness.report.content import Badge, number, one_line, printable
from harness.results.rows import Verdict

if TYPE_CHECKING:
    from markdown_it.token import Token

ORDER = {str(verdict): place for place, verdict in enumerate(Verdict)}  # the gravest first
# characters that Markdown takes for markup: within a line, and at its beginning a list or a heading
MARKUP = re.compile(r"([\\`*\[\]|]|(?<![^\W_])_|_(?![^\W_])|^(?:[-+#](?= )|>))|^(\d+)(?=[.)] )")
TABLE_MARKUP = {
    "<table>": '<div class="table" tabindex="0"><table>',
    "</table>": "</table></div>",
    "<pre>": '<pre tabindex="0">',
    ' style="text-align:right"': ' class="n"',
    "<th ": '<th scope="col" ',
    "<th>": '<th scope="col">',
}


def html_page(name: str, /, **values: Any) -> Markup:
    """Return a page, or a part of one, from an HTML template; values are escaped."""
    return Markup(template(name, html=True).render(**values))


def markdown_page(name: str, /, **values: Any) -> str:
    """Return a page from a Markdown template, without runs of empty lines."""
    text = template(name, html=False).render(**values)
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def markdown_text(text: object) -> str:
    """Return text so that Markdown shows it as it is: no markup, tag, table cell or mention."""
    line = one_line(str(text)).replace("&", "&amp;").replace("<", "&lt;")
    escaped = MARKUP.sub(lambda m: f"{m[2]}\\" if m[2] else f"\\{m[0]}", line)
    return escaped.replace("@", "@\u200b")


def svg_uri(svg: str) -> Markup:
    """Return an SVG as a data URI, percent-encoded: a quarter shorter than base64.

    It needs no escapes in an attribute: double quotes and ampersands are encoded.
    """
    text = quote(svg, safe=" /:;=,'()!*+-._~?@$<>{}\n").replace("\n", " ")
    return Markup(f"data:image/svg+xml,{text}")


def template(name: str, *, html: bool) -> Template:
    """Return a compiled template, which escapes values for ``html``."""
    return _templates(html=html).get_template(name)


@cache
def _templates(*, html: bool) -> Environment:
    environment = Environment(
        loader=PackageLoader("harness.report", "templates"),
        autoescape=html,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=_without_controls,
    )
    environment.filters |= {
        "md": markdown_text, "rendered": lambda text: document(text).body, "uri": svg_uri,
        "html_table": html_table, "markdown_table": markdown_table,
    }  # fmt: skip
    environment.globals["file"] = _template_file
    return environment


def _without_controls(value: Any) -> Any:
    plain_text = isinstance(value, str) and not isinstance(value, Markup)
    return printable(value) if plain_text else value


def _template_file(name: str) -> Markup:
    return Markup(resources.files("harness.report").joinpath("templates", name).read_text("utf-8"))


# ---- tables


def matrix(rows: pd.DataFrame, index: str, columns: str) -> pd.DataFrame:
    """Return how many rows have each verdict, in cells of :class:`Badge`, the gravest first."""
    cells = rows.groupby([index, columns], sort=True)["verdict"].agg(verdict_badges)
    return cells.unstack(columns).astype(object).where(lambda frame: frame.notna(), "")


def verdict_badges(verdicts: Iterable[str]) -> tuple[Badge, ...]:
    """Return how many of the verdicts there are of each, the gravest first."""
    numbers = Counter(verdicts)
    return tuple(Badge(f"{numbers[name]} {name}", name) for name in ORDER if name in numbers)


def html_table(frame: pd.DataFrame, label: str = "") -> Markup:
    """Return a table as HTML: numbers to the right, verdicts and badges in their colours."""
    return html_page("table.html.j2", grid=_grid(frame), label=label)


def markdown_table(frame: pd.DataFrame, most: int = 0) -> str:
    """Return a table as Markdown, its first ``most`` rows if given; text in it is escaped."""
    grid = _grid(frame)
    rows = grid.rows[:most] if most else grid.rows
    texts = [[", ".join(markdown_text(part.text) for part in cell) for cell in row] for row in rows]
    lines = [
        _markdown_row([markdown_text(name) for name in grid.names]),
        "|" + "|".join("--:" if right else "---" for right in grid.numeric) + "|",
        *map(_markdown_row, texts),
    ]
    rest = len(grid.rows) - len(rows)
    return "\n".join(lines) + (f"\n\n{rest} more rows are left out." if rest else "")


class _Grid(NamedTuple):
    """The texts of a table: names of columns, which of them are numbers, badges of each cell."""

    names: list[str]
    numeric: list[bool]
    rows: list[list[list[Badge]]]


def _grid(frame: pd.DataFrame) -> _Grid:
    plain = frame if isinstance(frame.index, pd.RangeIndex) else frame.reset_index()
    rows = [list(row) for row in plain.itertuples(index=False, name=None)]
    badges = [[list(_badges(value)) for value in row] for row in rows]
    numeric = [_is_numeric([row[n] for row in rows]) for n in range(plain.shape[1])]
    return _Grid([str(name) for name in plain.columns], numeric, badges)


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _is_numeric(column: Sequence[Any]) -> bool:
    others = [value for value in column if not _is_number(value)]
    return len(others) < len(column) and all(v is None or v in ("", "-") for v in others)


def _badges(value: Any) -> Iterator[Badge]:
    if isinstance(value, Badge):
        yield value
    elif isinstance(value, Sequence) and not isinstance(value, str):
        yield from (badge for item in value for badge in _badges(item))
    elif _is_number(value):
        yield Badge("" if math.isnan(value) else number(float(value)))
    else:
        text = "" if value is None else one_line(str(value))
        yield Badge(text, text if text in ORDER else "")


def _markdown_row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cells) + " |"


# ---- Markdown to HTML


class Document(NamedTuple):
    """A rendered Markdown text: the words of its first heading, and its HTML."""

    title: str
    body: Markup


def document(text: str, link: Callable[[str], str] = str) -> Document:
    """Return Markdown as HTML; ``link`` returns the new address of a link, empty for none.

    Raw HTML is escaped, and an image of another host becomes its text. Headings have the ids
    that GitHub gives them. Tables scroll by themselves, and a cell that is the name of a verdict
    has its colours.
    """
    from markdown_it import MarkdownIt  # most pages have no text

    parser = MarkdownIt("commonmark", {"html": False}).enable("table")
    tokens = parser.parse(printable(text))
    headings, ids = [], Counter[str]()
    for token, following in pairwise(tokens):
        for child in following.children or ():
            _follow_link(child, link)
        if token.type == "heading_open":
            words = "".join(child.content for child in following.children or ())
            headings.append(words)
            name = re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-")
            ids[name] += 1
            token.attrs["id"] = name if ids[name] == 1 else f"{name}-{ids[name] - 1}"
    html = parser.renderer.render(tokens, parser.options, {})
    for old, new in TABLE_MARKUP.items():
        html = html.replace(old, new)
    for verdict in ORDER:
        badge = f'<span class="badge {verdict.replace(" ", "-")}">{verdict}</span>'
        html = re.sub(f"(<td[^>]*>){verdict}</td>", rf"\1{badge}</td>", html)
    return Document(headings[0] if headings else "", Markup(html))


def _follow_link(token: Token, link: Callable[[str], str]) -> None:
    name = {"link_open": "href", "image": "src"}.get(token.type)
    if name is None:
        return
    address = link(str(token.attrs[name]))
    if token.type == "image" and (not address or "://" in address):
        token.type = "text"
    elif address:
        token.attrs[name] = address
    else:
        del token.attrs[name]
