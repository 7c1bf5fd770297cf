"""Write the report of a verification into a folder, complete or not at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from harness.atomic_write import whole_folder
from harness.comparison.verification import Verification
from harness.report.cells import FOLDER, addresses, cell_pages
from harness.report.defects import defect_scripts
from harness.report.divergences import divergence_section
from harness.report.engines import engines_section
from harness.report.gallery import draw_sections, write_drawn
from harness.report.junit import junit
from harness.report.markdown import report_markdown
from harness.report.page import html_page
from harness.report.plain import json_text, safe_path, write_csv
from harness.report.schema import NAME, published
from harness.report.sections import Section
from harness.report.summary import short_markdown
from harness.report.target import check_folder
from harness.report.templating import style


def write(found: Verification, folder: Path, sections: Sequence[Section] = ()) -> None:
    """Write results, pages, figures, scripts and logs into a folder.

    results.json with its schema, results.csv, junit.xml; report.html, report.md and
    summary.md, which is short; figures/, scripts/ and logs/; cells/ with a page for each cell of
    the matrix; defects/ with the scripts that show known ones. ``sections`` are those of the cases;
    series that diverged and other engines have sections of their own before them.

    Raise RequestError as :func:`check_folder` does.
    """
    check_folder(folder)
    with whole_folder(folder) as aside:
        aside.mkdir()
        _fill(found, aside, [*_own_sections(found), *sections])


def _own_sections(found: Verification) -> list[Section]:
    diverged = divergence_section(found.divergences)
    engines = [engines_section(found.engines)] if found.engines else []
    return [diverged, *engines] if diverged.drawings else engines


def _fill(found: Verification, folder: Path, sections: Sequence[Section]) -> None:
    drawn = draw_sections(sections)
    write_drawn(drawn, folder)
    logs = {f"{safe_path(name)}.log": text for name, text in found.logs.items()}
    logs |= {check.log_name: check.log for check in found.checks if check.log}
    _write_texts(folder / "scripts", {safe_path(n): text for n, text in found.scripts.items()})
    _write_texts(folder / "logs", logs)
    write_csv(found.frame(), folder / "results.csv", errors="replace")
    texts = {
        "results.json": json_text(found.record()),
        NAME: published(),
        "junit.xml": junit(found),
        "summary.md": short_markdown(found),
        "report.md": report_markdown(found, drawn),
        "report.html": html_page(found, drawn, addresses(drawn)),
    }
    pages = dict(cell_pages(found, drawn))
    if pages:
        texts |= {**pages, f"{FOLDER}/style.css": style()}
    _write_texts(folder, {**texts, **defect_scripts(found)})


def _write_texts(folder: Path, texts: Mapping[str, str]) -> None:
    """Write texts into files below a folder; halves of characters become question marks."""
    folder.mkdir(exist_ok=True)
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8", errors="replace")
