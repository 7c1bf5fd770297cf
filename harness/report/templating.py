"""Load the templates of the pages, with their filters for numbers and text."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import cache, partial
from importlib import resources
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from harness.report.markdown import markdown_table
from harness.report.plain import markdown_text, one_line, printable, safe_path
from harness.report.text import details, explained, happened, triage
from harness.shown import in_words
from harness.shown import number as number

if TYPE_CHECKING:
    from jinja2 import Environment

    from harness.report.sections import Table

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
