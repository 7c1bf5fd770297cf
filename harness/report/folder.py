"""Write reports into folders, complete or not at all: of runs, differences, releases.

A folder is checked before anything is run: it must be new or empty, and writable. Everything is
written aside and renamed at the end.
"""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness.comparison.releases import Column, ReleaseChange, ReleaseMatrix, ReleaseRow, untested
from harness.comparison.run_diff import RowChange, RunDiff
from harness.comparison.verification import Results, Verification
from harness.files import check_folder, whole_folder
from harness.report.figures import changes as draw_changes
from harness.report.gallery import Drawn, data_uri, draw_sections, picture, size, write_drawn
from harness.report.junit import junit
from harness.report.matrix import defect_scripts
from harness.report.page import report_markdown, report_page
from harness.report.plain import json_text, safe_path, write_csv
from harness.report.render import WIDE, Figure, html_page, markdown_page
from harness.report.sections import Section, Table, divergence_section, engines_section


def write(
    verification: Verification, folder: Path, sections: Sequence[Section] = (), *, png: bool = False
) -> None:
    """Write results, pages, figures, scripts and logs into a folder.

    results.json, results.csv, junit.xml; report.html and report.md; figures/, scripts/ and logs/;
    defects/ with the scripts that show known defects. ``sections`` are those of the cases; series
    that diverged and other engines have sections of their own before them. Figures are SVG, with
    ``png`` PNG too.

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
        "junit.xml": junit(verification),
        "report.md": report_markdown(verification, drawn),
        "report.html": report_page(verification, drawn),
    }
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
