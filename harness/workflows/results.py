"""Stored runs and known defects: ``diff``, ``accept`` and ``defect``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import pairwise
from pathlib import Path
from typing import Any

import pandas as pd

from harness.errors import RequestError
from harness.report.content import Summarized
from harness.results.compare import Change, compare, counts_of_changes, regressions
from harness.results.rows import KEY
from harness.store.committed import (
    ACCEPTED,
    accepted_folder,
    accepted_rows,
    defect_script,
    known_defects,
    writable_folder,
)
from harness.store.committed import accept as accept_rows
from harness.store.runs import Meta, Run, json_records, read_run

UNCHANGED = (Change.SAME, Change.ROUND_OFF, Change.WITHIN, Change.NOT_COMPARABLE)
COLUMNS = [*KEY, "change", "value_before", "value_after", "moved_by", "unit_after", "in_tolerances",
           "in_uncertainties", "verdict_before", "verdict_after", "note_after"]  # fmt: skip
DEFECT = ("name", "engine", "kind", "cause", "upstream", "effect")  # fields of a known defect
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


def diff(*runs: str | Path | Run, accepted: Path | None = None) -> Comparison:
    """Return what changed from run to run, each a folder or a ``Run``; three or more are a trend.

    The word ``accepted`` in place of one of two runs is the accepted rows of the other's engines,
    of the committed folder unless ``accepted`` is given. The status is 1 where a verdict of the
    last run changed for the worse; against the accepted run it is that of ``verify``: a value that
    moved counts, too. Raise RequestError for a folder that is no run, and for fewer than two runs.
    """
    if len(runs) < 2:
        raise RequestError("diff: needs two runs or more, or a run and the word 'accepted'")
    others = [run for run in runs if run != ACCEPTED]
    if len(others) < len(runs) and (len(runs), len(others)) != (2, 1):
        raise RequestError("diff: 'accepted' goes with one run")
    names, read = _distinct_names(others), [_run(run) for run in others]
    if len(read) == 1:
        names.insert(0, ACCEPTED)
        steps = [_changes_from_accepted(read[0], accepted or accepted_folder())]
        status = int(not regressions(steps[0]).empty)
    else:
        steps = [after.changes_from(before) for before, after in pairwise(read)]
        status = int((steps[-1]["change"] == Change.WORSE).any())
    metadata = _other_facts(read[0].meta, read[-1].meta)
    facts = {
        "status": status,
        "runs": names,
        "counts": counts_of_changes(steps[-1]),
        "metadata": metadata,
    }
    pairs = list(zip(pairwise(names), steps, strict=True))
    lines = {
        f"{a} to {b}": counts_text(counts_of_changes(step)) or "no rows" for (a, b), step in pairs
    }
    lines |= {fact["name"]: f"{fact['before']} → {fact['after']}" for fact in metadata}
    rows = pd.concat([step.assign(run_before=a, run_after=b) for (a, b), step in pairs])
    changed = rows.loc[~rows["change"].isin(UNCHANGED), ["run_before", "run_after", *COLUMNS]]
    return Comparison(status, facts, changed.reset_index(drop=True), lines)


def values_of(*runs: str | Path | Run) -> pd.DataFrame:
    """Return the values of all rows of runs: index the key, a column for each run."""
    named = [run for run in runs if run != ACCEPTED]
    values = [_run(run).rows.set_index(list(KEY))["value"] for run in named]
    return pd.DataFrame(dict(zip(_distinct_names(named), values, strict=True)))


def accept(run: str | Path | Run, folder: Path | None = None) -> Comparison:
    """Accept a run: merge its rows into the accepted runs; review the change with ``git diff``.

    Into the project's folder unless one is given. Raise RequestError for a folder that is no run,
    for a run in which an engine died, and for the accepted runs of an installed package.
    """
    target, new = folder or writable_folder(), _run(run)
    before = accepted_rows(target, new.meta.engines)
    changes = compare(before, new.rows, covers_after=new.meta.covers)
    files, counts = [str(file) for file in accept_rows(new, target)], counts_of_changes(changes)
    facts = {"folder": str(target), "files": files, "counts": counts}
    lines = {
        "rows": counts_text(counts) or "none",
        "files changed": ", ".join(files) or "none: the run is what was accepted",
    }
    changed = changes.loc[changes["change"] != Change.SAME, COLUMNS].reset_index(drop=True)
    return Comparison(0, facts, changed, lines)


def defects(name: str | None = None) -> list[dict[str, Any]]:
    """Return the known defects as records, or the one of a name with its script.

    Raise RequestError, with the nearest names, for an unknown name.
    """
    entries = {defect.name: defect for defect in known_defects()}
    if name is not None and name not in entries:
        near = get_close_matches(name, entries, n=3, cutoff=0.4)
        hint = f"did you mean {' or '.join(near)}? " if near else ""
        raise RequestError(
            f"defect {name!r} is not known: {hint}`dem-harness defect` lists all {len(entries)}"
        )
    records = []
    for entry in entries.values() if name is None else [entries[name]]:
        record: dict[str, Any] = {key: getattr(entry, key) for key in DEFECT}
        record |= {"since": entry.since or "as long as is known", "until": entry.until or "today"}
        record |= {key: ", ".join(getattr(entry, key)) for key in PATTERNS}
        script = "" if name is None else defect_script(entry)
        records.append(record | ({"script": script} if script else {}))
    return records


def counts_text(counts: Mapping[str, int]) -> str:
    """Return numbers by word as a text."""
    return ", ".join(f"{number} {word}" for word, number in counts.items())


def _run(run: str | Path | Run) -> Run:
    return run if isinstance(run, Run) else read_run(Path(run))


def _changes_from_accepted(run: Run, folder: Path) -> pd.DataFrame:
    if not any((folder / engine).is_dir() for engine in run.meta.engines):
        raise RequestError(f"diff: {folder} has no accepted run of {', '.join(run.meta.engines)}")
    accepted = accepted_rows(folder, run.meta.engines)
    return compare(accepted, run.rows, covers_after=run.meta.covers)


def _distinct_names(runs: list[Any]) -> list[str]:
    """Return names for runs: their paths, else when they started; numbered where two are one."""
    names = [run.meta.started or "run" if isinstance(run, Run) else str(run) for run in runs]
    return [
        name if names.count(name) == 1 else f"{name} ({place})"
        for place, name in enumerate(names, 1)
    ]


def _other_facts(first: Meta, last: Meta) -> list[dict[str, str]]:
    """Return what else than rows differs between two runs."""
    before, after = _facts(first), _facts(last)
    return [
        {"name": name, "before": before.get(name, "none"), "after": after.get(name, "none")}
        for name in {**before, **after}
        if before.get(name) != after.get(name)
    ]


def _facts(meta: Meta) -> dict[str, str]:
    facts = {"level": meta.level, "cases": ", ".join(meta.cases), "rows": meta.only,
             "platform": meta.platform, "dem-harness": meta.harness_version}  # fmt: skip
    return facts | {f"engine {n}": version or "missing" for n, version in meta.engines.items()}
