"""Write the report of a study into a folder: HTML, Markdown, the rows behind them, the figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.atomic_write import whole_folder
from harness.report.gallery import draw_sections, write_drawn
from harness.report.markdown import section_markdown
from harness.report.page import look, parts_of
from harness.report.plain import json_text, markdown_text, write_csv
from harness.report.sections import Section
from harness.report.target import check_folder
from harness.report.templating import environment

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Page:
    """What opens the page: title, question, verdict, and facts on who ran it and how."""

    title: str
    question: str
    verdict: tuple[str, ...]
    facts: Mapping[str, str]


def write_study(
    page: Page,
    sections: Sequence[Section],
    record: Mapping[str, Any],
    tables: Mapping[str, pd.DataFrame],
    folder: Path,
) -> None:
    """Write report.html, report.md, study.json, a CSV of each table and the figures.

    All aside first, then renamed. Raise RequestError for a folder that holds something.
    """
    check_folder(folder)
    drawn = draw_sections(sections)
    lines = [f"# {markdown_text(page.title)}", "", markdown_text(page.question), ""]
    lines += [f"- **{markdown_text(sentence)}**" for sentence in page.verdict]
    lines.append("")
    lines += [line for part in drawn for line in section_markdown(part)]
    lines += ["## Provenance", ""]
    lines += [f"- {name}: {markdown_text(text)}" for name, text in page.facts.items()]
    template = environment().get_template("study.html.j2")
    html = template.render(page=page, parts_of_page=parts_of(drawn), look=look)
    with whole_folder(folder) as aside:
        aside.mkdir()
        write_drawn(drawn, aside)
        for name, table in tables.items():
            write_csv(table, aside / name)
        (aside / "study.json").write_text(json_text(record), encoding="utf-8")
        (aside / "report.md").write_text("\n".join([*lines, ""]), encoding="utf-8")
        (aside / "report.html").write_text(html, encoding="utf-8")
