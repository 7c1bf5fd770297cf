"""What moved over time, for a site: from release to release, and from run to run."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import groupby
from pathlib import Path
from typing import Any

from harness.comparison.compare import RunPoint, Step, steps
from harness.comparison.verdicts import Check, Kind
from harness.observables.row import Row, numbered
from harness.report.gallery import Picture, picture
from harness.report.sections import Table
from harness.shown import number
from harness.workflows import history as recorded_history
from harness.workflows.site_board import CONTACTS, RELEASES, SiteRun, read_table, text_state

MOST_FIGURES = 6
"""Quantities whose history is drawn, of those that moved last."""

MOST_STEPS = 100
"""Moves of one step that a page lists; the tables beside the pages have all."""

MOST_MEASURED = 200_000
"""Values of the history that are looked through, the newest."""

LEVELS = ("quick", "full")
SAME_RUN = ("name", "kind", "unit", "engine", "level")
"""What values of one series have in common."""

HEAD = ("quantity", "before", "after", "in tolerances")
TITLES = {RELEASES: "Incline and tower, by release", CONTACTS: "Contacts, by release"}


@dataclass(frozen=True)
class HistoryPart:
    """A part of the history: what was compared, what moved at each step, and figures of it."""

    place: str
    title: str
    sentence: str
    moved: tuple[Table, ...] = ()
    pictures: tuple[Picture, ...] = ()


def release_parts(reports: Path | None) -> Iterator[HistoryPart]:
    """Yield what moved from release to release, for each committed report of releases."""
    for name, title in TITLES.items():
        rows = read_table(reports / name / "results.csv") if reports else []
        releases = list(dict.fromkeys(row["release"] for row in rows))
        if releases:
            points = [_of_release(row) for row in rows if row["value"]]
            points.sort(key=lambda point: releases.index(point.run))
            moves = steps(points)
            sentence = (
                f"{len({point.series for point in points})} values in releases "
                f"{', '.join(releases)}, each against the release before it. "
            )
            place = title.split(",")[0].lower().replace(" ", "-")
            yield HistoryPart(place, title, sentence + _counted(moves), tuple(_boards(moves)))


def _of_release(row: dict[str, str]) -> RunPoint:
    name = f"{row['case'].partition('/')[2]}: {row['quantity']}"
    value = Row(name, float(row["value"]), math.nan, row["unit"])
    return RunPoint((row["case"], row["quantity"]), row["release"], value, float(row["tolerance"]))


def run_parts(runs: Sequence[SiteRun], *, history: bool) -> Iterator[HistoryPart]:
    """Yield what moved over the runs of a site, with ``history`` over those of this machine too."""
    rows = [row for run in runs for row in _rows_of(run)]
    if history:
        kept = recorded_history(quantity="*", command="verify", limit=MOST_MEASURED).rows
        rows += [_recorded(row) for row in kept if not row["cached"]]
    # two runs of one millisecond are in the order of their numbers
    rows.sort(key=lambda row: (row["started"], row.get("run", 0)))
    names = list(dict.fromkeys(row["label"] for row in rows))
    if len(names) < 2:
        several = "two runs or more, or --history" if len(names) else "a run"
        yield HistoryPart("runs", "From run to run", f"Nothing to compare: it takes {several}.")
        return
    moves = steps(_point(row) for row in rows)
    first, last = rows[0]["started"][:10], rows[-1]["started"][:10]
    sentence = f"{len(names)} runs from {first} to {last}, each against the one before it with the "
    sentence += f"same engine and level. {_counted(moves)}"
    drawn = tuple(_drawn(moves, rows))
    yield HistoryPart("runs", "From run to run", sentence, tuple(_boards(moves)), drawn)


def _rows_of(run: SiteRun) -> Iterator[dict[str, Any]]:
    results = run.results
    engine = results.engine
    common = {
        "label": f"{run.name}, {results.started[:16].replace('T', ' ')}",
        "started": results.started,
        "engine": engine.engine if engine else "",
        "engine_version": engine.engine_version if engine else "",
        "how": engine.how if engine else "",
        "harness_version": results.harness_version,
        "platform": results.platform,
        "level": results.level,
        "cached": False,
    }
    # names as the history has them
    for (name, kind, _), before, check in numbered(results.checks, _name_of):
        identity = {"name": f"{name} ({before + 1})" if before else name, "kind": str(kind)}
        yield {**common, **check.to_json(), **identity, "verdict": str(check.verdict)}


def _name_of(check: Check) -> tuple[str, Kind, str]:
    return check.name, check.kind, check.unit


def _recorded(row: dict[str, Any]) -> dict[str, Any]:
    level = next((name for name in LEVELS if f"--{name}" in row["options"].split()), "default")
    label = f"run {row['run']}, {row['started'][:16].replace('T', ' ')}"
    numbers = ("value", "uncertainty", "expected", "tolerance")
    return {
        **row,
        **{n: math.nan for n in numbers if row[n] is None},
        "level": level,
        "label": label,
    }


def _point(row: dict[str, Any]) -> RunPoint:
    value = Row(row["name"], row["value"], row["uncertainty"], row["unit"], row["expected"])
    facts = (
        ("release", row["engine_version"]),
        ("run as", row["how"]),
        ("harness", row["harness_version"]),
        ("commit", row.get("harness_commit", "")),
        ("platform", row["platform"]),
    )
    series = tuple(row[name] for name in SAME_RUN)
    named_facts = tuple((name, text) for name, text in facts if text)
    return RunPoint(series, row["label"], value, row["tolerance"], row["verdict"], named_facts)


def _counted(moves: Sequence[Step]) -> str:
    if not moves:
        return "None moved."
    return f"{len(moves)} move{'s' * (len(moves) != 1)}."


def _boards(moves: Iterable[Step]) -> Iterator[Table]:
    """Yield a table for each step: what else the two runs differ in, and what moved, far first."""

    def ends(step: Step) -> tuple[str, str, tuple[str, ...]]:
        return step.before.run, step.after.run, step.reasons

    for (before, after, reasons), group in groupby(sorted(moves, key=ends), ends):
        of_step = sorted(group, key=lambda step: -abs(step.in_tolerances))
        caption = "; ".join(reasons)
        if len(of_step) > MOST_STEPS:
            caption += (
                f"{'; ' * bool(caption)}the {MOST_STEPS} that moved farthest of {len(of_step)}"
            )
        label = f"{before} → {after}: {len(of_step)} moved"
        rows = tuple(map(_row, of_step[:MOST_STEPS]))
        yield Table(label, f"{caption}." if caption else "", HEAD, rows)


def _row(step: Step) -> tuple[Any, ...]:
    before, after = step.before, step.after
    ends = [
        text_state(f"{number(point.row.value)} {point.row.unit}".strip(), look=point.verdict)
        for point in (before, after)
    ]
    many = "" if math.isnan(step.in_tolerances) else f"{step.in_tolerances:+.3g}"
    return (text_state(after.row.name), *ends, text_state(many))


def _drawn(moves: Sequence[Step], rows: Sequence[dict[str, Any]]) -> Iterator[Picture]:
    import pandas as pd

    from harness.report.figures import quantity_history

    series = list(dict.fromkeys(step.after.series for step in reversed(moves)))[:MOST_FIGURES]
    for n, key in enumerate(series, 1):
        of_series = [row for row in rows if tuple(row[name] for name in SAME_RUN) == key]
        if sum(math.isfinite(row["value"]) for row in of_series) > 1:
            name = str(of_series[0]["name"])
            frame = pd.DataFrame(of_series)
            frame["started"] = pd.to_datetime(frame["started"], utc=True, format="ISO8601")
            draw = partial(quantity_history, frame, "date")
            yield picture(
                f"moved-{n}", name, "Each run, with the tolerance that it was held to.", draw
            )
