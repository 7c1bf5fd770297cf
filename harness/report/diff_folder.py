"""Write two runs side by side: a page and its numbers, aside first, then renamed."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterator
from pathlib import Path

from harness.atomic_write import whole_folder
from harness.comparison.run_diff import RunDiff
from harness.report.diff_page import Pair, diff_page
from harness.report.finite import finite
from harness.report.page import Shown
from harness.report.target import check_folder
from harness.report.vector import data_uri, size

LONGEST = 400
"""Lines of one script's difference that are shown."""


def write_diff(found: RunDiff, before: Path, after: Path, folder: Path) -> None:
    """Write diff.html, diff.json and diff.csv into a folder.

    ``before`` and ``after`` are the runs: figures and scripts are taken from
    beside their results.json, and left out where they are not there. Raise
    RequestError when the folder cannot take them.
    """
    check_folder(folder)
    runs = [run if run.is_dir() else run.parent for run in (before, after)]
    with whole_folder(folder) as aside:
        aside.mkdir()
        page = diff_page(found, (str(before), str(after)), list(_pairs(*runs)), _scripts(*runs))
        (aside / "diff.html").write_text(page, encoding="utf-8")
        record = json.dumps(finite(found.record()), indent=2, ensure_ascii=False)
        (aside / "diff.json").write_text(record + "\n", encoding="utf-8")
        found.frame().to_csv(aside / "diff.csv", index=False)


def _pairs(before: Path, after: Path) -> Iterator[Pair]:
    """Yield the figures of both runs by name; one that is the same in both is shown once."""
    names = {path.stem for run in (before, after) for path in (run / "figures").glob("*.svg")}
    for name in sorted(names):
        texts = [_text(run / "figures" / f"{name}.svg", run) for run in (before, after)]
        same = texts[0] == texts[1]
        drawings = [_drawing(name, text) for text in (texts[:1] if same else texts)]
        yield Pair(name.replace("-", " ").capitalize(), same, drawings)


def _drawing(name: str, svg: str | None) -> Shown | None:
    try:
        width, height = map(round, size(svg or ""))
    except ValueError:
        return None
    return Shown(name, name.replace("-", " "), "", data_uri(svg or ""), width, height)


def _scripts(before: Path, after: Path) -> dict[str, str]:
    """Return, for each script that is not the same, the difference in lines."""
    runs = (before, after)
    names = {
        path.relative_to(run).as_posix()
        for run in runs
        for path in (run / "scripts").rglob("*")
        if path.is_file()
    }
    found = {}
    for name in sorted(names):
        old, new = ((_text(run / name, run) or "").splitlines() for run in runs)
        lines = list(difflib.unified_diff(old, new, "before", "after", lineterm=""))
        if lines:
            found[name.removeprefix("scripts/")] = "\n".join(lines[:LONGEST])
    return found


def _text(path: Path, run: Path) -> str | None:
    """Return a file of a run; None where there is none, or a link leads out of the run."""
    try:
        if not path.resolve().is_relative_to(run.resolve()):
            return None
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
