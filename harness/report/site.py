"""Make the pages of a static site: Markdown and finished pages under one navigation.

The site mirrors the folders that its pages come from, so that links stay as they are, but for
Markdown, which becomes a page. It asks for nothing from a network, works from a disk and below any
address, and is read without JavaScript.
"""

from __future__ import annotations

import posixpath
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from html import escape, unescape
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

from markupsafe import Markup

from harness.report.markdown import document
from harness.report.render import framed, html_page
from harness.report.templating import style

STYLE = "style.css"
FRAME: Mapping[str, Any] = {"sheet": "", "look": "document"}
"""What stands about a page; the site adds its style and its navigation."""
SHEET = '<link rel="stylesheet" href="{}">\n</head>'
START = "index.html"
LINK = re.compile(r'\b(href|src|data-gif)="([^"#]*)(#[^"]*)?"')
ANCHOR = r'<a\b[^>]*\bhref="{}"[^>]*>(.*?)</a>'
ELSEWHERE = re.compile(r"[a-z][a-z0-9+.-]*:|//")
"""How an address begins that is none of the site: of another host, of mail, data."""

LOADED = ".js"
"""What ends the name of a script beside a film, which a page loads where the film is started."""


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
        html = html_page(name, title, frame=FRAME, up=_up(address), **values)
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
            self._add_page(address, framed(title, body, text.headings, **FRAME))
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
                wanted.extend([path, *([path + LOADED] if name == "data-gif" else [])])
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
