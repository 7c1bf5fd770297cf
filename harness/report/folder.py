"""Write reports into folders, complete or not at all: of runs, differences, releases.

A folder is checked before anything is run: it must be new or empty, and writable. Everything is
written aside and renamed at the end. Of a run there is more for CI: Markdown that fits a comment or
the summary of a job, and JUnit XML.
"""

from __future__ import annotations

import difflib
import json
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as Xml

from harness.comparison.releases import Column, ReleaseChange, ReleaseMatrix, ReleaseRow, untested
from harness.comparison.run_diff import RowChange, RunDiff
from harness.comparison.verdicts import Check, Kind, Verdict
from harness.comparison.verification import SCHEMA, Results, Verification, json_schema
from harness.files import check_folder, whole_folder
from harness.report.figures import changes as draw_changes
from harness.report.gallery import Drawn, data_uri, draw_sections, picture, size, write_drawn
from harness.report.markdown import style, table_lines, tail
from harness.report.matrix import defect_scripts
from harness.report.page import FOLDER, addresses, cell_pages, report_markdown, report_page
from harness.report.plain import json_text, markdown_text, safe_path, write_csv
from harness.report.render import WIDE, Figure, html_page, markdown_page
from harness.report.sections import Section, Table, divergence_section, engines_section
from harness.report.text import (
    KINDS,
    KindSummary,
    by_severity,
    details,
    explained,
    happened,
    numbers,
    provenance,
    summaries,
    summary,
    triage,
)
from harness.shown import number

if TYPE_CHECKING:
    pass


def write(
    verification: Verification, folder: Path, sections: Sequence[Section] = (), *, png: bool = False
) -> None:
    """Write results, pages, figures, scripts and logs into a folder.

    results.json with its schema, results.csv, junit.xml; report.html, report.md and
    summary.md, which is short; figures/, scripts/ and logs/; cells/ with a page for each cell of
    the matrix; defects/ with the scripts that show known ones. ``sections`` are those of the cases;
    series that diverged and other engines have sections of their own before them. Figures are SVG,
    with ``png`` PNG too.

    Raise RequestError as :func:`check_folder` does.
    """
    check_folder(folder)
    with whole_folder(folder) as aside:
        aside.mkdir()
        _fill(
            verification, aside, draw_sections([*_own_sections(verification), *sections], png=png)
        )


def _own_sections(verification: Verification) -> list[Section]:
    diverged = divergence_section(verification.divergences)
    engines = [engines_section(verification.engines)] if verification.engines else []
    return [diverged, *engines] if diverged.drawings else engines


def _fill(verification: Verification, folder: Path, drawn: Sequence[Drawn]) -> None:
    write_drawn(drawn, folder)
    logs = {f"{safe_path(name)}.log": text for name, text in verification.logs.items()}
    logs |= {check.log_name: check.log for check in verification.checks if check.log}
    _write_texts(
        folder / "scripts", {safe_path(n): text for n, text in verification.scripts.items()}
    )
    _write_texts(folder / "logs", logs)
    write_csv(verification.to_frame(), folder / "results.csv", errors="replace")
    texts = {
        "results.json": json_text(verification.to_json()),
        SCHEMA_FILE: committed_schema(),
        "junit.xml": junit(verification),
        "summary.md": short_markdown(verification),
        "report.md": report_markdown(verification, drawn),
        "report.html": report_page(verification, drawn, addresses(drawn)),
    }
    pages = dict(cell_pages(verification, drawn))
    if pages:
        texts |= {**pages, f"{FOLDER}/style.css": style()}
    _write_texts(folder, {**texts, **defect_scripts(verification)})


def _write_texts(folder: Path, texts: Mapping[str, str]) -> None:
    """Write texts into files below a folder; halves of characters become question marks."""
    folder.mkdir(exist_ok=True)
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8", errors="replace")


NUMERIC = ("before", "after", "moved by", "in tolerances", "in uncertainties")
COLUMNS = ("change", "check", "kind", "verdict", *NUMERIC, "unit")


