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
from typing import TYPE_CHECKING, Any
from urllib.parse import quote, unquote

import harness
from harness.engines.provenance import release_of
from harness.errors import RequestError
from harness.files import check_writable, safe_path, whole_folder
from harness.report.causes import defect_releases, defect_sentence
from harness.report.matrix import matrix, verdict_badges
from harness.report.render import Badge, document, html_page
from harness.results.rows import KEY, Verdict, table
from harness.store.runs import Run, read_run
from harness.store.tables import read_rows

if TYPE_CHECKING:
    import pandas as pd

TITLE = "DEM codes against theory"
START, DEFECTS, LIST = "index.html", "defects.html", "site.json"
ROWS = "reports/accepted/*/*/rows.csv"
RELEASES_OF = "lammps"  # the engine whose releases are a board
LARGEST_FILE = 5_000_000  # bytes of a linked file that is copied
Navigation = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Site:
    """A site that was built: its folder, its pages with their sizes [bytes], other files.

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
        """Return the first page, and how much the site has."""
        numbers = (("pages", self.pages), ("other files", self.files))
        return {"site": str(self.start), **{name: str(len(part)) for name, part in numbers},
                "links without a file": str(len(self.unlinked))}  # fmt: skip

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
    named = {safe_path(Path(folder).resolve().name): Path(folder) for folder in runs}
    if len(named) != len(runs):
        raise RequestError("RUN: two folders of one name; rename one")
    read = {name: read_run(folder) for name, folder in named.items()}
    if not (root / "reports").is_dir() and not read:
        raise RequestError("RUN: there are no committed reports; name folders of `verify --output`")
    pages = Pages(root, _navigation(root))
    pages.add_committed()
    defects = read_defects(root)
    rows = committed_rows(root)
    pages.add_page(DEFECTS, "Known defects", defects_html(root, defects, rows))
    pages.files |= {
        path: root / path for one in defects.values() for path in defect_files(root, one)
    }
    pages.add_page(START, TITLE, start_html(root, rows, read, pages.contents))
    return _written(pages, named, output)


# ---- pages


@dataclass
class Pages:
    """Pages and files of a site, by their address; both are found by the links of pages."""

    root: Path
    navigation: Navigation
    contents: dict[str, str] = field(default_factory=dict)
    files: dict[str, Path] = field(default_factory=dict)
    unlinked: list[tuple[str, str]] = field(default_factory=list)

    def add_committed(self) -> None:
        """Add the README, the committed reports, and what they link to."""
        self._waiting = [self.root / "README.md", *sorted((self.root / "reports").rglob("*.md"))]
        runs = self.root / "reports" / "runs"
        while self._waiting:
            source = self._waiting.pop()
            if source.is_file() and not source.is_relative_to(runs):
                self._add_markdown(source)

    def add_page(self, address: str, title: str, body: str) -> None:
        """Add a page with the navigation of the site."""
        up = "../" * address.count("/")
        self.contents[address] = html_page(
            "site.html.j2", title=title, body=body, navigation=self.navigation, up=up, here=address
        )

    def _add_markdown(self, source: Path) -> None:
        page = source.relative_to(self.root).as_posix()
        address = _page_address(page)
        finished = source.with_suffix(".html")
        if finished.is_file():  # a report has its own page
            self.files[address] = finished
            return
        if address in self.contents:
            return
        self.contents[address] = ""  # known, so that a link back finds it
        text = source.read_text(encoding="utf-8")
        found = document(text, lambda link: self._address(page, link))
        self.add_page(address, found.title or source.stem, found.body)

    def _address(self, page: str, link: str) -> str:
        """Return the address of a link of a page in the site, empty where it leads to no file."""
        path, mark, place = link.partition("#")
        if "://" in link or link.startswith("mailto:") or not path:
            return link
        target = posixpath.normpath(posixpath.join(posixpath.dirname(page), unquote(path)))
        found = self._found(target)
        if found is None:
            self.unlinked.append((page, link))
            return ""
        relative = posixpath.relpath(found, posixpath.dirname(_page_address(page)) or ".")
        return quote(relative) + mark + place

    def _found(self, target: str) -> str | None:
        """Return the address of a file of the project, which is added where it is not yet."""
        source = self.root / target
        if target.startswith("..") or not source.exists():
            return None
        if source.is_dir():
            names = ("README.md", "report.md", "report.html")
            index = next((source / name for name in names if (source / name).is_file()), None)
            return None if index is None else self._found(index.relative_to(self.root).as_posix())
        if source.suffix == ".md":
            self._waiting.append(source)
            return _page_address(target)
        if source.stat().st_size > LARGEST_FILE:
            return None
        self.files[target] = source
        return target


def start_html(
    root: Path, rows: pd.DataFrame, runs: Mapping[str, Run], pages: Mapping[str, str]
) -> str:
    """Return the text of the start page: boards, runs, and committed reports."""
    import pandas as pd

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
    reports = pd.DataFrame(_reports(root, pages), columns=["report", "folder"])
    return html_page("start.html.j2", title=TITLE, boards=boards, reports=reports)


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


def committed_rows(root: Path) -> pd.DataFrame:
    """Return the rows of accepted runs, one for each key and version."""
    import pandas as pd

    tables = [read_rows(file) for file in sorted(root.glob(ROWS))]
    if not tables:
        return table(())
    return pd.concat(tables, ignore_index=True).drop_duplicates([*KEY, "version"])


# ---- known defects


def read_defects(root: Path) -> dict[str, dict[str, Any]]:
    """Return the known defects of a project by name, none where it has no file of them."""
    file = root / "inputs" / "known-defects.toml"
    if not file.is_file():
        return {}
    defects: dict[str, dict[str, Any]] = tomllib.loads(file.read_text("utf-8")).get("defect", {})
    return defects


def defect_files(root: Path, defect: Mapping[str, Any]) -> list[str]:
    """Return the paths of a defect's script and of the test for the code's own suite."""
    script = defect.get("script", "")
    paths = [script, posixpath.join(posixpath.dirname(script), "test.yaml")] if script else []
    return [path for path in paths if (root / path).is_file()]


def defects_html(root: Path, defects: Mapping[str, Mapping[str, Any]], rows: pd.DataFrame) -> str:
    """Return the text of the page of known defects: causes, releases and scripts."""
    import pandas as pd

    found = rows[rows["verdict"] == Verdict.KNOWN_DEFECT].groupby(["version", "defect"]).size()
    versions = sorted(found.index.unique("version"), key=release_of)
    lines, details = [], []
    for name, defect in defects.items():
        line = {
            "defect": Badge(name, "", f"#{name}"),
            "engine": defect["engine"],
            "releases": defect_releases(defect) or "all known",
        }
        lines.append(line | {version: found.get((version, name), "") for version in versions})
        scripts = [(path, (root / path).read_text("utf-8")) for path in defect_files(root, defect)]
        details.append((name, defect_sentence(defect), defect, scripts))
    return html_page("defects.html.j2", table=pd.DataFrame(lines), defects=details)


# ---- files


def _navigation(root: Path) -> Navigation:
    pages = (("README", "README.md"), ("How to read a report", "reports/README.md"))
    present = [(name, _page_address(file)) for name, file in pages if (root / file).is_file()]
    return (("Start", START), ("Known defects", DEFECTS), *present)


def _page_address(file: str) -> str:
    """Return the address of the page of a Markdown file."""
    return file.removesuffix(".md") + ".html"


def _reports(root: Path, pages: Mapping[str, str]) -> Iterator[tuple[Badge, str]]:
    """Yield title, with a link, and folder of each committed report."""
    for source in sorted((root / "reports").rglob("*.md")):
        address = _page_address(source.relative_to(root).as_posix())
        if address in pages or source.with_suffix(".html").is_file():
            title = document(source.read_text(encoding="utf-8")).title
            yield Badge(title, "", address), posixpath.dirname(address)


def _check_output(folder: Path) -> None:
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--output {folder}: is a file; name a folder")
    if folder.is_dir() and any(folder.iterdir()) and not (folder / LIST).is_file():
        raise RequestError(f"--output {folder}: has other files; name a new folder or a site")
    check_writable(folder)


def _written(pages: Pages, runs: Mapping[str, Path], output: Path) -> Site:
    sizes = {address: len(text.encode()) for address, text in sorted(pages.contents.items())}
    built = Site(output, sizes, sorted(pages.files), pages.unlinked)
    with whole_folder(output, replace=True) as aside:
        for name, folder in runs.items():
            shutil.copytree(folder, aside / "runs" / name)
        for address, source in pages.files.items():
            (aside / address).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, aside / address)
        for address, text in pages.contents.items():
            (aside / address).parent.mkdir(parents=True, exist_ok=True)
            (aside / address).write_text(text, encoding="utf-8")
        (aside / LIST).write_text(json.dumps(built.to_json(), indent=1), encoding="utf-8")
    return built
