"""The same cases in several releases of an engine: which values move, and what does not hold."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pandas as pd

from harness.engines.base import Engine
from harness.engines.registry import DEFAULT, engine_class
from harness.errors import RequestError
from harness.files import check_folder, whole_folder
from harness.report.notebook import Summarized
from harness.results.compare import Change, cells, compare, defect_counts, trend
from harness.results.rows import KEY, Level, Verdict
from harness.store.cache import keeping
from harness.store.runs import Run, json_records
from harness.store.tables import exact_texts
from harness.workflows.progress import Progress, silent
from harness.workflows.verification import verify

HOLDING = (Verdict.PASS, Verdict.RECORDED, Verdict.FINDING)
MOVES = (Change.MOVED, Change.OTHER_INPUT)
MOST_MOVED = 200  # rows of the page; rows.csv has all


@dataclass(frozen=True, repr=False)
class ReleaseComparison(Summarized):
    """Runs of the same cases in several releases, by name; the first with values is compared to.

    Rows are those of ``engine`` alone: this package's solvers are the same in each run.
    """

    engine: str
    level: str
    runs: Mapping[str, Run]

    @cached_property
    def rows(self) -> dict[str, pd.DataFrame]:
        """Return the rows of the engine in each release."""
        return {n: r.rows[r.rows["engine"] == self.engine] for n, r in self.runs.items()}

    @cached_property
    def reference(self) -> str:
        """Return the release that the others are compared to: the first with a value."""
        valued = [name for name, rows in self.rows.items() if rows["value"].notna().any()]
        return valued[0] if valued else next(iter(self.runs))

    @cached_property
    def changes(self) -> pd.DataFrame:
        """Return what changed in each release from the reference, by ``release``."""
        before = self.rows[self.reference]
        parts = [compare(before, r).assign(release=name) for name, r in self.rows.items()]
        return pd.concat(parts, ignore_index=True)

    @property
    def status(self) -> int:
        """Return 3 where a release could not be run, 1 where a value moved or failed, else 0."""
        if any(run.status == 3 for run in self.runs.values()):
            return 3
        failed = any((rows["verdict"] == Verdict.FAIL).any() for rows in self.rows.values())
        return int(failed or self.changes["change"].isin(MOVES).any())

    def cells(self) -> pd.DataFrame:
        """Return the worst verdict of each case and setup that does not hold in every release."""
        verdicts = cells(self.rows)
        return verdicts[~verdicts.isin([str(verdict) for verdict in HOLDING]).all(axis="columns")]

    def to_frame(self) -> pd.DataFrame:
        """Return the rows of all releases in one table, with the columns ``run`` and ``change``."""
        long = trend(list(self.rows.items()))
        places = [*KEY, "run"]
        changes = self.changes.rename(columns={"release": "run"})[[*places, "change"]]
        frame = long.merge(changes, on=places, how="left")
        frame.loc[frame["verdict"] == Verdict.NOT_TESTED, "change"] = str(Verdict.NOT_TESTED)
        frame.loc[frame["run"] == self.reference, "change"] = "reference"
        return frame

    def counts(self) -> dict[str, dict[str, int]]:
        """Return how many rows of each release have each change; of the reference, each verdict."""
        frame = self.to_frame()
        words = frame["change"].where(frame["run"] != self.reference, frame["verdict"])
        return {name: dict(Counter(words[frame["run"] == name])) for name in self.runs}

    def to_json(self) -> dict[str, Any]:
        """Return status, reference, releases, rows, defects and cells, JSON-ready."""
        counts = self.counts()
        return {
            "status": self.status,
            "engine": self.engine,
            "level": self.level,
            "reference": self.reference,
            "releases": [
                {"release": name, "version": run.meta.engines.get(self.engine, ""),
                 "headline": run.headline, "counts": counts[name]}
                for name, run in self.runs.items()
            ],
            "rows": json_records(self.to_frame()),
            "known_defects": defect_counts(self.rows).T.to_dict(),
            "cells": json_records(self.cells().reset_index()),
        }  # fmt: skip

    def summary(self) -> dict[str, str]:
        """Return what became of the rows in each release."""
        lines = {}
        for name, counts in self.counts().items():
            version = self.runs[name].meta.engines.get(self.engine) or "did not run"
            text = ", ".join(f"{number} {word}" for word, number in counts.items())
            lines[f"{name} ({version})"] = text
        return lines

    def _repr_html_(self) -> str:
        return str(self.cells().to_html())

    def write(self, folder: Path) -> None:
        """Write report.md and rows.csv into a new folder, whole or not at all."""
        from harness.report.render import markdown_table

        columns = [*KEY, "release", "change", "value_before", "value_after", "unit_after"]
        tables = {
            "Setups that do not hold in every release": self.cells().reset_index(),
            "Known defects, by the number of setups": defect_counts(self.rows).reset_index(),
            "Values that moved": self.changes[self.changes["change"].isin(MOVES)][columns],
        }
        lines = [f"# {self.engine} in {len(self.runs)} releases", ""]
        lines += [f"- {name}: {text}" for name, text in self.summary().items()]
        lines += ["", f"Compared to {self.reference}, level {self.level}. All rows: rows.csv."]
        for title, frame in tables.items():
            if len(frame):
                lines += ["", f"## {title}", "", markdown_table(frame, MOST_MOVED)]
        with whole_folder(folder) as aside:
            exact_texts(self.to_frame()).to_csv(aside / "rows.csv", index=False)
            (aside / "report.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


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
) -> ReleaseComparison:
    """Verify the same cases in several releases of an engine.

    ``names`` are releases, installed below the cache (or ``folder``) where they are missing, or
    commands of executables. A release that cannot be installed or run is a row. Raise
    RequestError for a name that is neither or is given twice, and for an engine without releases.
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
    compared = ReleaseComparison(engine, level, runs)
    if output is not None:
        compared.write(output)
    return compared
