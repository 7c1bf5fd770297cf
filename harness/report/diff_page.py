"""Two runs side by side as one self-contained HTML page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from harness.comparison.results import Results
from harness.comparison.run_diff import Change, RunDiff
from harness.report.page import WIDE, Shown
from harness.report.templating import environment

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
