"""Write a page as Markdown and as HTML from one template, and join pages to a static site.

A page is Markdown: what a template puts into it is escaped, its blocks (figures, tables, folds) are
written by ``blocks.md.j2`` or, for HTML, by :class:`HtmlBlocks`. The HTML page
is that Markdown, rendered by markdown-it, in a frame with style, navigation and scripts.

A site mirrors the folders that its pages come from, so that links stay as they are, but for
Markdown, which becomes a page. It asks for nothing from a network, works from a disk and below any
address, and is read without JavaScript.
"""

from __future__ import annotations

import posixpath
import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from html import escape, unescape
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

from markupsafe import Markup

from harness.report.gallery import Picture, data_uri, size
from harness.report.markdown import document, environment, markdown_environment, style
from harness.report.plain import markdown_text

HELD = re.compile(r"<!--(\d+)-->")
"""What stands in the Markdown of a page for the HTML of a block."""
WIDE = 560
"""[pt] A figure wider than this takes both columns: beside another its words would be too small."""
TALL = 0.95
"""So does one at least this much of its width high."""


FRAME = {"who": "", "sheet": None, "look": "", "columns": ()}
"""What stands about a page: who made it, its style, a class, heads of its rows."""


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


STYLE = "style.css"
SITE_FRAME: Mapping[str, Any] = {"sheet": "", "look": "document"}
"""What stands about a page; the site adds its style and its navigation."""
SHEET = '<link rel="stylesheet" href="{}">\n</head>'
START = "index.html"
LINK = re.compile(r'\b(href|src)="([^"#]*)(#[^"]*)?"')
ANCHOR = r'<a\b[^>]*\bhref="{}"[^>]*>(.*?)</a>'
ELSEWHERE = re.compile(r"[a-z][a-z0-9+.-]*:|//")
"""How an address begins that is none of the site: of another host, of mail, data."""


@dataclass
class Site:
    """The pages of a site by their addresses, and the files beside them.

    ``root`` is the folder that the site mirrors, ``navigation`` has title and address of what every
    page leads to. ``planned`` are addresses of pages that have no file below the root, ``moved``
    the pages that links to some files lead to, ``texts`` files that are written with the site,
    ``named`` the pages of names that stand alone in a cell of a table.
    ``unlinked`` are links of pages to what is not below the root, which are left as their words.
    """

    root: Path
    navigation: Sequence[tuple[str, str]]
    planned: Collection[str] = ()
    moved: Mapping[str, str] = field(default_factory=dict)
    texts: Mapping[str, str] = field(default_factory=dict)
    named: Mapping[str, str] = field(default_factory=dict)
    pages: dict[str, str] = field(default_factory=dict, init=False)
    files: dict[str, Path] = field(default_factory=dict, init=False)
    unlinked: list[tuple[str, str]] = field(default_factory=list, init=False)

    def add_template(self, address: str, name: str, title: str, **values: Any) -> None:
        """Add a page of a template, with the files of the root that it links to."""
        html = html_page(name, title, frame=SITE_FRAME, up=_up(address), **values)
        self._add_page(address, html)

    def add_file(self, path: str) -> None:
        """Add a file of the root, as a page where it is one, with all that it links to.

        Markdown with a finished page beside it becomes that page.
        """
        address = self._address(path)
        if not address or address in {**self.pages, **self.files, **self.texts}:
            return
        source = self._source(path)
        if source.suffix == ".md":
            pages = {name: _up(address) + page for name, page in self.named.items()}
            text = document(source.read_text("utf-8"), pages)
            title, body = text.title, Markup(text.body)
            self._add_page(address, framed(title, body, text.headings, **SITE_FRAME))
        elif source.suffix == ".html":
            self._add_page(address, source.read_text("utf-8"))
        else:
            self.files[address] = source

    def add_folder(self, folder: Path, address: str) -> None:
        """Add a finished folder at an address: its pages get the navigation, its files stay."""
        for path in sorted(folder.rglob("*")):
            inside = path.resolve().is_relative_to(folder.resolve())
            if path.is_file() and inside:
                place = f"{address}/{path.relative_to(folder).as_posix()}"
                if path.suffix == ".html":
                    self.pages[place] = self.framed(path.read_text("utf-8", "replace"), place)
                else:
                    self.files[place] = path

    def framed(self, html: str, address: str) -> str:
        """Return a finished page with navigation and style of the site."""
        html = html.replace("</head>", SHEET.format(_up(address) + STYLE), 1)
        return re.sub(r"<body[^>]*>", lambda body: body[0] + self._header(address), html, count=1)

    def write(self, folder: Path) -> None:
        """Write pages, files and style into a folder, which is made."""
        for address, text in {**self.pages, **self.texts, STYLE: style()}.items():
            (folder / address).parent.mkdir(parents=True, exist_ok=True)
            (folder / address).write_text(text, encoding="utf-8", errors="replace")
        for address, source in self.files.items():
            (folder / address).parent.mkdir(parents=True, exist_ok=True)
            (folder / address).write_bytes(source.read_bytes())

    def _header(self, address: str) -> str:
        """Return the navigation as a page at an address has it."""
        current = ' aria-current="page"'
        links = "".join(
            f'<a href="{quote(_up(address) + target)}"{current if target == address else ""}>'
            f"{escape(title)}</a>"
            for title, target in self.navigation
        )
        return f'\n<header class="site"><nav aria-label="Site">{links}</nav></header>'

    def _add_page(self, address: str, html: str) -> None:
        """Keep a page, its links led to pages of the site, and add what it links to."""
        self.pages[address] = ""  # pages may link to one another
        folder = posixpath.dirname(address)
        lost: list[str] = []
        wanted: list[str] = []

        def led(link: re.Match[str]) -> str:
            name, target, place = link[1], unescape(link[2]), link[3] or ""
            if not target or ELSEWHERE.match(target):
                return link[0]
            path = posixpath.normpath(posixpath.join(folder, unquote(target)))
            at = self.moved.get(path, "") if name == "href" else ""
            if not at or at == address:
                at = path if path in self.planned else self._address(path)
            if at and at not in self.planned:
                wanted.append(path)
            if not at:
                lost.append(link[2])
                return link[0]
            return f'{name}="{quote(posixpath.relpath(at, folder or "."))}{place}"'

        html = LINK.sub(led, html)
        for target in lost:
            self.unlinked.append((address, target))
            html = re.sub(ANCHOR.format(re.escape(target)), r"\1", html, flags=re.DOTALL)
        self.pages[address] = self.framed(html, address)
        for path in wanted:
            self.add_file(path)

    def _source(self, path: str) -> Path:
        """Return the file that a page or file of the site comes from."""
        source = self.root / path
        if source.is_dir():
            return source / "README.md"
        page = source.with_suffix(".html")
        return page if source.suffix == ".md" and page.is_file() else source

    def _address(self, path: str) -> str:
        """Return where a file of the root stands in the site; empty for what is not there."""
        source = self._source(path)
        if path.startswith("..") or not source.is_file():
            return ""
        if source.suffix != ".md":
            return source.relative_to(self.root).as_posix()
        page = source.with_name(START) if source.name == "README.md" else source
        return page.with_suffix(".html").relative_to(self.root).as_posix()


def _up(address: str) -> str:
    """Return the way from a page to the start of the site."""
    return "../" * address.count("/")
