"""Build a static site: the board of codes, releases and cases, committed reports, known defects.

Pages keep the paths of their files, ``.md`` as ``.html``, so that links hold. A file that a page
links to is copied. The site needs no server, no network and no script.
"""

from __future__ import annotations

import json
import posixpath
import shutil
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from urllib.parse import quote, unquote

import pandas as pd

import harness
from harness.engines.output import release_of
from harness.errors import RequestError
from harness.files import check_writable, safe_path, whole_folder
from harness.report.content import Badge
from harness.report.page import defect_releases, defect_sentence
from harness.report.render import document, html_page, matrix, verdict_badges
from harness.results.rows import KEY, Verdict, table
from harness.store.runs import Run, read_rows, read_run

TITLE = "DEM codes against theory"
START, DEFECTS, LIST = "index.html", "defects.html", "site.json"
ACCEPTED_ROWS = "reports/accepted/*/*/rows.csv"
RELEASES_OF = "lammps"  # the engine whose releases are a board
LARGEST_FILE = 5_000_000  # bytes of a linked file that is copied
NAVIGATION = {"README.md": "README", "reports/README.md": "How to read a report"}
INDEX_FILES = ("README.md", "report.md", "report.html")  # of a folder that is linked to


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


def site(output: Path, runs: Sequence[Path] = (), *, project: Path | None = None) -> Site:
    """Build a site into a folder: the committed reports, and folders that ``verify`` wrote.

    ``project`` is the folder that has ``reports``, the checkout unless given. A site in the output
    folder is replaced. Raise RequestError for a folder with other files, for a folder that is not a
    run, and where there is nothing to show.
    """
    output = Path(output)
    _check_output(output)
    root = project or Path(harness.__file__).parent.parent
    folders = {safe_path(Path(folder).resolve().name): Path(folder) for folder in runs}
    if len(folders) != len(runs):
        raise RequestError("RUN: two folders of one name; rename one")
    named_runs = {name: read_run(folder) for name, folder in folders.items()}
    if not (root / "reports").is_dir() and not folders:
        raise RequestError("RUN: there are no committed reports; name folders of `verify --output`")
    pages, rows = _Pages(root), _accepted_rows(root)
    pages.add_committed()
    defects = _defects(root)
    pages.add_page(DEFECTS, "Known defects", _defects_html(root, defects, rows))
    for defect in defects.values():
        pages.files |= {path: root / path for path in _defect_files(root, defect)}
    pages.add_page(START, TITLE, _start_html(rows, named_runs, pages.reports))
    return _write(pages, folders, output)


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

    def add_committed(self) -> None:
        """Add the README, the committed reports, and all that they link to."""
        sources = [self.root / "README.md", *sorted((self.root / "reports").rglob("*.md"))]
        runs = self.root / "reports" / "runs"
        self._waiting = [s for s in sources if s.is_file() and not s.is_relative_to(runs)]
        while self._waiting:
            self._add_markdown(self._waiting.pop())
        self.reports.sort(key=lambda report: report[1])

    def add_page(self, address: str, title: str, body: str) -> None:
        """Add a page with the navigation of the site."""
        links = [("Start", START), ("Known defects", DEFECTS)]
        links += [(n, _page_of(f)) for f, n in NAVIGATION.items() if (self.root / f).is_file()]
        self.contents[address] = html_page(
            "site.html.j2", title=title, body=body, navigation=links,
            up="../" * address.count("/"), here=address,
        )  # fmt: skip

    def _add_markdown(self, source: Path) -> None:
        page = source.relative_to(self.root).as_posix()
        address, text = _page_of(page), source.read_text(encoding="utf-8")
        if address in self.contents or address in self.files:
            return
        finished = source.with_suffix(".html")
        if finished.is_file():  # a report has its own page
            self.files[address] = finished
            title = document(text).title
        else:
            self.contents[address] = ""  # so that a link back finds it
            rendered = document(text, lambda link: self._address(page, link))
            title = rendered.title or source.stem
            self.add_page(address, title, rendered.body)
        if page.startswith("reports/"):
            self.reports.append((title, address, posixpath.dirname(address)))

    def _address(self, page: str, link: str) -> str:
        """Return the address of a link of a page in the site, empty where it leads to no file."""
        path, mark, place = link.partition("#")
        if "://" in link or link.startswith("mailto:") or not path:
            return link
        target = self._target(posixpath.join(posixpath.dirname(page), unquote(path)))
        if not target:
            self.unlinked.append((page, link))
            return ""
        relative = posixpath.relpath(target, posixpath.dirname(page) or ".")
        return quote(relative) + mark + place

    def _target(self, path: str) -> str:
        """Return the address of a file of the project, and add the file; empty where it lacks."""
        path = posixpath.normpath(path)
        source = self.root / path
        if path.startswith("..") or not source.exists():
            return ""
        if source.is_dir():
            index = next((name for name in INDEX_FILES if (source / name).is_file()), "")
            return self._target(f"{path}/{index}") if index else ""
        if source.suffix == ".md":
            self._waiting.append(source)
            return _page_of(path)
        if source.stat().st_size > LARGEST_FILE:
            return ""
        self.files[path] = source
        return path