@dataclass(frozen=True)
class Pair:
    """A figure in both runs; one drawing where it is the same, None where there is none."""

    title: str
    same: bool
    drawings: Sequence[Figure | None]

    @property
    def stacked(self) -> bool:
        """Return whether it stands one above the other: words side by side would be too small."""
        return self.same or any(
            drawing is not None and drawing.width > WIDE for drawing in self.drawings
        )


def diff_page(
    difference: RunDiff, names: tuple[str, str], pairs: Sequence[Pair], scripts: Mapping[str, str]
) -> str:
    """Return the page; figures and style are inside it, so that it can be sent alone."""
    changes = [change for change in RowChange if difference.count(change)]
    runs = zip(("before", "after"), names, (difference.before, difference.after), strict=True)
    metadata = tuple((other.name, other.before, other.after) for other in difference.metadata)
    return html_page(
        "diff.md.j2",
        f"Two runs: {headline(difference)}",
        frame={"name": "Two verification runs", "columns": COLUMNS},
        found=difference,
        headline=headline(difference),
        runs=[(place, f"{name}, {_run_label(run)}") for place, name, run in runs],
        counts=[f"{difference.count(change)} {change}" for change in changes],
        metadata=Table("What else is not the same", "", ("what", "before", "after"), metadata),
        changes=changes,
        order=list(RowChange),
        names=COLUMNS,
        numeric=NUMERIC,
        kinds=list(dict.fromkeys(row.row.kind for row in difference.rows)),
        pairs=pairs,
        scripts=scripts,
    )


def headline(difference: RunDiff) -> str:
    """Return the outcome in a few words; what got worse is counted kind by kind."""
    worse = Counter(str(row.row.kind) for row in difference.rows if row.worsens)
    if worse:
        return "Worse: " + ", ".join(f"{number} {kind}" for kind, number in worse.items())
    if difference.count(RowChange.SAME) == len(difference.rows):
        return "Nothing moved"
    return "No verdict changed for the worse"


def _run_label(run: Results) -> str:
    engine = run.engine
    name = engine.label if engine else "no engine"
    return f"{name} · {run.started[:16].replace('T', ' ')} · {run.level}"


LONGEST = 400
"""Lines of one script's difference that are shown."""


def write_diff(difference: RunDiff, before: Path, after: Path, folder: Path) -> None:
    """Write diff.html, diff.json and diff.csv into a folder.

    ``before`` and ``after`` are the runs: figures and scripts are taken from
    beside their results.json, and left out where they are not there. Raise
    RequestError when the folder cannot take them.
    """
    check_folder(folder)
    runs = [run if run.is_dir() else run.parent for run in (before, after)]
    with whole_folder(folder) as aside:
        aside.mkdir()
        page = diff_page(
            difference, (str(before), str(after)), list(_pairs(*runs)), _scripts(*runs)
        )
        (aside / "diff.html").write_text(page, encoding="utf-8")
        (aside / "diff.json").write_text(json_text(difference.to_json()), encoding="utf-8")
        write_csv(difference.to_frame(), aside / "diff.csv")


def _pairs(before: Path, after: Path) -> Iterator[Pair]:
    """Yield the figures of both runs by name; one that is the same in both is shown once."""
    names = {path.stem for run in (before, after) for path in (run / "figures").glob("*.svg")}
    for name in sorted(names):
        texts = [_text(run / "figures" / f"{name}.svg", run) for run in (before, after)]
        same = texts[0] == texts[1]
        drawings = [_drawing(name, text) for text in (texts[:1] if same else texts)]
        yield Pair(name.replace("-", " ").capitalize(), same, drawings)


def _drawing(name: str, svg: str | None) -> Figure | None:
    try:
        width, height = map(round, size(svg or ""))
    except ValueError:
        return None
    return Figure(name, name.replace("-", " "), "", data_uri(svg or ""), width, height)


