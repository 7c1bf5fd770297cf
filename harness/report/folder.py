"""Write a verification's folder: aside first, then renamed, so that none is half-written."""

from __future__ import annotations

import json
from pathlib import Path

from harness.atomic_write import whole_folder
from harness.comparison.verification import Verification
from harness.report.finite import finite
from harness.report.gallery import pictures
from harness.report.junit import junit
from harness.report.page import html_page
from harness.report.schema import NAME, published
from harness.report.summary import short_markdown
from harness.report.target import check_folder
from harness.report.text import markdown


def write(found: Verification, folder: Path) -> None:
    """Write results, pages, figures, scripts and logs into a folder.

    results.json with its schema, results.csv, junit.xml; report.html, report.md and
    summary.md, which is short; figures/, scripts/ and logs/.

    Raise RequestError as :func:`check_folder` does.
    """
    check_folder(folder)
    with whole_folder(folder) as aside:
        aside.mkdir()
        _fill(found, aside)


def _fill(found: Verification, folder: Path) -> None:
    shown = list(pictures(found))
    (folder / "figures").mkdir()
    for picture in shown:
        (folder / "figures" / f"{picture.name}.svg").write_text(picture.svg, encoding="utf-8")
        (folder / "figures" / f"{picture.name}.png").write_bytes(picture.png)
    logs = {f"{name}.log": text for name, text in found.logs.items()}
    logs |= {check.log_name: check.log for check in found.checks if check.log}
    for below, files in (("scripts", found.scripts), ("logs", logs)):
        (folder / below).mkdir()
        for name, text in files.items():
            (folder / below / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / below / name).write_text(text, encoding="utf-8")
    record = json.dumps(finite(found.record()), indent=2, ensure_ascii=False)
    (folder / "results.json").write_text(record + "\n", encoding="utf-8")
    (folder / NAME).write_text(published(), encoding="utf-8")
    found.frame().to_csv(folder / "results.csv", index=False)
    (folder / "junit.xml").write_text(junit(found), encoding="utf-8")
    (folder / "summary.md").write_text(short_markdown(found), encoding="utf-8")
    (folder / "report.md").write_text(markdown(found, shown), encoding="utf-8")
    (folder / "report.html").write_text(html_page(found, shown), encoding="utf-8")
