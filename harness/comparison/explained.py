"""Rows of runs at equal steps, those that fail explained by known defects or conventions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from harness.comparison.known_defects import KnownDefect, concerned, explain, is_fixed
from harness.comparison.passing_rules import passing_rules
from harness.comparison.verdicts import Check, Triage, Verdict

MOST_SEARCHED = 50  # failing runs of which conventions are searched by which they would hold


def explained(
    checks: Iterable[Check], defects: Sequence[KnownDefect], versions: Mapping[str, str]
) -> tuple[Check, ...]:
    """Return the checks, those of runs with a known defect marked, and those where it is gone.

    ``versions`` are those of the engines by name. The note of another failure names the single
    conventions under which all rows of its run would hold.
    """
    checks = tuple(checks)
    runs: dict[int, list[int]] = {}
    for place, check in enumerate(checks):
        if check.trial is not None:
            runs.setdefault(id(check.trial), []).append(place)
    marked, searched = dict(enumerate(checks)), 0
    for places in runs.values():
        rows = [checks[place] for place in places]
        run, version = rows[0].trial, versions.get(rows[0].trial.engine, "")
        if any(row.verdict is Verdict.FAIL for row in rows):
            search = searched < MOST_SEARCHED
            after = list(_failing(rows, run, defects, version, search=search))
            searched += any(row.verdict is Verdict.FAIL for row in after)
        else:
            after = [_fixed(row, run, concerned(defects, run.place, version)) for row in rows]
        marked.update(zip(places, after, strict=True))
    return tuple(replace(check, trial=None) for check in marked.values())


def _failing(
    rows: Sequence[Check], run: Any, defects: Sequence[KnownDefect], version: str, *, search: bool
) -> Iterator[Check]:
    defect = explain(
        defects, run.place, version, run.scene, run.rules, run.outcome, run.holds
    )  # fmt: skip
    note = ""
    if defect is None and run.values and search:
        found = passing_rules(run.scene, run.rules, run.holds)
        note = f"passes under {', or under '.join(found)}" if found else ""
    for row in rows:
        if row.verdict is not Verdict.FAIL:
            yield row
        elif defect is None:
            yield replace(row, note="; ".join(filter(None, (row.note, note))))
        elif defect.undetermined:
            why = f"{defect.undetermined}; {defect.note}"
            yield replace(
                _with_defect(row, defect, why),
                verdict=Verdict.NOT_TESTED,
                triage=Triage.NOT_TESTED,
            )
        else:
            yield replace(_with_defect(row, defect, defect.note), verdict=Verdict.KNOWN_DEFECT)


def _with_defect(row: Check, defect: KnownDefect, note: str) -> Check:
    assert row.cell is not None
    cell = replace(row.cell, defect=defect.name)
    text = "; ".join(filter(None, (note, row.note)))
    return replace(row, cell=cell, note=text, engine_died=False)


def _fixed(row: Check, run: Any, here: Sequence[KnownDefect]) -> Check:
    if row.verdict is not Verdict.PASS:
        return row
    holds = partial(run.holds, only=row.name.rpartition(": ")[2])
    for defect in here:
        if is_fixed(defect, run.scene, run.rules, holds):
            marked = _with_defect(row, defect, f"no longer there: {defect.note}")
            return replace(marked, verdict=Verdict.FIXED)
    return row
