"""Stored runs and known defects: ``diff``, ``accept`` and ``defect``."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import pandas as pd

from harness.errors import RequestError
from harness.report.notebook import Summarized
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
from harness.workflows.lists import Listing

UNCHANGED = (Change.SAME, Change.ROUND_OFF, Change.WITHIN, Change.NOT_COMPARABLE)
COLUMNS = [*KEY, "change", "value_before", "value_after", "moved_by", "unit_after", "in_tolerances",
           "in_uncertainties", "verdict_before", "verdict_after", "note_after"]  # fmt: skip
DEFECT = ("name", "engine", "kind", "cause", "upstream", "effect")  # fields of a known defect
PATTERNS = ("cases", "laws", "systems", "variations")  # likewise, each a list


@dataclass(frozen=True, repr=False)
class RunDiff(Summarized):
    """What changed over runs that follow one another.

    ``steps`` are the changes between consecutive runs, with columns ``run_before`` and
    ``run_after``, the gravest first; ``facts`` is what else differs between the first run and the
    last. Against the accepted run ``runs`` is the one run.
    """

    names: tuple[str, ...]
    runs: tuple[Run, ...]
    steps: tuple[pd.DataFrame, ...]

    @property
    def status(self) -> int:
        """Return 1 where a verdict of the last run changed for the worse, else 0.

        Against the accepted run it is that of ``verify``: a value that moved counts, too.
        """
        last = self.steps[-1]
        if len(self.runs) == 1:
            return int(not regressions(last).empty)
        return int((last["change"] == Change.WORSE).any())

    @property
    def counts(self) -> dict[str, int]:
        """Return how many rows of the last step have each change."""
        return counts_of_changes(self.steps[-1])

    @property
    def facts(self) -> list[dict[str, str]]:
        """Return what else than rows differs between the first run and the last."""
        first, last = _facts(self.runs[0].meta), _facts(self.runs[-1].meta)
        return [
            {"name": name, "before": first.get(name, "none"), "after": last.get(name, "none")}
            for name in {**first, **last}
            if first.get(name) != last.get(name)
        ]

    @cached_property
    def changes(self) -> pd.DataFrame:
        """Return the rows that changed in any step, without those within their tolerance."""
        rows = pd.concat(self.steps, ignore_index=True)
        changed = rows[~rows["change"].isin(UNCHANGED)]
        return changed[["run_before", "run_after", *COLUMNS]].reset_index(drop=True)

    def trend(self) -> pd.DataFrame:
        """Return the values of all rows: index the key, a column for each run."""
        named = zip(self.names[-len(self.runs) :], self.runs, strict=True)
        return pd.DataFrame({name: run.rows.set_index(list(KEY))["value"] for name, run in named})

    def to_frame(self) -> pd.DataFrame:
        """Return :attr:`changes`."""
        return self.changes

    def to_json(self) -> dict[str, Any]:
        """Return status, counts, what else differs, and the changed rows, JSON-ready."""
        return {
            "status": self.status,
            "runs": list(self.names),
            "counts": self.counts,
            "metadata": self.facts,
            "rows": json_records(self.changes),
        }

    def summary(self) -> dict[str, str]:
        """Return what became of the rows in each step, and what else differs."""
        lines = {
            f"{before} to {after}": _text(counts_of_changes(step)) or "no rows"
            for step, (before, after) in zip(self.steps, pairwise(self.names), strict=True)
        }
        return lines | {fact["name"]: f"{fact['before']} → {fact['after']}" for fact in self.facts}

    def _repr_html_(self) -> str:
        return str(self.changes.to_html(index=False, na_rep=""))


def diff(*runs: str | Path | Run, accepted: Path | None = None) -> RunDiff:
    """Return what changed from run to run, each a folder or a ``Run``; three or more are a trend.

    The word ``accepted`` in place of one of two runs is the accepted rows of the other's engines,
    of the committed folder unless ``accepted`` is given. Raise RequestError for a folder that is
    no run, and for fewer than two runs.
    """
    if len(runs) < 2:
        raise RequestError("diff: needs two runs or more, or a run and the word 'accepted'")
    others = [run for run in runs if run != ACCEPTED]
    if len(others) < len(runs) and (len(runs), len(others)) != (2, 1):
        raise RequestError("diff: 'accepted' goes with one run")
    names, read = _distinct_names(others), tuple(map(_run, others))
    if len(read) == 1:
        return _from_accepted(names[0], read[0], accepted or accepted_folder())
    steps = tuple(
        after.changes_from(before).assign(run_before=first, run_after=second)
        for (first, second), (before, after) in zip(pairwise(names), pairwise(read), strict=True)
    )
    return RunDiff(tuple(names), read, steps)


@dataclass(frozen=True, repr=False)
class Acceptance(Summarized):
    """What was accepted: the files that changed, and the changes of their rows."""

    folder: Path
    files: tuple[Path, ...]
    changes: pd.DataFrame
    status = 0

    def to_frame(self) -> pd.DataFrame:
        """Return the rows that are not the same as before."""
        return self.changes[self.changes["change"] != Change.SAME].reset_index(drop=True)

    def to_json(self) -> dict[str, Any]:
        """Return folder, files, counts of changes, and the changed rows, JSON-ready."""
        return {
            "folder": str(self.folder),
            "files": [str(file) for file in self.files],
            "counts": counts_of_changes(self.changes),
            "rows": json_records(self.to_frame()[COLUMNS]),
        }

    def summary(self) -> dict[str, str]:
        """Return the files that changed, and how many rows in what way."""
        files = ", ".join(str(file) for file in self.files) or "none: the run is what was accepted"
        return {"rows": _text(counts_of_changes(self.changes)) or "none", "files changed": files}


def accept(run: str | Path | Run, folder: Path | None = None) -> Acceptance:
    """Accept a run: merge its rows into the accepted runs; review the change with ``git diff``.

    Into the project's folder unless one is given. Raise RequestError for a folder that is no run,
    for a run in which an engine died, and for the accepted runs of an installed package.
    """
    target, new = folder or writable_folder(), _run(run)
    before = accepted_rows(target, new.meta.engines)
    changes = compare(before, new.rows, scope_after=new.meta.scope)
    return Acceptance(target, tuple(accept_rows(new, target)), changes)


def defects(name: str | None = None) -> Listing:
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
    records = Listing()
    for entry in entries.values() if name is None else [entries[name]]:
        record: dict[str, Any] = {key: getattr(entry, key) for key in DEFECT}
        record |= {"since": entry.since or "as long as is known", "until": entry.until or "today"}
        record |= {key: ", ".join(getattr(entry, key)) for key in PATTERNS}
        script = "" if name is None else defect_script(entry)
        records.append(record | ({"script": script} if script else {}))
    return records


def _run(run: str | Path | Run) -> Run:
    return run if isinstance(run, Run) else read_run(Path(run))


def _from_accepted(name: str, run: Run, folder: Path) -> RunDiff:
    if not any((folder / engine).is_dir() for engine in run.meta.engines):
        raise RequestError(f"diff: {folder} has no accepted run of {', '.join(run.meta.engines)}")
    compared = run.against(accepted_rows(folder, run.meta.engines))
    assert compared.changes is not None
    step = compared.changes.assign(run_before=ACCEPTED, run_after=name)
    return RunDiff((ACCEPTED, name), (compared,), (step,))


def _distinct_names(runs: list[Any]) -> list[str]:
    """Return names for runs: their paths, else when they started; numbered where two are one."""
    names = [run.meta.started or "run" if isinstance(run, Run) else str(run) for run in runs]
    return [
        name if names.count(name) == 1 else f"{name} ({place})"
        for place, name in enumerate(names, 1)
    ]


def _facts(meta: Meta) -> dict[str, str]:
    facts = {"level": meta.level, "cases": ", ".join(meta.cases), "rows": meta.only,
             "platform": meta.platform, "dem-harness": meta.harness_version}  # fmt: skip
    return facts | {f"engine {n}": version or "missing" for n, version in meta.engines.items()}


def _text(counts: dict[str, int]) -> str:
    return ", ".join(f"{number} {change}" for change, number in counts.items())
