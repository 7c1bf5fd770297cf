"""Write the matrix of releases into a folder: Markdown, CSV, JSON and a figure of the changes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from harness.atomic_write import whole_folder
from harness.comparison.release_cells import untested
from harness.comparison.release_changes import Change
from harness.comparison.releases import ReleaseMatrix
from harness.report.figures.releases import changes as draw_changes
from harness.report.gallery import picture
from harness.report.plain import json_text, write_csv
from harness.report.target import check_folder

CHANGES = "Largest change of each case"
SHOWN = {
    Change.SAME: "same",
    Change.ROUNDING: "round-off",
    Change.TOLERATED: "in tolerance",
    Change.MOVED: "**moved**",
    Change.DIED: "**engine error**",
    Change.NOT_TESTED: "not tested",
}


def write_releases(found: ReleaseMatrix, folder: Path) -> None:
    """Write report.md, results.csv, results.json and the figure into a new folder, whole or not.

    Raise RequestError when the folder cannot take them.
    """
    check_folder(folder)
    with whole_folder(folder) as aside:
        aside.mkdir()
        (aside / "report.md").write_text(markdown(found), encoding="utf-8")
        write_csv(found.frame(), aside / "results.csv")
        (aside / "results.json").write_text(json_text(found.record()), encoding="utf-8")
        drawn = picture("changes", CHANGES, "", lambda: draw_changes(found))
        (aside / "changes.svg").write_text(drawn.svg, encoding="utf-8")


def markdown(found: ReleaseMatrix) -> str:
    """Return the matrix as Markdown: who ran, how much is of each class, and every row."""
    reference, engine = found.columns[found.reference].release, found.engine
    level = "" if found.level == "default" else f" --{found.level}"
    asked = f" --cases {found.cases}" if found.cases else ""
    lines = [
        f"# {engine} releases",
        "",
        f"Cases of `verify{level}{asked}`, each release through its own executable, on "
        f"{found.platform}. Changes are against {reference}.",
        "",
        f"| release | {engine} | " + " | ".join(str(c) for c in Change if c != "reference") + " |",
        f"|---|---|{'--:|' * (len(Change) - 1)}",
    ]
    for i, column in enumerate(found.columns):
        counts = found.counts(i)
        who = column.provenance.engine_version if column.provenance else column.error
        cells = [str(counts.get(str(c), "")) for c in Change if c != "reference"]
        lines.append(f"| {column.release} | {_cell(who)} | {' | '.join(cells)} |")
    lines += ["", f"![{CHANGES}](changes.svg)", "", *_cells_markdown(found)]
    lines += ["## Every quantity", ""]
    head = ["case", "quantity", reference, "tolerance"]
    others = [(i, c) for i, c in enumerate(found.columns) if i != found.reference]
    head += [column.release for _, column in others]
    lines += [f"| {' | '.join(head)} |", f"|---|---|--:|--:|{'---|' * len(others)}"]
    for row in found.rows:
        value = row.cells[found.reference].value
        cells = [row.record, row.quantity, "-" if value is None else f"{value:.12g} {row.unit}"]
        cells += [f"{row.tolerance:.1g}"]
        for i, column in others:
            cell = row.cells[i]
            apart = f" ({cell.difference:+.1e})" if cell.difference else ""
            # why a release has no such cell is told once, by reason
            told = "" if cell.note == column.reasons.get(row.record) else cell.note
            note = f"; {told}" if told else ""
            cells.append(_cell(f"{SHOWN.get(cell.change, cell.change)}{apart}{note}"))
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join([*lines, ""])


def _cells_markdown(found: ReleaseMatrix) -> Iterator[str]:
    """Yield known defects by release, and the cells that do not hold in every release."""
    releases = " | ".join(column.release for column in found.columns)
    dashes = "---|" * len(found.columns)
    if found.defects:
        yield from ("## Known defects, cells in which each was found", "")
        yield from (f"| defect | {releases} |", f"|---|{dashes}")
        for name, counts in found.defects.items():
            yield f"| {name} | {' | '.join(str(count or '') for count in counts)} |"
        yield ""
    if found.cells:
        yield from ("## Cells of the matrix that do not hold in every release", "")
        yield from (
            f"| case | submodel | system | {releases} | defect |",
            f"|---|---|---|{dashes}---|",
        )
        for row in found.cells:
            cells = (row.case, row.submodel, row.system, *row.verdicts, ", ".join(row.defects))
            yield f"| {' | '.join(map(_cell, cells))} |"
        yield ""
        yield from _untested_markdown(found)


def _untested_markdown(found: ReleaseMatrix) -> Iterator[str]:
    """Yield why cells were not tested: release, reason, how many, and in which cases."""
    rows = found.cells
    reasons = [
        (column.release, reason, cells)
        for number, column in enumerate(found.columns)
        for reason, cells in untested(rows, number).items()
    ]
    if not reasons:
        return
    yield from ("## Why cells were not tested", "")
    yield from ("| release | reason | cells | cases |", "|---|---|--:|---|")
    for release, reason, cells in reasons:
        cases = ", ".join(sorted({cell.case for cell in cells}))
        yield f"| {_cell(release)} | {_cell(reason)} | {len(cells)} | {cases} |"
    yield ""


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
