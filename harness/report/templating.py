"""Load the templates of the pages, with their filters for numbers and text."""

from __future__ import annotations

import math
import re
from functools import cache
from importlib import resources
from typing import TYPE_CHECKING

from harness.report.plain import printable, safe_path
from harness.report.text import details, explained, happened, triage
from harness.shown import in_words
from harness.shown import number as number

if TYPE_CHECKING:
    from jinja2 import Environment

CODE = re.compile(r"`([^`]+)`")
TAIL = 12_000
"""Characters of a log that a page shows; the file beside it has the whole."""


@cache
def environment(*packages: str) -> Environment:
    """Return the templates, with style and script to be put inside the page.

    Templates of ``packages`` are found too, in a folder ``templates`` of each.
    """
    from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
    from markupsafe import Markup, escape

    made = Environment(
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        loader=ChoiceLoader([PackageLoader(name) for name in ("harness.report", *packages)]),
    )
    made.filters |= {"number": number, "tail": tail, "safe_path": safe_path, "words": in_words}
    made.filters |= {"triage": triage, "details": details, "explained": explained}
    made.filters["happened"] = happened
    made.filters["backticks"] = lambda text: Markup(CODE.sub(r"<code>\1</code>", str(escape(text))))
    made.globals["missing"] = math.nan
    made.globals["file"] = lambda name: Markup(_template(name))
    return made


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
