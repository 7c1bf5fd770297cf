"""The same cases in several releases of an engine: which values move, and what does not hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas as pd

from harness.engines.base import Engine
from harness.engines.registry import DEFAULT, engine_class
from harness.errors import RequestError
from harness.files import check_folder, whole_folder
from harness.results.compare import Change, cells, compare, defect_counts
from harness.results.rows import KEY, Level, Verdict
from harness.store.cache import keeping
from harness.store.runs import Run, json_records
from harness.store.tables import exact_texts
from harness.workflows.progress import Progress, silent
from harness.workflows.results import Comparison, counts_text
from harness.workflows.verification import verify

HOLDING = (Verdict.PASS, Verdict.RECORDED, Verdict.FINDING)
MOVES = (Change.MOVED, Change.OTHER_INPUT)
REFERENCE = "reference"  # in the place of a change, of the release that others are compared to
MOVED_COLUMNS = [*KEY, "run", "change", "value_before", "value_after", "unit_after"]
MOST_MOVED = 200  # rows of the page; rows.csv has all
Rows = Mapping[str, pd.DataFrame]  # of the engine, by release


def releases(  # noqa: PLR0913 - the options of a user
    names: Sequence[str],
    *,
    level: Level = "quick",
    cases: str | Iterable[str] | None = None,
    only: str = "",
    engine: str = DEFAULT,
    folder: Path | None = None,
    fresh: bool = False,
    output: Path | None = None,
    progress: Progress = silent,
) -> Comparison:
    """Verify the same cases in several releases of an engine, compared to the first with values.

    ``names`` are releases, installed below the cache (or ``folder``) where they are missing, or
    commands of executables. A release that cannot be installed or run is a row. The status is 3
    where one could not be run, 1 where a value moved or failed. ``output`` is a new folder for
    report.md and rows.csv. Raise RequestError for a name that is neither or is given twice, and
    for an engine without releases.
    """
    kind: Any = engine_class(engine)
    if not (hasattr(kind, "release") and hasattr(kind, "check_release")):
        raise RequestError(f"--engine {engine!r}: has no releases that can be installed")
    if not names:
        raise RequestError("releases: name at least one release, or an executable")
    for name, count in Counter(names).items():
        if count > 1:
            raise RequestError(f"release {name!r}: is named twice")
        kind.check_release(name)
    if output is not None:
        check_folder(output)

    def verified(name: str) -> Run:
        @contextmanager
        def open_release(_: str) -> Iterator[Engine]:
            with kind.release(name, folder) as installed:
                yield keeping(installed, fresh=fresh)

        def note(stage: str, done: int, total: int) -> None:
            progress(f"{name}: {stage}", done, total)

        return verify(
            level, cases=cases, engines=engine, only=only, open_engine=open_release, progress=note
        )

    runs = {}
    for done, name in enumerate(names, 1):
        runs[name] = verified(name)
        progress("releases", done, len(names))
    return compared_releases(runs, engine, level, output)


def compared_releases(
    runs: Mapping[str, Run], engine: str, level: str, output: Path | None = None
) -> Comparison:
    """Return how runs of the same cases in several releases differ in the rows of an engine.

    This package's solvers are the same in each run. The table has the columns ``run`` and
    ``change``.
    """
    rows = {name: run.rows[run.rows["engine"] == engine] for name, run in runs.items()}
    valued = [name for name, table in rows.items() if table["value"].notna().any()]
    reference = next(iter([*valued, *runs]))
    changes = [compare(rows[reference], table).assign(run=name) for name, table in rows.items()]
    changed = pd.concat(changes, ignore_index=True)
    frame = _rows_with_changes(rows, changed, reference)
    moved = changed[changed["change"].isin(MOVES)]
    failing, defects = _failing_cells(rows), defect_counts(rows)
    died = any(run.status == 3 for run in runs.values())
    status = 3 if died else int(len(moved) > 0 or (frame["verdict"] == Verdict.FAIL).any())
    words = frame["change"].where(frame["run"] != reference, frame["verdict"])
    facts: dict[str, Any] = {
        "status": status,
        "engine": engine,
        "level": level,
        "reference": reference,
        "releases": [
            {"release": name, "version": run.meta.engines.get(engine, ""),
             "headline": run.headline, "counts": dict(Counter(words[frame["run"] == name]))}
            for name, run in runs.items()
        ],
        "known_defects": defects.T.to_dict(),
        "cells": json_records(failing),
    }  # fmt: skip
    lines = {
        f"{record['release']} ({record['version'] or 'did not run'})": counts_text(record["counts"])
        for record in facts["releases"]
    }
    compared = Comparison(status, facts, frame, lines)
    if output is not None:
        tables = {
            "Setups that do not hold in every release": failing,
            "Known defects, by the number of setups": defects.reset_index(),
            "Values that moved": moved[MOVED_COLUMNS].reset_index(drop=True),
        }
        _write(output, compared, tables)
    return compared


def _rows_with_changes(rows: Rows, changes: pd.DataFrame, reference: str) -> pd.DataFrame:
    """Return the rows of all releases in one table, with the columns ``run`` and ``change``."""
    every = pd.concat([t.assign(run=name) for name, t in rows.items()], ignore_index=True)
    places = [*KEY, "run"]
    frame = every.merge(changes[[*places, "change"]], on=places, how="left")
    frame.loc[frame["verdict"] == Verdict.NOT_TESTED, "change"] = str(Verdict.NOT_TESTED)
    frame.loc[frame["run"] == reference, "change"] = REFERENCE
    return frame


def _failing_cells(rows: Rows) -> pd.DataFrame:
    """Return the worst verdict of each case and setup that does not hold in every release."""
    verdicts = cells(rows)
    holding = verdicts.isin([str(verdict) for verdict in HOLDING]).all(axis="columns")
    return verdicts[~holding].reset_index()


def _write(folder: Path, compared: Comparison, tables: Rows) -> None:
    """Write report.md and rows.csv into a new folder, whole or not at all."""
    from harness.report.render import markdown_table

    facts = compared.facts
    parts = [
        f"# {facts['engine']} in {len(facts['releases'])} releases",
        "\n".join(f"- {name}: {text}" for name, text in compared.lines.items()),
        f"Compared to {facts['reference']}, level {facts['level']}. All rows: rows.csv.",
    ]
    parts += [f"## {title}\n\n{markdown_table(table, MOST_MOVED)}"
              for title, table in tables.items() if len(table)]  # fmt: skip
    with whole_folder(folder) as aside:
        exact_texts(compared.changes).to_csv(aside / "rows.csv", index=False)
        (aside / "report.md").write_text("\n\n".join(parts) + "\n", encoding="utf-8")