def _scripts(before: Path, after: Path) -> dict[str, str]:
    """Return, for each script that is not the same, the difference in lines."""
    runs = (before, after)
    names = {
        path.relative_to(run).as_posix()
        for run in runs
        for path in (run / "scripts").rglob("*")
        if path.is_file()
    }
    differences = {}
    for name in sorted(names):
        old, new = ((_text(run / name, run) or "").splitlines() for run in runs)
        lines = list(difflib.unified_diff(old, new, "before", "after", lineterm=""))
        if lines:
            differences[name.removeprefix("scripts/")] = "\n".join(lines[:LONGEST])
    return differences


def _text(path: Path, run: Path) -> str | None:
    """Return a file of a run; None where there is none, or a link leads out of the run."""
    try:
        if not path.resolve().is_relative_to(run.resolve()):
            return None
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None


CHANGES = "Largest change of each case"
SHOWN = {
    ReleaseChange.SAME: "same",
    ReleaseChange.ROUNDING: "round-off",
    ReleaseChange.TOLERATED: "in tolerance",
    ReleaseChange.MOVED: "**moved**",
    ReleaseChange.DIED: "**engine error**",
    ReleaseChange.NOT_TESTED: "not tested",
}


def write_releases(matrix: ReleaseMatrix, folder: Path) -> None:
    """Write report.md, results.csv, results.json and the figure into a new folder, whole or not.

    Raise RequestError when the folder cannot take them.
    """
    check_folder(folder)
    with whole_folder(folder) as aside:
        aside.mkdir()
        (aside / "report.md").write_text(markdown(matrix), encoding="utf-8")
        write_csv(matrix.to_frame(), aside / "results.csv")
        (aside / "results.json").write_text(json_text(matrix.to_json()), encoding="utf-8")
        drawn = picture("changes", CHANGES, "", lambda: draw_changes(matrix))
        (aside / "changes.svg").write_text(drawn.svg, encoding="utf-8")


def markdown(matrix: ReleaseMatrix) -> str:
    """Return the matrix as Markdown: who ran, how much is of each class, and every row."""
    others = [(n, column) for n, column in enumerate(matrix.columns) if n != matrix.reference]
    reference = matrix.columns[matrix.reference].release
    rows = tuple(_release_row(row, matrix, others) for row in matrix.rows)
    head = ("case", "quantity", reference, "tolerance", *(c.release for _, c in others))
    return markdown_page(
        "releases.md.j2",
        f"{matrix.engine} releases{f': {matrix.cases}' if matrix.cases else ''}",
        found=matrix,
        reference=reference,
        changes=CHANGES,
        counts=_counts(matrix),
        tables=[table for table in _cell_tables(matrix) if table.rows],
        quantities=Table("Every quantity", "", head, rows),
    )


def _counts(matrix: ReleaseMatrix) -> Table:
    """Return how many values of each release are of each class."""
    classes = [str(change) for change in ReleaseChange if change != "reference"]
    rows = []
    for place, column in enumerate(matrix.columns):
        counts = matrix.counts(place)
        provenance = column.provenance.engine_version if column.provenance else column.error
        rows.append((column.release, provenance, *(str(counts.get(c, "")) for c in classes)))
    return Table("Releases", "", ("release", matrix.engine, *classes), tuple(rows))


def _release_row(
    row: ReleaseRow, matrix: ReleaseMatrix, others: Sequence[tuple[int, Column]]
) -> tuple[str, ...]:
    """Return a quantity, its value in the reference, and what became of it in the others."""
    value = row.cells[matrix.reference].value
    cells = [row.record, row.quantity, "-" if value is None else f"{value:.12g} {row.unit}"]
    cells.append(f"{row.tolerance:.1g}")
    for place, column in others:
        cell = row.cells[place]
        apart = f" ({cell.difference:+.1e})" if cell.difference else ""
        # why a release has no such cell is told once, by reason
        note = "" if cell.note == column.reasons.get(row.record) else cell.note
        change = SHOWN.get(cell.change, str(cell.change))
        cells.append(f"{change}{apart}{f'; {note}' if note else ''}")
    return tuple(cells)


