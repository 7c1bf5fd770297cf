"""Build a static site: the board of codes, releases and cases, committed reports, known defects.

Pages keep the paths of their files, ``.md`` as ``.html``, so that links hold. A file that a page
links to is copied. The site needs no server, no network and no script.
"""

from __future__ import annotations

import json
import posixpath
import shutil
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import pandas as pd

import harness
from harness.engines.output import release_of
from harness.errors import RequestError
from harness.files import check_replaceable, safe_path, whole_folder
from harness.report.content import Badge
from harness.report.page import defect_releases, defect_sentence
from harness.report.render import document, html_page, matrix, verdict_badges
from harness.results.compare import by_defect
from harness.results.rows import KEY, Verdict, table
from harness.store.runs import Run, read_rows, read_run

TITLE = "DEM codes against theory"
START, DEFECTS, LIST = "index.html", "defects.html", "site.json"
ACCEPTED_ROWS = "reports/accepted/*/*/rows.csv"
RELEASES_OF = "lammps"  # the engine whose releases are a board
LARGEST_FILE = 5_000_000  # bytes of a linked file that is copied
NAVIGATION = {"README.md": "README", "reports/README.md": "How to read a report"}
INDEX_FILES = ("README.md", "report.md", "report.html")  # of a folder that is linked to


def site(output: Path, runs: Sequence[Path] = (), *, project: Path | None = None) -> Site:
    """Build a site into a folder: the committed reports, and folders that ``verify`` wrote.

    ``project`` is the folder that has ``reports``, the checkout unless given. A site in the output
    folder is replaced. Raise RequestError for a folder with other files, for a folder that is not a
    run, and where there is nothing to show.
    """
    output, root = Path(output), project or Path(harness.__file__).parent.parent
    if output.is_dir() and any(output.iterdir()) and not (output / LIST).is_file():
        raise RequestError(f"--output {output}: has other files; name a new folder or a site")
    check_replaceable(output)
    folders = {safe_path(Path(folder).resolve().name): Path(folder) for folder in runs}
    if len(folders) != len(runs):
        raise RequestError("RUN: two folders of one name; rename one")
    for folder in folders.values():
        if output.resolve().is_relative_to(folder.resolve()):
            raise RequestError(f"--output {output}: lies in the run {folder}; name another folder")
    named_runs = {name: read_run(folder) for name, folder in folders.items()}
    if not (root / "reports").is_dir() and not folders:
        raise RequestError("RUN: there are no committed reports; name folders of `verify --output`")
    pages, rows = _Pages(root), _accepted_rows(root)
    pages.add_committed()
    pages.add(DEFECTS, "Known defects", _defects_html(pages, rows))
    pages.add(START, TITLE, _start_html(rows, named_runs, pages.reports))
    return _write(pages, folders, output)


@dataclass(frozen=True)
class Site:
    """A site: its folder, its pages with their sizes [bytes], other files.

    ``unlinked`` are page and address of each link whose file the site does not have.
    """

    folder: Path
    pages: Mapping[str, int]
    files: Sequence[str]
    unlinked: Sequence[tuple[str, str]]

    @property
    def start(self) -> Path:
        """Return the first page."""
        return self.folder / START

    def summary(self) -> dict[str, str]:
        """Return the first page, and the numbers of pages, files and broken links."""
        numbers = {"pages": self.pages, "other files": self.files,
                   "links without a file": self.unlinked}  # fmt: skip
        return {"site": str(self.start)} | {name: str(len(part)) for name, part in numbers.items()}

    def to_json(self) -> dict[str, Any]:
        """Return the same, JSON-ready, with each page and each link without a file."""
        return {
            "output": str(self.folder),
            "start": str(self.start),
            "pages": [{"page": page, "bytes": size} for page, size in self.pages.items()],
            "files": len(self.files),
            "unlinked": [{"page": page, "link": link} for page, link in self.unlinked],
        }


def _write(pages: _Pages, runs: Mapping[str, Path], output: Path) -> Site:
    sizes = {address: len(text.encode()) for address, text in sorted(pages.contents.items())}
    built = Site(output, sizes, sorted(pages.files), pages.unlinked)
    with whole_folder(output, replace=True) as folder:
        for name, source in runs.items():
            shutil.copytree(source, folder / "runs" / name, ignore_dangling_symlinks=True)
        for address in (*pages.files, *pages.contents):
            (folder / address).parent.mkdir(parents=True, exist_ok=True)
        for address, source in pages.files.items():
            shutil.copyfile(source, folder / address)
        for address, text in pages.contents.items():
            (folder / address).write_text(text, encoding="utf-8")
        (folder / LIST).write_text(json.dumps(built.to_json(), indent=1), encoding="utf-8")
    return built


# ---- committed pages and the files that they link to


