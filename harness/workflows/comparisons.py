"""Runs side by side: stored ones, accepted ones, and the same cases in several releases.

``diff``, ``accept`` and ``releases`` return a :class:`Comparison`; ``defects`` lists known defects.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import pandas as pd

from harness.engines.base import Engine
from harness.engines.registry import DEFAULT, engine_class
from harness.errors import RequestError
from harness.files import check_folder, committed, whole_folder
from harness.report.content import Summarized
from harness.results.compare import (
    Change,
    cells,
    compare,
    counts_of_changes,
    defect_counts,
    regressions,
)
from harness.results.defects import KnownDefect
from harness.results.rows import KEY, Level, Verdict
from harness.store.cache import CachedEngine, default_entries
from harness.store.committed import (
    ACCEPTED,
    accepted_rows,
    defect_script,
    folder_name,
    known_defects,
)
from harness.store.committed import accept as accept_rows
from harness.store.runs import Meta, Run, exact_texts, json_records, read_run
from harness.workflows import Progress, silent
from harness.workflows.verification import verify

ACCEPTED_RUN = "accepted"  # in the place of a run's folder
UNCHANGED = (Change.SAME, Change.ROUND_OFF, Change.WITHIN, Change.NOT_COMPARABLE)
COLUMNS = [*KEY, "change", "value_before", "value_after", "moved_by", "unit_after", "in_tolerances",
           "in_uncertainties", "verdict_before", "verdict_after", "note_after"]  # fmt: skip
HOLDING = (Verdict.PASS, Verdict.RECORDED, Verdict.FINDING)
MOVES = (Change.MOVED, Change.OTHER_INPUT)
REFERENCE = "reference"  # in the place of a change, of the release that others are compared to
MOVED_COLUMNS = [*KEY, "run", "change", "value_before", "value_after", "unit_after"]
MOST_MOVED = 200  # rows of the page; rows.csv has all
DEFECT = ("name", "engine", "kind", "cause", "upstream")  # fields of a known defect
PATTERNS = ("cases", "laws", "systems", "variations")  # likewise, each a list


@dataclass(frozen=True, repr=False)
class Comparison(Summarized):
    """Runs that were compared: the exit status, facts by the keys of JSON, and changed rows.

    ``lines`` are the facts in words, by name.
    """

    status: int
    facts: Mapping[str, Any]
    changes: pd.DataFrame
    lines: Mapping[str, str]

    def to_frame(self) -> pd.DataFrame:
        """Return the changed rows."""
        return self.changes

    def to_json(self) -> dict[str, Any]:
        """Return the facts and the changed rows, JSON-ready."""
        return {**self.facts, "rows": json_records(self.changes)}

    def summary(self) -> Mapping[str, str]:
        """Return the facts in words."""
        return self.lines

    def _repr_html_(self) -> str:
        return str(self.changes.to_html(index=False, na_rep=""))


# ---- stored runs


def diff(*runs: str | Path | Run, accepted: Path | None = None) -> Comparison:
    """Return what changed from run to run, each a folder or a ``Run``; three or more are a trend.

    The word ``accepted`` in place of one of two runs is the accepted rows of the other's engines,
    of the committed folder unless ``accepted`` is given. The status is 1 where a verdict of the
    last run changed for the worse; against the accepted run it is that of ``verify``: a value that
    moved counts, too. Raise RequestError for a folder that is no run, and for fewer than two runs.
    """
    if len(runs) < 2:
        raise RequestError("diff: needs two runs or more, or a run and the word 'accepted'")
    with_accepted = ACCEPTED_RUN in runs
    if with_accepted and (len(runs) > 2 or runs[0] == runs[1]):
        raise RequestError("diff: 'accepted' goes with one run")
    stored = _runs_by_name(runs)
    names, read = [*stored], [*stored.values()]
    if with_accepted:
        names.insert(0, ACCEPTED_RUN)
        folder, engines = accepted or committed(ACCEPTED), read[0].meta.engines
        if not any((folder / folder_name(engine)).is_dir() for engine in engines):
            raise RequestError(f"diff: {folder} has no accepted run of {', '.join(engines)}")
        steps = [read[0].changes_from_accepted(accepted_rows(engines, folder))]
        status = int(not regressions(steps[0]).empty or not all(engines.values()))
    else:
        steps = [after.changes_from(before) for before, after in pairwise(read)]
        status = int((steps[-1]["change"] == Change.WORSE).any())
    before, after = _facts(read[0].meta), _facts(read[-1].meta)
    metadata = [
        {"name": name, "before": before.get(name, "none"), "after": after.get(name, "none")}
        for name in {**before, **after}
        if before.get(name) != after.get(name)
    ]
    counts = counts_of_changes(steps[-1])
    facts = {"status": status, "runs": names, "counts": counts, "metadata": metadata}
    pairs = list(zip(pairwise(names), steps, strict=True))
    lines = {f"{a} to {b}": _words(counts_of_changes(step)) or "no rows" for (a, b), step in pairs}
    lines |= {fact["name"]: f"{fact['before']} → {fact['after']}" for fact in metadata}
    rows = pd.concat([step.assign(run_before=a, run_after=b) for (a, b), step in pairs])
    changed = rows.loc[~rows["change"].isin(UNCHANGED), ["run_before", "run_after", *COLUMNS]]
    return Comparison(status, facts, changed.reset_index(drop=True), lines)


def values_of(*runs: str | Path | Run) -> pd.DataFrame:
    """Return the values of all rows of runs: index the key, a column for each run."""
    stored = _runs_by_name(runs)
    return pd.DataFrame({n: run.rows.set_index(list(KEY))["value"] for n, run in stored.items()})


def accept(run: str | Path | Run, folder: str | Path | None = None) -> Comparison:
    """Accept a run: merge its rows into the accepted runs; review the change with ``git diff``.

    Into the project's folder unless one is given. Raise RequestError for a folder that is no run,
    for a run in which an engine died, and for the accepted runs of an installed package.
    """
    folder = None if folder is None else Path(folder)
    (new,) = _runs_by_name([run]).values()
    before = accepted_rows(new.meta.engines, folder)
    changes = new.changes_from_accepted(before)
    files, counts = [str(file) for file in accept_rows(new, folder)], counts_of_changes(changes)
    facts = {"folder": str(folder or committed(ACCEPTED)), "files": files, "counts": counts}
    lines = {
        "rows": _words(counts) or "none",
        "files changed": ", ".join(files) or "none: the run is what was accepted",
    }
    changed = changes.loc[changes["change"] != Change.SAME, COLUMNS].reset_index(drop=True)
    return Comparison(0, facts, changed, lines)


def defects(name: str | None = None) -> list[dict[str, Any]]:
    """Return the known defects as records, or the one of a name with its script.

    Raise RequestError for an unknown name.
    """
    entries = [defect for defect in known_defects() if name in (None, defect.name)]
    if not entries:
        raise RequestError(f"defect {name!r} is not known: `dem-harness defect` lists all")
    records = []
    for entry in entries:
        record: dict[str, Any] = {key: getattr(entry, key) for key in DEFECT}
        record |= {
            "effect": _effect(entry),
            "since": entry.since or "as long as is known",
            "until": entry.until or "today",
        }
        record |= {key: ", ".join(getattr(entry, key)) for key in PATTERNS}
        script = "" if name is None else defect_script(entry)
        records.append(record | ({"script": script} if script else {}))
    return records


def _effect(defect: KnownDefect) -> str:
    """Return the effect of a defect on a run in words."""
    if defect.error:
        return f"the run ends with “{defect.error}”"
    if defect.undetermined:
        return f"not computed: {defect.undetermined}"
    if defect.fit:
        return f"{defect.fit}, fitted on the first sample that shows it; all later ones agree"
    parts = {"faults": defect.faults, "rules": defect.rules, "law": defect.law}
    values = {f"{part}.{k}": v for part, changes in parts.items() for k, v in changes.items()}
    return ", ".join(name if v is True else f"{name} = {v}" for name, v in values.items())


def _runs_by_name(runs: Sequence[str | Path | Run]) -> dict[str, Run]:
    """Return runs by their paths, else by when they started; numbered where two are one.

    The word ``accepted`` is omitted.
    """
    runs = [run for run in runs if run != ACCEPTED_RUN]
    names = [run.meta.started or "run" if isinstance(run, Run) else str(run) for run in runs]
    distinct = [
        name if names.count(name) == 1 else f"{name} ({n})" for n, name in enumerate(names, 1)
    ]
    read = [run if isinstance(run, Run) else read_run(Path(run)) for run in runs]
    return dict(zip(distinct, read, strict=True))


def _facts(meta: Meta) -> dict[str, str]:
    facts = {"level": meta.level, "cases": ", ".join(meta.cases), "rows": meta.only,
             "platform": meta.platform, "dem-harness": meta.harness_version}  # fmt: skip
    return facts | {f"engine {n}": version or "missing" for n, version in meta.engines.items()}


def _words(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{number} {word}" for word, number in counts.items())


# ---- releases of an engine


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
    processes: int = 1,
    progress: Progress = silent,
) -> Comparison:
    """Verify the same cases in several releases of an engine, compared to the first with values.

    ``names`` are releases, installed below the cache (or ``folder``) where they are missing, or
    commands of executables. A release that cannot be installed or run is a row. The status is 3
    where one could not be run, 1 where a value moved or failed. ``output`` is a new folder for
    report.md and rows.csv, ``processes`` are those of each verification. Raise RequestError for a
    name that is neither or is given twice, and for an engine without releases.
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
                yield CachedEngine(installed, default_entries(), fresh=fresh)

        def note(stage: str, done: int, total: int) -> None:
            progress(f"{name}: {stage}", done, total)

        return verify(
            level,
            cases=cases,
            engines=engine,
            only=only,
            open_engine=open_release,
            processes=processes,
            progress=note,
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
    moved = changed[changed["change"].isin(MOVES)]

    every = pd.concat([t.assign(run=name) for name, t in rows.items()], ignore_index=True)
    frame = every.merge(changed[[*KEY, "run", "change"]], on=[*KEY, "run"], how="left")
    frame.loc[frame["verdict"] == Verdict.NOT_TESTED, "change"] = str(Verdict.NOT_TESTED)
    frame.loc[frame["run"] == reference, "change"] = REFERENCE
    words = frame["change"].where(frame["run"] != reference, frame["verdict"])

    verdicts = cells(rows)
    holding = verdicts.isin([str(verdict) for verdict in HOLDING]).all(axis="columns")
    failing, defects_found = verdicts[~holding].reset_index(), defect_counts(rows)
    died = any(run.status == 3 for run in runs.values())
    status = 3 if died else int(len(moved) > 0 or (frame["verdict"] == Verdict.FAIL).any())
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
        "known_defects": defects_found.T.to_dict(),
        "cells": json_records(failing),
    }  # fmt: skip
    lines = {
        f"{release['release']} ({release['version'] or 'did not run'})": _words(release["counts"])
        for release in facts["releases"]
    }
    compared = Comparison(status, facts, frame, lines)
    if output is not None:
        tables = {
            "Setups that do not hold in every release": failing,
            "Known defects, by the number of setups": defects_found.reset_index(),
            "Values that moved": moved[MOVED_COLUMNS].reset_index(drop=True),
        }
        _write(output, compared, tables)
    return compared


def _write(folder: Path, compared: Comparison, tables: Mapping[str, pd.DataFrame]) -> None:
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