def _cell_tables(matrix: ReleaseMatrix) -> Iterator[Table]:
    """Yield known defects by release, cells that do not hold in every one, and why not tested."""
    releases = tuple(column.release for column in matrix.columns)
    defects = ((name, *(str(n or "") for n in row)) for name, row in matrix.defects.items())
    title = "Known defects, cells in which each was found"
    yield Table(title, "", ("defect", *releases), tuple(defects))
    cells = (
        (row.case, row.submodel, row.system, *row.verdicts, ", ".join(row.defects))
        for row in matrix.cells
    )
    head = ("case", "submodel", "system", *releases, "defect")
    yield Table("Cells of the matrix that do not hold in every release", "", head, tuple(cells))
    reasons = (
        (column.release, reason, str(len(cells)), ", ".join(sorted({cell.case for cell in cells})))
        for place, column in enumerate(matrix.columns)
        for reason, cells in untested(matrix.cells, place).items()
    )
    head = ("release", "reason", "cells", "cases")
    yield Table("Why cells were not tested", "", head, tuple(reasons))


SCHEMA_FILE = "results.schema.json"


def committed_schema() -> str:
    """Return the committed schema, which lies beside results.json in every report."""
    return resources.files("harness.report").joinpath(SCHEMA_FILE).read_text(encoding="utf-8")


def generated_schema() -> str:
    """Return the schema as the dataclasses of :mod:`harness.comparison.verification` give it."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"urn:dem-harness:results:{SCHEMA}",
        **json_schema(),
    }
    return json.dumps(schema, indent=2, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    Path(__file__).with_name(SCHEMA_FILE).write_text(generated_schema(), encoding="utf-8")


def opening_markdown(verification: Verification) -> list[str]:
    """Return the outcome kind by kind, and the headlines as a list."""
    outcome, counts, *headlines = map(markdown_text, summary(verification))
    return [f"**{outcome}**", counts, "", *(f"- {line}" for line in headlines)]


LIMIT = 60_000
"""Characters. A comment on GitHub holds 65,536, of which others may want some."""

SEVERE = (Verdict.FAIL, Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED)
HEAD = ("check", "value", "expected", "difference", "tolerance", "")


def short_markdown(verification: Verification) -> str:
    """Return outcome, failed rows, and all others folded away by kind; under 60,000 characters."""
    lines = ["## DEM verification", "", *opening_markdown(verification), ""]
    severe = [check for check in by_severity(verification.checks) if check.verdict in SEVERE]
    if severe:
        lines += ["| check | kind | what happened |", "|---|---|---|"]
        lines += [*_within(LIMIT // 3, [_severe(check) for check in severe]), ""]
    for kind in summaries(verification.checks):
        rows = [check for check in kind.checks if check.verdict not in SEVERE]
        if rows:
            lines += _folded(kind.kind, rows, (LIMIT // 2) // len(KINDS))
    lines += ["<details><summary>Provenance</summary>", ""]
    lines += [f"- {name}: {markdown_text(text)[:1500]}" for name, text in provenance(verification)]
    return "\n".join([*lines, "", "</details>", ""])


def _severe(check: Check) -> str:
    about = "" if check.engine_died else triage(check)
    note = "" if math.isnan(check.value) else check.note
    texts = (happened(check), about, details(check), note)
    mark = "**failed**" if check.verdict is Verdict.FAIL else str(check.verdict)
    happening = markdown_text("; ".join(filter(None, texts)))[:600]
    return f"| {mark} {markdown_text(check.name)} | {check.kind} | {happening} |"


def _folded(kind: Kind, rows: Sequence[Check], room: int) -> list[str]:
    cells = [
        (c.name, *map(number, (c.value, c.expected)), number(c.difference, 2),
         number(c.tolerance, 2), c.unit)
        for c in rows
    ]  # fmt: skip
    head, rule, *table = table_lines(HEAD, cells, range(1, 5))
    title = f"<details><summary>{KINDS[kind]} ({len(rows)})</summary>"
    return [title, "", head, rule, *_within(room, table), "", "</details>", ""]


def _within(room: int, rows: Sequence[str]) -> list[str]:
    """Return the rows that there is room for, and a last one that counts the others."""
    kept: list[str] = []
    for row in rows:
        room -= len(row) + 1
        if room < 0:
            return [*kept, f"| and {len(rows) - len(kept)} more, in report.html | | |"]
        kept.append(row)
    return kept


_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What XML 1.0 cannot hold, not even escaped."""