@dataclass
class _Pages:
    """Pages and files of a site, by their address.

    ``reports`` are title, address and folder of the committed reports.
    """

    root: Path
    contents: dict[str, str] = field(default_factory=dict)
    files: dict[str, Path] = field(default_factory=dict)
    unlinked: list[tuple[str, str]] = field(default_factory=list)
    reports: list[tuple[str, str, str]] = field(default_factory=list)
    waiting: list[str] = field(default_factory=list)  # Markdown that a page links to

    def add_committed(self) -> None:
        """Add the README, the committed reports, and all that they link to."""
        texts = [self.root / "README.md", *sorted((self.root / "reports").rglob("*.md"))]
        names = [text.relative_to(self.root).as_posix() for text in texts if text.is_file()]
        self.waiting = [name for name in names if not name.startswith("reports/runs/")]
        while self.waiting:
            name = self.waiting.pop()
            if not {_page_of(name)} & {*self.contents, *self.files}:
                self._add_markdown(name)
        self.reports.sort(key=lambda report: report[1])

    def add(self, address: str, title: str, body: str) -> None:
        """Add a page with the navigation of the site."""
        links = [("Start", START), ("Known defects", DEFECTS)]
        links += [(n, _page_of(f)) for f, n in NAVIGATION.items() if (self.root / f).is_file()]
        self.contents[address] = html_page(
            "site.html.j2", title=title, body=body, navigation=links,
            up="../" * address.count("/"), here=address,
        )  # fmt: skip

    def _add_markdown(self, name: str) -> None:
        address, source = _page_of(name), self.root / name
        text, finished = source.read_text("utf-8"), source.with_suffix(".html")
        rendered = document(text, lambda link: self._address(name, link))
        title = rendered.title or source.stem
        if finished.is_file():  # a report has its own page, with the same links
            self.files[address] = finished
        else:
            self.add(address, title, rendered.body)
        if name.startswith("reports/"):
            self.reports.append((title, address, posixpath.dirname(address)))

    def _address(self, page: str, link: str) -> str:
        """Return the address of a link of a page in the site, empty where it leads to no file."""
        path, mark, place = link.partition("#")
        if "://" in link or link.startswith("mailto:") or not path:
            return link
        target = self._target(posixpath.join(posixpath.dirname(page), unquote(path)))
        if not target:
            folder = self.root / posixpath.dirname(page) / unquote(path)
            self.unlinked += [] if folder.is_dir() else [(page, link)]
            return ""
        relative = posixpath.relpath(target, posixpath.dirname(page) or ".")
        return quote(relative) + mark + place

    def _target(self, path: str) -> str:
        """Return the address of a file of the project, and add the file; empty where it lacks."""
        path = posixpath.normpath(path)
        source = self.root / path
        if source.is_dir():
            path = next((f"{path}/{n}" for n in INDEX_FILES if (source / n).is_file()), path)
            source = self.root / path
        if path.startswith("..") or not source.is_file():
            return ""
        if source.suffix == ".md":
            self.waiting.append(path)
            return _page_of(path)
        if source.stat().st_size > LARGEST_FILE:
            return ""
        self.files[path] = source
        return path


def _page_of(file: str) -> str:
    return file.removesuffix(".md") + ".html"


# ---- the start page


def _accepted_rows(root: Path) -> pd.DataFrame:
    """Return the rows of accepted runs, one for each key and version."""
    tables = [read_rows(file) for file in sorted(root.glob(ACCEPTED_ROWS))]
    rows = pd.concat(tables, ignore_index=True) if tables else table(())
    return rows.drop_duplicates([*KEY, "version"])


def _start_html(
    rows: pd.DataFrame, runs: Mapping[str, Run], reports: Sequence[tuple[str, str, str]]
) -> str:
    """Return the text of the start page: runs, boards, and committed reports."""
    boards = [] if rows.empty else _boards(rows)
    if runs:
        lines = [
            {
                "run": Badge(name, "", f"runs/{name}/report.html"),
                "outcome": run.headline,
                "verdicts": verdict_badges(run.rows["verdict"]),
                "started": run.meta.started[:16].replace("T", " "),
                "engines": ", ".join(run.meta.engines),
            }
            for name, run in runs.items()
        ]
        boards.insert(0, ("Runs", "Runs of this machine.", pd.DataFrame(lines)))
    links = [(Badge(title, "", address), folder) for title, address, folder in reports]
    frame = pd.DataFrame(links, columns=["report", "folder"])
    return html_page("start.html.j2", title=TITLE, boards=boards, reports=frame)


def _boards(rows: pd.DataFrame) -> list[tuple[str, str, pd.DataFrame]]:
    """Return title, caption and table of codes by cases and of releases by cases."""
    newest = rows.groupby("engine")["version"].transform(lambda all_: max(all_, key=release_of))
    codes = matrix(rows[rows["version"] == newest], "case", "engine")
    releases = matrix(rows[rows["engine"] == RELEASES_OF], "case", "version")
    releases = releases[sorted(releases.columns, key=lambda version: release_of(str(version)))]
    return [
        ("Codes by cases", "Accepted rows of the newest release of each code, by verdict.", codes),
        ("Releases by cases", f"Accepted rows of {RELEASES_OF}, by release and verdict.", releases),
    ]


# ---- known defects


def _defects_html(pages: _Pages, rows: pd.DataFrame) -> str:
    """Return the text of the page of known defects: causes, releases, and scripts as files."""
    file = pages.root / "inputs" / "known-defects.toml"
    defects = tomllib.loads(file.read_text("utf-8")).get("defect", {}) if file.is_file() else {}
    marked = by_defect(rows[rows["verdict"] == Verdict.KNOWN_DEFECT])
    numbers = marked.groupby(["version", "defect"]).size()
    versions = sorted(numbers.index.unique("version"), key=release_of)
    lines, details = [], []
    for name, defect in defects.items():
        line = {
            "defect": Badge(name, "", f"#{name}"),
            "engine": defect["engine"],
            "releases": defect_releases(defect) or "all known",
        }
        lines.append(line | {version: numbers.get((version, name), "") for version in versions})
        script = defect.get("script", "")  # and the test for the code's own suite
        paths = {path: pages.root / path for path in (script, _test_of(script)) if path}
        files = {path: source for path, source in paths.items() if source.is_file()}
        pages.files |= files
        scripts = [(path, source.read_text("utf-8")) for path, source in files.items()]
        details.append((name, defect_sentence(defect), defect, scripts))
    return html_page("defects.html.j2", table=pd.DataFrame(lines), defects=details)


def _test_of(script: str) -> str:
    return posixpath.join(posixpath.dirname(script), "test.yaml") if script else ""