def _page_of(file: str) -> str:
    return file.removesuffix(".md") + ".html"


# ---- the start page


def _start_html(
    rows: pd.DataFrame, runs: Mapping[str, Run], reports: Sequence[tuple[str, str, str]]
) -> str:
    """Return the text of the start page: boards, runs, and committed reports."""
    boards = [] if rows.empty else list(_boards(rows))
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


def _boards(rows: pd.DataFrame) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Yield title, caption and table of codes by cases and of releases by cases."""
    newest = rows.groupby("engine")["version"].transform(lambda all_: max(all_, key=release_of))
    yield (
        "Codes by cases",
        "Accepted rows of the newest release of each code, by verdict.",
        matrix(rows[rows["version"] == newest], "case", "engine"),
    )
    releases = matrix(rows[rows["engine"] == RELEASES_OF], "case", "version")
    yield (
        "Releases by cases",
        f"Accepted rows of {RELEASES_OF}, by release and verdict.",
        releases[sorted(releases.columns, key=lambda version: release_of(str(version)))],
    )


def _accepted_rows(root: Path) -> pd.DataFrame:
    """Return the rows of accepted runs, one for each key and version."""
    tables = [read_rows(file) for file in sorted(root.glob(ACCEPTED_ROWS))]
    if not tables:
        return table(())
    return pd.concat(tables, ignore_index=True).drop_duplicates([*KEY, "version"])


# ---- known defects


def _defects(root: Path) -> dict[str, dict[str, Any]]:
    file = root / "inputs" / "known-defects.toml"
    text = file.read_text("utf-8") if file.is_file() else ""
    return dict(tomllib.loads(text).get("defect", {}))


def _defect_files(root: Path, defect: Mapping[str, Any]) -> list[str]:
    """Return the paths of a defect's script and of the test for the code's own suite."""
    script = defect.get("script", "")
    paths = [script, posixpath.join(posixpath.dirname(script), "test.yaml")] if script else []
    return [path for path in paths if (root / path).is_file()]


def _defects_html(root: Path, defects: Mapping[str, Mapping[str, Any]], rows: pd.DataFrame) -> str:
    """Return the text of the page of known defects: causes, releases and scripts."""
    numbers = rows[rows["verdict"] == Verdict.KNOWN_DEFECT].groupby(["version", "defect"]).size()
    versions = sorted(numbers.index.unique("version"), key=release_of)
    lines, details = [], []
    for name, defect in defects.items():
        line = {
            "defect": Badge(name, "", f"#{name}"),
            "engine": defect["engine"],
            "releases": defect_releases(defect) or "all known",
        }
        lines.append(line | {version: numbers.get((version, name), "") for version in versions})
        scripts = [(path, (root / path).read_text("utf-8")) for path in _defect_files(root, defect)]
        details.append((name, defect_sentence(defect), defect, scripts))
    return html_page("defects.html.j2", table=pd.DataFrame(lines), defects=details)


# ---- files


def _check_output(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--output {folder}: is a file; name a folder")
    if folder.is_dir() and any(folder.iterdir()) and not (folder / LIST).is_file():
        raise RequestError(f"--output {folder}: has other files; name a new folder or a site")
    check_writable(folder)


def _write(pages: _Pages, runs: Mapping[str, Path], output: Path) -> Site:
    sizes = {address: len(text.encode()) for address, text in sorted(pages.contents.items())}
    built = Site(output, sizes, sorted(pages.files), pages.unlinked)
    with whole_folder(output, replace=True) as folder:
        for name, source in runs.items():
            shutil.copytree(source, folder / "runs" / name)
        for address, source in pages.files.items():
            (folder / address).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, folder / address)
        contents = pages.contents | {LIST: json.dumps(built.to_json(), indent=1)}
        for address, text in contents.items():
            (folder / address).parent.mkdir(parents=True, exist_ok=True)
            (folder / address).write_text(text, encoding="utf-8")
    return built
