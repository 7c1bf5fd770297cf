"""Write the comparison of two runs into a folder: an HTML page, its numbers as JSON and CSV."""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness.atomic_write import whole_folder
from harness.comparison.results import Results
from harness.comparison.run_diff import Change, RunDiff
from harness.report.page import WIDE, Shown
from harness.report.plain import json_text, write_csv
from harness.report.target import check_folder
from harness.report.templating import environment
from harness.report.vector import data_uri, size

NUMERIC = ("before", "after", "moved by", "in tolerances", "in uncertainties")
COLUMNS = ("change", "check", "kind", "verdict", *NUMERIC, "unit")


@dataclass(frozen=True)
class Pair:
    """A figure in both runs; one drawing where it is the same, None where there is none."""

    title: str
    same: bool
    drawings: Sequence[Shown | None]

    @property
    def stacked(self) -> bool:
        """Return whether it stands one above the other: words side by side would be too small."""
        return self.same or any(one is not None and one.width > WIDE for one in self.drawings)


def diff_page(
    found: RunDiff, names: tuple[str, str], pairs: Sequence[Pair], scripts: Mapping[str, str]
) -> str:
    """Return the page; figures and style are inside it, so that it can be sent alone."""
    changes = [change for change in Change if found.count(change)]
    return (
        environment()
        .get_template("diff.html.j2")
        .render(
            found=found,
            headline=headline(found),
            runs=[
                (name, _who(run))
                for name, run in zip(names, (found.before, found.after), strict=True)
            ],
            counts=[(change, found.count(change)) for change in changes],
            changes=changes,
            order=list(Change),
            names=COLUMNS,
            numeric=NUMERIC,
            kinds=list(dict.fromkeys(row.row.kind for row in found.rows)),
            pairs=pairs,
            scripts=scripts,
        )
    )


def headline(found: RunDiff) -> str:
    """Return the outcome in a few words; what got worse is counted kind by kind."""
    worse = Counter(str(row.row.kind) for row in found.rows if row.worsens)
    if worse:
        return "Worse: " + ", ".join(f"{number} {kind}" for kind, number in worse.items())
    if found.count(Change.SAME) == len(found.rows):
        return "Nothing moved"
    return "No verdict changed for the worse"


def _who(run: Results) -> str:
    engine = run.engine
    name = engine.told if engine else "no engine"
    return f"{name} · {run.started[:16].replace('T', ' ')} · {run.level}"


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
        (aside / "diff.json").write_text(json_text(found.record()), encoding="utf-8")
        write_csv(found.frame(), aside / "diff.csv")


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
