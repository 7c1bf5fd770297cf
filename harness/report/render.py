"""Parts of pages in HTML and in Markdown: templates, tables, escaped text, rendered Markdown."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import resources
from numbers import Real
from typing import TYPE_CHECKING, Any, NamedTuple

from markupsafe import Markup, escape

from harness.report.text import number, one_line, printable
from harness.results.rows import Verdict

if TYPE_CHECKING:
    import pandas as pd
    from jinja2 import Environment
    from markdown_it.token import Token

VERDICTS = frozenset(map(str, Verdict))
# characters that Markdown takes for markup: within a line, and at its beginning a list or a heading
_MARKUP = re.compile(r"([\\`*\[\]|]|(?<![^\W_])_|_(?![^\W_])|^(?:[-+#](?= )|>))|^(\d+)(?=[.)] )")


class Badge(NamedTuple):
    """A cell of a table, or a part of one, in the colours of a verdict, with a link."""

    text: str
    verdict: str = ""
    address: str = ""


def html_page(template: str, **values: Any) -> Markup:
    """Return a page, or a part of one, from an HTML template of this room; values are escaped."""
    return Markup(_templates(html=True).get_template(template).render(**values))


def markdown_page(template: str, **values: Any) -> str:
    """Return a page from a Markdown template of this room, without runs of empty lines."""
    text = _templates(html=False).get_template(template).render(**values)
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def file(name: str) -> Markup:
    """Return a file of the templates as it is: the style and the script of pages."""
    text = resources.files("harness.report").joinpath("templates", name).read_text("utf-8")
    return Markup(text)


def markdown_text(text: object) -> str:
    """Return text so that Markdown shows it as it is: no markup, tag, table cell or mention."""
    line = one_line(str(text)).replace("&", "&amp;").replace("<", "&lt;")
    escaped = _MARKUP.sub(lambda m: f"{m[2]}\\" if m[2] else f"\\{m[0]}", line)
    return escaped.replace("@", "@\u200b")


@dataclass(frozen=True)
class Document:
    """A rendered Markdown text: the words of its first heading, and its HTML."""

    title: str
    body: Markup


def rendered(text: str) -> Markup:
    """Return Markdown as HTML; see :func:`document`."""
    return document(text).body


def document(text: str, link: Callable[[str], str] = str) -> Document:
    """Return Markdown as HTML; ``link`` returns the new address of a link, empty for none.

    Raw HTML is escaped, and an image of another host is left as its text. Headings have the ids
    that GitHub gives them. Tables scroll by themselves, and a cell that is the name of a verdict
    has its colours.
    """
    from markdown_it import MarkdownIt

    parser = MarkdownIt("commonmark", {"html": False}).enable("table")
    tokens = parser.parse(printable(text))
    headings, ids = [], Counter[str]()
    for token, following in zip(tokens, [*tokens[1:], None], strict=False):
        _follow_links(token.children or [], link)
        if token.type == "heading_open" and following is not None:
            words = "".join(child.content for child in following.children or ())
            headings.append(words)
            name = re.sub(r"[^\w\- ]", "", words.lower()).replace(" ", "-")
            ids[name] += 1
            token.attrs["id"] = name if ids[name] == 1 else f"{name}-{ids[name] - 1}"
    body = Markup(_tables_scroll(parser.renderer.render(tokens, parser.options, {})))
    return Document(headings[0] if headings else "", body)


def html_table(frame: pd.DataFrame, label: str = "") -> Markup:
    """Return a table as HTML: numbers to the right, verdicts and badges in their colours."""
    names, numeric, rows = _cells(frame)
    head = Markup("").join(
        Markup('<th scope="col"{}>{}</th>').format(_right(right), name)
        for name, right in zip(names, numeric, strict=True)
    )
    body = Markup("\n").join(
        Markup("<tr>{}</tr>").format(
            Markup("").join(
                Markup("<td{}>{}</td>").format(_right(right), _html_cell(cell))
                for cell, right in zip(row, numeric, strict=True)
            )
        )
        for row in rows
    )
    title = Markup(' aria-label="{}"').format(label) if label else Markup("")
    return Markup(
        '<div class="table" tabindex="0"><table{}>\n<thead><tr>{}</tr></thead>\n'
        "<tbody>{}</tbody></table></div>"
    ).format(title, head, body)


def markdown_table(frame: pd.DataFrame, most: int = 0) -> str:
    """Return a table as Markdown, its first ``most`` rows if given; text in it is escaped."""
    names, numeric, rows = _cells(frame)
    shown = rows[:most] if most else rows
    lines = [
        _markdown_row(map(markdown_text, names)),
        "|" + "|".join("--:" if right else "---" for right in numeric) + "|",
        *(_markdown_row(map(_markdown_cell, row)) for row in shown),
    ]
    rest = len(rows) - len(shown)
    return "\n".join(lines) + (f"\n\n{rest} more rows are left out." if rest else "")


def _follow_links(tokens: Sequence[Token], link: Callable[[str], str]) -> None:
    for token in tokens:
        name = {"link_open": "href", "image": "src"}.get(token.type, "")
        if not name:
            continue
        address = link(str(token.attrs[name]))
        external = token.type == "image" and "://" in address
        if external or (not address and token.type == "image"):
            token.type = "text"
        elif address:
            token.attrs[name] = address
        else:
            del token.attrs[name]


@cache
def _templates(*, html: bool) -> Environment:
    from jinja2 import Environment, PackageLoader, StrictUndefined

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
        "md": markdown_text, "number": number, "rendered": rendered,
        "html_table": html_table, "markdown_table": markdown_table, "line": one_line,
    }  # fmt: skip
    environment.globals |= {"file": file}
    return environment


def _without_controls(value: Any) -> Any:
    plain_text = isinstance(value, str) and not isinstance(value, Markup)
    return printable(value) if plain_text else value


def _cells(frame: pd.DataFrame) -> tuple[list[str], list[bool], list[list[Any]]]:
    """Return the heads of a table, which columns are of numbers, and the cells."""
    import pandas as pd

    plain = frame if isinstance(frame.index, pd.RangeIndex) else frame.reset_index()
    names = [str(name) for name in plain.columns]
    rows = [list(row) for row in plain.itertuples(index=False, name=None)]
    numeric = [
        any(_is_number(row[n]) for row in rows)
        and all(_is_number(row[n]) or _cell_text(row[n]) in ("", "-") for row in rows)
        for n in range(len(names))
    ]
    return names, numeric, rows


def _is_number(value: Any) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _cell_text(value: Any) -> str:
    if isinstance(value, Badge):
        return value.text
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if _is_number(value):
        return number(float(value))
    return one_line(str(value))


def _parts(value: Any) -> Iterator[Badge]:
    if isinstance(value, Badge):
        yield value
    elif isinstance(value, Sequence) and not isinstance(value, str):
        yield from (part for item in value for part in _parts(item))
    else:
        text = _cell_text(value)
        yield Badge(text, text if text in VERDICTS else "")


def _html_cell(value: Any) -> Markup:
    return Markup(" ").join(_html_badge(part) for part in _parts(value))


def _html_badge(part: Badge) -> Markup:
    text: Markup = escape(part.text)
    if part.verdict:
        look = part.verdict.replace(" ", "-")
        text = Markup('<span class="badge {}">{}</span>').format(look, part.text)
    return Markup('<a href="{}">{}</a>').format(part.address, text) if part.address else text


def _markdown_cell(value: Any) -> str:
    return ", ".join(_markdown_badge(part) for part in _parts(value))


def _markdown_badge(part: Badge) -> str:
    text = markdown_text(part.text)
    return f"[{text}]({part.address})" if part.address else text


def _markdown_row(cells: Iterator[str] | map[str]) -> str:
    return "| " + " | ".join(cells) + " |"


def _right(numeric: bool) -> Markup:
    return Markup(' class="n"') if numeric else Markup("")


def _tables_scroll(html: str) -> str:
    html = html.replace("<table>", '<div class="table" tabindex="0"><table>')
    html = html.replace("</table>", "</table></div>").replace("<pre>", '<pre tabindex="0">')
    html = re.sub(r"<th(?= |>)", '<th scope="col"', html)
    html = html.replace(' style="text-align:right"', ' class="n"')
    for verdict in VERDICTS:
        badge = f'<span class="badge {verdict.replace(" ", "-")}">{verdict}</span>'
        html = re.sub(f"(<td[^>]*>){verdict}</td>", rf"\1{badge}</td>", html)
    return html