def junit(verification: Verification) -> str:
    """Return the checks as JUnit XML: a suite for each kind, a test case for each check.

    A verdict that failed is a ``failure``, an engine that died an ``error``. What was
    not tested, known defects, those that are fixed, and a finding, which nobody judges, are
    ``skipped`` with the reason.
    """
    rows = summaries(verification.checks)
    suites = [
        _suite(verification, row, verification.seconds if row is rows[0] else 0.0) for row in rows
    ]
    root = Xml.Element("testsuites", name="dem-harness", time=f"{verification.seconds:.3f}")
    for key in ("tests", "failures", "errors"):  # Jenkins's schema knows no more here
        root.set(key, str(sum(int(suite.get(key, "0")) for suite in suites)))
    root.extend(suites)
    Xml.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + Xml.tostring(root, "unicode") + "\n"


def _suite(verification: Verification, row: KindSummary, seconds: float) -> Xml.Element:
    """Return the suite of a kind; the first carries the time, which no check has of its own."""
    cases = _cases(row)
    suite = Xml.Element(
        "testsuite",
        name=f"dem-harness {row.kind}",
        tests=str(len(cases)),
        failures=str(sum(case.find("failure") is not None for case in cases)),
        errors=str(sum(case.find("error") is not None for case in cases)),
        skipped=str(sum(case.find("skipped") is not None for case in cases)),
        time=f"{seconds:.3f}",
        timestamp=verification.started[:19],
    )
    engine = verification.provenance
    label = engine.label if engine else "none"
    properties = Xml.SubElement(suite, "properties")
    for name, value in (
        ("level", verification.level),
        ("engine", label),
        ("platform", verification.platform),
    ):
        Xml.SubElement(properties, "property", name=name, value=_clean(value))
    suite.extend(cases)
    return suite


def _cases(row: KindSummary) -> list[Xml.Element]:
    """Return the test cases of a kind; a name that comes again is numbered, as readers need."""
    seen: Counter[str] = Counter()
    cases = []
    for check in row.checks:
        seen[check.name] += 1
        again = f" ({seen[check.name]})" if seen[check.name] > 1 else ""
        case = Xml.Element(
            "testcase",
            classname=f"dem-harness.{check.kind}",
            name=_clean(check.name + again),
            time="0.000",
        )
        _outcome(case, check)
        cases.append(case)
    return cases


def _outcome(case: Xml.Element, check: Check) -> None:
    if check.verdict is Verdict.FAIL:
        kind = "error" if check.engine_died else "failure"
        message = check.note if check.engine_died else numbers(check)
        trouble = Xml.SubElement(
            case, kind, type=_clean(triage(check) or "verdict"), message=_clean(message)
        )
        trouble.text = _clean(_story(check))
    elif check.verdict is Verdict.NOT_TESTED:
        Xml.SubElement(case, "skipped", message=_clean(f"not tested: {check.note}"))
    elif check.verdict in (Verdict.KNOWN_DEFECT, Verdict.FIXED):
        message = f"{check.verdict}: {numbers(check)}. {check.note}"
        Xml.SubElement(case, "skipped", message=_clean(message))
    elif check.verdict is Verdict.FINDING:
        message = f"finding, not judged: {numbers(check)}. {check.note}"
        Xml.SubElement(case, "skipped", message=_clean(message))
    else:
        Xml.SubElement(case, "system-out").text = _clean(numbers(check))


def _story(check: Check) -> str:
    about = triage(check)
    lines = [
        f"{check.kind}: {check.name}",
        numbers(check),
        check.why and f"tolerance: {check.why}",
        about and f"class: {about}. {details(check)} {explained(check)}",
        check.note,
        check.log and f"log: logs/{check.log_name}\n{tail(check.log)}",
    ]
    return "\n".join(line for line in lines if line)


def _clean(text: str) -> str:
    return _NOT_XML.sub("?", text)
