"""Build a static site of the committed reports and of runs, and of what moved over time."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from harness.comparison.compare import RunPoint, Step, steps
from harness.comparison.verdicts import Check, Kind, Verdict
from harness.errors import RequestError
from harness.files import check_writable, whole_folder
from harness.observables.row import Row, numbered
from harness.report.gallery import Picture, picture
from harness.report.plain import json_text, safe_path
from harness.report.render import START, STYLE, Site
from harness.report.sections import Table
from harness.report.text import headline
from harness.shown import Result, number
from harness.store.baseline import checkout_baseline, known_defects
from harness.workflows import site_board as board
from harness.workflows.baseline import FILE, read_results
from harness.workflows.site_board import (
    CONTACTS,
    RELEASES,
    DefectPage,
    SiteRun,
    read_table,
    text_state,
)

if TYPE_CHECKING:
    from harness.shown.figure import Figure

LIST = "site.json"
"""File of a site with the addresses of all that it holds."""

RUNS, MOVED = "runs", "moved/index.html"
DEFECTS = f"{board.DEFECTS}/index.html"

COMMITTED = (
    ("Verification", f"reports/{board.MAIN}/report.md"),
    ("Contacts", f"reports/{board.CONTACTS}/report.md"),
    ("Defects", "reports/defects/README.md"),
    ("Releases", f"reports/{board.RELEASES}/report.md"),
    ("Bulk", "reports/bulk/README.md"),
    ("Layers", "reports/layers/report.md"),
    ("Reproduction", "reports/reproduction/report.md"),
    ("Upstream", f"reports/{board.UPSTREAM}/report.md"),
    ("How to read", "reports/README.md"),
)
"""Title and file of each committed report."""


@dataclass(frozen=True, repr=False)
class BuiltSite(Result):
    """A site: its folder, its pages with their sizes [bytes], and how many other files it has.

    ``unlinked`` are page and link where a link leads to nothing that the site could hold.
    """

    folder: Path
    pages: dict[str, int]
    files: int
    unlinked: tuple[tuple[str, str], ...]

    JSON: ClassVar = {
        "output": "folder",
        "start": "start",
        "pages": "listed_pages",
        "files": "files",
        "unlinked": "listed_links",
    }

    @property
    def start(self) -> Path:
        """Return the page to open first."""
        return self.folder / START

    @property
    def listed_pages(self) -> list[dict[str, Any]]:
        """Return address and size of each page."""
        return [{"page": page, "bytes": size} for page, size in self.pages.items()]

    @property
    def listed_links(self) -> list[dict[str, str]]:
        """Return page and address of each link that leads nowhere."""
        return [{"page": page, "link": link} for page, link in self.unlinked]

    def summary(self) -> dict[str, str]:
        """Return where it starts, and how much it holds."""
        counts = {"pages": len(self.pages), "other files": self.files}
        counts |= {"links to what is not committed": len(self.unlinked)}
        words = {name: str(number) for name, number in counts.items()}
        return {"site": str(self.folder / START), **words}

    def draw(self) -> Figure:
        """Draw how many pages are at most so large."""
        from harness.report.style import label, panels

        figure = panels(1, 1)
        axes = figure.axes[0]
        axes.step(sorted(self.pages.values()), range(1, len(self.pages) + 1), where="post")
        axes.set_xscale("log")
        label(axes, "size [bytes]", "pages of at most this size")
        return figure


def site(output: Path, runs: Sequence[Path] = (), *, project: Path | None = None) -> BuiltSite:
    """Build a site into a folder: the committed reports, and folders that ``verify`` wrote.

    ``project`` is the folder that holds ``reports``, that of this checkout unless given. A site
    that the output folder holds is replaced. Raise RequestError for a folder with other files, for
    what is no run, and where there is nothing to show.
    """
    output = Path(output)
    check_folder(output)
    checkout = checkout_baseline()
    project = project or (checkout.parent.parent if checkout else None)
    reports = project / "reports" if project and (project / "reports").is_dir() else None
    folders = _run_folders(runs)
    if reports is None and not folders:
        raise RequestError("RUN: no reports are committed here; name folders of `verify --output`")
    site_runs = [
        SiteRun(name, read_results(folder), f"{RUNS}/{name}/report.html")
        for name, folder in folders.items()
    ]
    if reports and (reports / board.MAIN / FILE).is_file():
        main = read_results(reports / board.MAIN)
        site_runs.insert(0, SiteRun("Main job", main, f"reports/{board.MAIN}/report.html"))
    built = _filled(project or output, reports, site_runs)
    for name, folder in folders.items():
        built.add_folder(folder, f"{RUNS}/{name}")
    _write(built, output)
    sizes = {page: len(html.encode()) for page, html in sorted(built.pages.items())}
    return BuiltSite(output, sizes, len(built.files) + len(built.texts), tuple(built.unlinked))


def check_folder(folder: Path) -> None:
    """Raise RequestError for a folder that cannot take a site: it holds what no site wrote."""
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--output {folder}: is a file; name a folder")
    try:
        text = (folder / LIST).read_text("utf-8")
        written = {LIST, *json.loads(text)["files"]}
    except (OSError, ValueError, KeyError, TypeError):
        written = set()
    held = (path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())
    foreign = next((name for name in held if name not in written), None)
    if foreign is not None:
        raise RequestError(
            f"--output {folder}: holds {foreign}, which no site wrote; name a new folder"
        )
    check_writable(folder)


def _run_folders(runs: Sequence[Path]) -> dict[str, Path]:
    """Return the folders of runs by names that make addresses; raise RequestError for no run."""
    folders: dict[str, Path] = {}
    for run in map(Path, runs):
        folder = run.parent if run.name == FILE else run
        if not (folder / "report.html").is_file():
            raise RequestError(f"RUN {run}: is not a run of verify: it holds no report.html")
        base = name = safe_path(folder.resolve().name)
        while name in folders:
            name = f"{base}-{len(folders) + 1}"
        folders[name] = folder
    return folders


def _filled(root: Path, reports: Path | None, site_runs: Sequence[SiteRun]) -> Site:
    defects = board.defect_pages(known_defects(), reports)
    committed = {title: file for title, file in COMMITTED if reports and (root / file).is_file()}
    pages = {title: _address(file) for title, file in committed.items()}
    pages = {"Start": START, **pages, "Defects": DEFECTS, "What moved": MOVED}
    parts = [*release_parts(reports), *run_parts(site_runs)]
    texts = {
        f"moved/{picture.name}.svg": picture.svg for part in parts for picture in part.pictures
    }
    for page in defects:
        folder = page.address.rpartition("/")[0]
        texts |= {f"{folder}/{page.file}": page.script} if page.script else {}
        texts |= {f"{folder}/test.yaml": page.test} if page.test else {}
    planned = {
        *pages.values(),
        *texts,
        *(defect.address for defect in defects),
        *(run.address for run in site_runs),
    }
    scripts = {
        f"{defect.address.rpartition('/')[0]}/{defect.file}": defect.address for defect in defects
    }
    named = {entry.name: page.address for page in defects for entry in page.entries}
    built = Site(root, tuple(pages.items()), planned, scripts, texts, named)
    built.add_template(START, "board.md.j2", **_start(site_runs, reports, defects))
    built.add_template(MOVED, "moved.md.j2", "What moved, and when", parts=parts)
    for page in defects:
        built.add_template(page.address, "defect.md.j2", page.title, defect=page, index=DEFECTS)
    for file in committed.values():
        built.add_file(file)
    if "Defects" not in committed:
        listed = _defects(defects)
        boards = [("defects", listed)]
        built.add_template(DEFECTS, "board.md.j2", listed.label, runs=(), boards=boards)
    return built


def _address(file: str) -> str:
    stem = file.removesuffix(".md")
    return f"{stem.removesuffix('README')}{START}" if stem.endswith("README") else f"{stem}.html"


def _start(
    site_runs: Sequence[SiteRun], reports: Path | None, defects: Sequence[DefectPage]
) -> dict[str, Any]:
    verdicts = {check.verdict for run in site_runs for check in run.results.checks}
    fails = Verdict.FAIL in verdicts or any(run.results.status for run in site_runs)
    apart = verdicts & {Verdict.KNOWN_DEFECT, Verdict.NOT_TESTED}
    sentences = []
    for run in site_runs:
        results = run.results
        engine = results.engine.label if results.engine else "no engine"
        words = headline(results.checks, results.untested_cases)
        sentences.append((f"{run.name}: {words}", f"{engine}, {results.started[:10]}"))
    boards = {
        "codes": board.codes(site_runs) if site_runs else None,
        "cases": board.cases(reports) if reports else None,
        "bulk": board.bulk(reports) if reports else None,
        "releases": board.releases(reports) if reports else None,
        "defects": _defects(defects),
    }
    return {
        "title": "DEM codes against theory: what holds",
        "outcome": "fail" if fails else "apart" if apart else "",
        "runs": [(run.address, *words) for run, words in zip(site_runs, sentences, strict=True)],
        "boards": [(place, table) for place, table in boards.items() if table is not None],
    }


def _defects(defects: Sequence[DefectPage]) -> Table:
    """Return the list of the known defects, each leading to its page."""
    rows = []
    for page in defects:
        names = "; ".join(entry.name for entry in page.entries)
        facts = dict(page.entries[0].facts)
        releases = f"{facts['first release']} to {facts['last release']}"
        releases = releases.replace(f"{board.ALWAYS} to today", "all").replace(
            f"{board.ALWAYS} ", ""
        )
        rows.append(
            (
                text_state(page.title, page.address),
                text_state(facts["what"].rpartition(" of ")[2]),
                text_state(releases),
                text_state(page.paragraphs[0] if page.paragraphs else names),
            )
        )
    sentence = "Each has a page with its cause, what it makes of a run, and a script to run."
    head = ("defect", "code", "releases", "what")
    return Table("Known defects", sentence, head, tuple(rows))


def _write(built: Site, output: Path) -> None:
    files = sorted({*built.pages, *built.files, *built.texts, STYLE})
    with whole_folder(output, replace=True) as aside:
        aside.mkdir()
        built.write(aside)
        (aside / LIST).write_text(json_text({"files": files}), encoding="utf-8")


MOST_FIGURES = 6
"""Quantities that are drawn over time, of those that moved last."""

MOST_STEPS = 100
"""Moves of one step that a page lists; the tables beside the pages have all."""

SAME_RUN = ("name", "kind", "unit", "engine", "level")
"""What values of one series have in common."""

HEAD = ("quantity", "before", "after", "in tolerances")
TITLES = {RELEASES: "Incline and tower, by release", CONTACTS: "Contacts, by release"}


@dataclass(frozen=True)
class MovedPart:
    """A part of the page of what moved: what was compared, each step, and figures of it."""

    place: str
    title: str
    sentence: str
    moved: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()


def release_parts(reports: Path | None) -> Iterator[MovedPart]:
    """Yield what moved from release to release, for each committed report of releases."""
    for name, title in TITLES.items():
        rows = read_table(reports / name / "results.csv") if reports else []
        releases = list(dict.fromkeys(row["release"] for row in rows))
        if releases:
            points = [_of_release(row) for row in rows if row["value"]]
            points.sort(key=lambda point: releases.index(point.run))
            moves = steps(points)
            sentence = (
                f"{len({point.series for point in points})} values in releases "
                f"{', '.join(releases)}, each against the release before it. "
            )
            place = title.split(",")[0].lower().replace(" ", "-")
            yield MovedPart(place, title, sentence + _counted(moves), tuple(_boards(moves)))


def _of_release(row: dict[str, str]) -> RunPoint:
    name = f"{row['case'].partition('/')[2]}: {row['quantity']}"
    value = Row(name, float(row["value"]), math.nan, row["unit"])
    return RunPoint((row["case"], row["quantity"]), row["release"], value, float(row["tolerance"]))


def run_parts(runs: Sequence[SiteRun]) -> Iterator[MovedPart]:
    """Yield what moved over the runs of a site."""
    rows = [row for run in runs for row in _rows_of(run)]
    rows.sort(key=lambda row: row["started"])
    names = list(dict.fromkeys(row["label"] for row in rows))
    if len(names) < 2:
        several = "two runs or more" if len(names) else "a run"
        yield MovedPart("runs", "From run to run", f"Nothing to compare: it takes {several}.")
        return
    moves = steps(_point(row) for row in rows)
    first, last = rows[0]["started"][:10], rows[-1]["started"][:10]
    sentence = f"{len(names)} runs from {first} to {last}, each against the one before it with the "
    sentence += f"same engine and level. {_counted(moves)}"
    drawn = tuple(_drawn(moves, rows))
    yield MovedPart("runs", "From run to run", sentence, tuple(_boards(moves)), drawn)


def _rows_of(run: SiteRun) -> Iterator[dict[str, Any]]:
    results = run.results
    engine = results.engine
    common = {
        "label": f"{run.name}, {results.started[:16].replace('T', ' ')}",
        "started": results.started,
        "engine": engine.engine if engine else "",
        "engine_version": engine.engine_version if engine else "",
        "how": engine.how if engine else "",
        "harness_version": results.harness_version,
        "platform": results.platform,
        "level": results.level,
    }
    for (name, kind, _), before, check in numbered(results.checks, _name_of):
        identity = {"name": f"{name} ({before + 1})" if before else name, "kind": str(kind)}
        yield {**common, **check.to_json(), **identity, "verdict": str(check.verdict)}


def _name_of(check: Check) -> tuple[str, Kind, str]:
    return check.name, check.kind, check.unit


def _point(row: dict[str, Any]) -> RunPoint:
    value = Row(row["name"], row["value"], row["uncertainty"], row["unit"], row["expected"])
    facts = (
        ("release", row["engine_version"]),
        ("run as", row["how"]),
        ("harness", row["harness_version"]),
        ("platform", row["platform"]),
    )
    series = tuple(row[name] for name in SAME_RUN)
    named_facts = tuple((name, text) for name, text in facts if text)
    return RunPoint(series, row["label"], value, row["tolerance"], row["verdict"], named_facts)


def _counted(moves: Sequence[Step]) -> str:
    if not moves:
        return "None moved."
    return f"{len(moves)} move{'s' * (len(moves) != 1)}."


def _boards(moves: Iterable[Step]) -> Iterator[Table]:
    """Yield a table for each step: what else the two runs differ in, and what moved, far first."""

    def ends(step: Step) -> tuple[str, str, tuple[str, ...]]:
        return step.before.run, step.after.run, step.reasons

    for (before, after, reasons), group in groupby(sorted(moves, key=ends), ends):
        of_step = sorted(group, key=lambda step: -abs(step.in_tolerances))
        caption = "; ".join(reasons)
        if len(of_step) > MOST_STEPS:
            caption += (
                f"{'; ' * bool(caption)}the {MOST_STEPS} that moved farthest of {len(of_step)}"
            )
        label = f"{before} → {after}: {len(of_step)} moved"
        rows = tuple(map(_row, of_step[:MOST_STEPS]))
        yield Table(label, f"{caption}." if caption else "", HEAD, rows)


def _row(step: Step) -> tuple[Any, ...]:
    before, after = step.before, step.after
    ends = [
        text_state(f"{number(point.row.value)} {point.row.unit}".strip(), look=point.verdict)
        for point in (before, after)
    ]
    many = "" if math.isnan(step.in_tolerances) else f"{step.in_tolerances:+.3g}"
    return (text_state(after.row.name), *ends, text_state(many))


def _drawn(moves: Sequence[Step], rows: Sequence[dict[str, Any]]) -> Iterator[Picture]:
    import pandas as pd

    from harness.report.figures import trend

    series = list(dict.fromkeys(step.after.series for step in reversed(moves)))[:MOST_FIGURES]
    for n, key in enumerate(series, 1):
        of_series = [row for row in rows if tuple(row[name] for name in SAME_RUN) == key]
        if sum(math.isfinite(row["value"]) for row in of_series) > 1:
            name = str(of_series[0]["name"])
            frame = pd.DataFrame(of_series)
            frame["started"] = pd.to_datetime(frame["started"], utc=True, format="ISO8601")
            draw = partial(trend, frame)
            yield picture(
                f"moved-{n}", name, "Each run, with the tolerance that it was held to.", draw
            )
