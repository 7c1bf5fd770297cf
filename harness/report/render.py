"""Write a page as Markdown and as HTML from one template.

A page is Markdown: what a template puts into it is escaped, its blocks (figures, tables, folds) are
written by ``blocks.md.j2`` or, for HTML, by :class:`HtmlBlocks`. The HTML page
is that Markdown, rendered by markdown-it, in a frame with style, navigation and scripts.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from markupsafe import Markup

from harness.report.gallery import Picture, data_uri, size
from harness.report.markdown import document
from harness.report.plain import markdown_text
from harness.report.templating import environment, markdown_environment

HELD = re.compile(r"<!--(\d+)-->")
"""What stands in the Markdown of a page for the HTML of a block."""
WIDE = 560
"""[pt] A figure wider than this takes both columns: beside another its words would be too small."""
TALL = 0.95
"""So does one at least this much of its width high."""


FRAME = {"who": "", "above": "", "sheet": None, "look": "", "columns": ()}
"""What stands about a page: who made it, a page above it, its style, a class, heads of its rows."""


def markdown_page(name: str, title: str, package: str = "", **values: Any) -> str:
    """Return a page as Markdown, from the template ``name``."""
    templates = markdown_environment(package, html=False)
    blocks = templates.get_template("blocks.md.j2").module
    text = templates.get_template(name).render(b=blocks, **values)
    text = f"# {markdown_text(title)}\n\n{text}"
    return re.sub(r"\n{3,}", "\n\n", text).strip() + "\n"


def html_page(
    name: str,
    title: str,
    *,
    package: str = "",
    frame: Mapping[str, Any] | None = None,
    **values: Any,
) -> str:
    """Return a page as HTML, from the template ``name`` of its Markdown.

    ``frame`` are the values of ``frame.html.j2``: what stands about the text. A page has style and
    script within it, so that it can be sent alone, or is linked to a ``sheet``.
    """
    blocks = HtmlBlocks(package, values)
    template = markdown_environment(package, html=True).get_template(name)
    text = template.render(b=blocks, **values)
    body = blocks.filled(document(text, html=True).body)
    return framed(title, body, blocks.headings, **(frame or {}))


def framed(title: str, body: str, headings: Sequence[tuple[str, str]], **frame: Any) -> str:
    """Return a page about a finished text, led by place and words of its headings."""
    about = {**FRAME, "name": title, **frame}
    page = environment().get_template("frame.html.j2")
    return page.render(title=title, body=body, headings=headings, **about)


class HtmlBlocks:
    """How a page of HTML writes its blocks: each is a macro of ``blocks.html.j2``.

    What they write is held back until markdown-it has rendered the text about it. ``headings`` are
    place and words of what the navigation leads to.
    """

    html = True

    def __init__(self, package: str, values: dict[str, Any]) -> None:
        self._environment, self._values = environment(package), values
        self.headings: list[tuple[str, str]] = []
        self._blocks: list[Markup] = []
        self._places: Counter[str] = Counter()
        self._macros = environment().get_template("blocks.html.j2").make_module(values)

    def __getattr__(self, name: str) -> Callable[..., Markup]:
        macro = getattr(self._macros, name)
        return lambda *values, **named: self._hold(macro(*values, **named))

    def heading(
        self, title: str, place: str = "", words: str = "", level: int = 2, verdict: str = ""
    ) -> Markup:
        """Write a heading; one with a ``place`` stands in the navigation, by its ``words``.

        A place that is taken, or that is ``section`` of many, is told apart by the title.
        """
        if place == "section":
            tail = re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")[:40]
            place = "-".join(filter(None, (place, tail)))
        if place:
            self._places[place] += 1
            again = self._places[place]
            place += f"-{again}" if again > 1 else ""
            self.headings.append((place, words or title))
        return self._hold(self._macros.heading_at(title, place, level, verdict))  # type: ignore[attr-defined]

    def checks(self, *values: Any) -> Markup:
        """Write the rows of all checks, which the page sorts and filters."""
        self.headings.append(("checks", "All rows"))
        return self._hold(self._macros.checks(*values))  # type: ignore[attr-defined]

    def figures(
        self, pictures: Sequence[Picture], failures: Sequence[str] = (), folder: str | None = None
    ) -> Markup:
        """Write figures, two beside each other where they are small enough.

        They stand in the page, or are files of a ``folder`` beside it.
        """
        macro = self._macros.gallery  # type: ignore[attr-defined]
        return self._hold(macro(figures(pictures, folder), failures))

    def include(self, name: str) -> Markup:
        """Write what a page alone has, by a template that is filled as the page is."""
        return self._hold(self._environment.get_template(name).render(**self._values))

    def _hold(self, html: str) -> Markup:
        self._blocks.append(Markup(html))
        return Markup(f"\n\n<!--{len(self._blocks) - 1}-->\n\n")

    def filled(self, html: str) -> Markup:
        """Return a rendered page with the blocks in their places."""
        return Markup(HELD.sub(lambda mark: self._blocks[int(mark[1])], html))


@dataclass(frozen=True)
class Figure:
    """A figure as a page shows it; ``look`` is ``wide`` or ``tall`` where it takes both columns."""

    name: str
    title: str
    caption: str
    uri: str
    width: int
    height: int
    look: str = ""


def figures(pictures: Sequence[Picture], folder: str | None = None) -> list[Figure]:
    """Return the figures as a page shows them: inside it, or files of a ``folder`` beside it.

    Two that need one column each stand beside each other where they follow each other; one that
    is left alone takes both, as the place beside it would stay empty.
    """
    placed: list[Figure] = []
    half = False
    for picture in pictures:
        uri = data_uri(picture.svg) if folder is None else f"{folder}{picture.name}.svg"
        width, height = map(round, size(picture.svg))
        look = "wide" if width > WIDE else "tall" if height >= TALL * width else ""
        if half and look:
            placed[-1] = replace(placed[-1], look="tall")
        half = not half and not look
        figure = Figure(picture.name, picture.title, picture.caption, uri, width, height, look)
        placed.append(figure)
    if half:
        placed[-1] = replace(placed[-1], look="tall")
    return placed
