"""Stored runs and known defects: ``diff``, ``accept`` and ``defect``."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from harness.errors import RequestError
from harness.report.notebook import Summarized
from harness.results.compare import Change, compare, counts_of_changes, regressions
from harness.results.defects import KnownDefect
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
from harness.store.runs import Run, json_records, read_run
from harness.workflows.lists import Listing

if TYPE_CHECKING:
    import pandas as pd

UNCHANGED = (Change.SAME, Change.ROUND_OFF, Change.WITHIN, Change.NOT_COMPARABLE)
SHOWN = (*KEY, "change", "value_before", "value_after", "moved_by", "unit_after", "in_tolerances",
         "in_uncertainties", "verdict_before", "verdict_after", "note_after")  # fmt: skip


class Fact(NamedTuple):
    """What else than rows is not the same in two runs."""

    name: str
    before: str
    after: str


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
    facts: tuple[Fact, ...] = ()

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

    @cached_property
    def changes(self) -> pd.DataFrame:
        """Return the rows that changed in any step, without those within their tolerance."""
        import pandas as pd

        rows = pd.concat(self.steps, ignore_index=True)
        changed = rows[~rows["change"].isin(UNCHANGED)]
        return changed[["run_before", "run_after", *SHOWN]].reset_index(drop=True)

    def trend(self) -> pd.DataFrame:
        """Return the values of all rows: index the key, a column for each run."""
        import pandas as pd

        names = self.names[-len(self.runs) :]
        named = zip(names, self.runs, strict=True)
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
            "metadata": [fact._asdict() for fact in self.facts],
            "rows": json_records(self.changes),
        }

    def summary(self) -> dict[str, str]:
        """Return what became of the rows in each step, and what else differs."""
        lines = {}
        for step, (before, after) in zip(self.steps, pairwise(self.names), strict=True):
            numbers = [f"{number} {change}" for change, number in counts_of_changes(step).items()]
            lines[f"{before} to {after}"] = ", ".join(numbers) or "no rows"
        return lines | {fact.name: f"{fact.before} → {fact.after}" for fact in self.facts}

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
    if ACCEPTED in runs:
        others = [run for run in runs if run != ACCEPTED]
        if len(runs) != 2 or len(others) != 1:
            raise RequestError("diff: 'accepted' goes with one run")
        return _from_accepted(others[0], accepted or accepted_folder())
    names = _distinct_names(runs)
    found = tuple(run if isinstance(run, Run) else read_run(Path(run)) for run in runs)
    steps = tuple(
        after.changes_from(before).assign(run_before=first, run_after=second)
        for (first, second), (before, after) in zip(pairwise(names), pairwise(found), strict=True)
    )
    return RunDiff(names, found, steps, _facts(found[0], found[-1]))


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
        rows = self.to_frame()[list(SHOWN)]
        return {
            "folder": str(self.folder),
            "files": [str(file) for file in self.files],
            "counts": counts_of_changes(self.changes),
            "rows": json_records(rows),
        }

    def summary(self) -> dict[str, str]:
        """Return the files that changed, and how many rows in what way."""
        numbers = [f"{n} {change}" for change, n in counts_of_changes(self.changes).items()]
        files = ", ".join(str(file) for file in self.files) or "none: the run is what was accepted"
        return {"rows": ", ".join(numbers) or "none", "files changed": files}


def accept(run: str | Path | Run, folder: Path | None = None) -> Acceptance:
    """Accept a run: merge its rows into the accepted runs; review the change with ``git diff``.

    Into the project's folder unless one is given. Raise RequestError for a folder that is no run,
    for a run in which an engine died, and for the accepted runs of an installed package.
    """
    target = folder or writable_folder()
    found = run if isinstance(run, Run) else read_run(Path(run))
    before = accepted_rows(target, found.meta.engines)
    changes = compare(before, found.rows, scope_after=found.meta.scope)
    return Acceptance(target, tuple(accept_rows(found, target)), changes)


class DefectInfo(NamedTuple):
    """A known defect and the script that shows it with the engine alone."""

    defect: KnownDefect
    script: str = ""

    def to_json(self) -> dict[str, Any]:
        """Return its fields as text, and the script where it was read."""
        entry = self.defect
        names = ("name", "engine", "kind", "cause", "upstream", "effect")
        record: dict[str, Any] = {name: getattr(entry, name) for name in names}
        record |= {"since": entry.since or "as long as is known", "until": entry.until or "today"}
        for name in ("cases", "laws", "systems", "variations"):
            record[name] = ", ".join(getattr(entry, name))
        return record | ({"script": self.script} if self.script else {})


def defects(name: str | None = None) -> Listing[DefectInfo]:
    """Return the known defects, or the one of a name with its script.

    Raise RequestError, with the nearest names, for an unknown name.
    """
    known = {defect.name: defect for defect in known_defects()}
    if name is None:
        return Listing(DefectInfo(defect) for defect in known.values())
    if name not in known:
        near = get_close_matches(name, known, n=3, cutoff=0.4)
        hint = f"did you mean {' or '.join(near)}? " if near else ""
        raise RequestError(
            f"defect {name!r} is not known: {hint}`dem-harness defect` lists all {len(known)}"
        )
    return Listing([DefectInfo(known[name], defect_script(known[name]))])


def _from_accepted(run: str | Path | Run, folder: Path) -> RunDiff:
    found = run if isinstance(run, Run) else read_run(Path(run))
    if not any((folder / engine).is_dir() for engine in found.meta.engines):
        raise RequestError(f"diff: {folder} has no accepted run of {', '.join(found.meta.engines)}")
    compared = found.against(accepted_rows(folder, found.meta.engines))
    assert compared.changes is not None
    (name,) = _distinct_names([run])
    step = compared.changes.assign(run_before=ACCEPTED, run_after=name)
    return RunDiff((ACCEPTED, name), (compared,), (step,))


def _distinct_names(runs: tuple[Any, ...] | list[Any]) -> tuple[str, ...]:
    """Return names for runs: their paths, else when they started; numbered where two are one."""
    names = [run.meta.started or "run" if isinstance(run, Run) else str(run) for run in runs]
    return tuple(
        name if names.count(name) == 1 else f"{name} ({place})"
        for place, name in enumerate(names, 1)
    )


def _facts(before: Run, after: Run) -> tuple[Fact, ...]:
    """Return what else than rows differs: level, cases, engines, platform, scripts."""
    first, second = _described(before), _described(after)
    pairs = [Fact(n, first.get(n, "none"), second.get(n, "none")) for n in {**first, **second}]
    return tuple(fact for fact in pairs if fact.before != fact.after)


def _described(run: Run) -> Mapping[str, str]:
    meta = run.meta
    facts = {"level": meta.level, "cases": ", ".join(meta.cases), "rows": meta.only,
             "platform": meta.platform, "dem-harness": meta.harness_version}  # fmt: skip
    facts |= {f"engine {name}": version or "missing" for name, version in meta.engines.items()}
    digests = {name: hashlib.sha256(text.encode()) for name, text in run.scripts.items()}
    return facts | {f"script {name}": d.hexdigest()[:12] for name, d in digests.items()}
