"""Rows of a run at equal steps, those that fail explained by a known defect or a convention."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from harness.comparison.known_defects import KnownDefect, concerned, explain, is_fixed
from harness.comparison.passing_rules import passing_rules
from harness.comparison.verdicts import Check, Triage, Verdict


def explained(
    rows: Sequence[Check],
    run: Any,
    defects: Sequence[KnownDefect],
    version: str,
    *,
    search: bool = True,
) -> list[Check]:
    """Return the rows of a run, marked where it has a known defect, or where one is gone.

    ``run`` has the ``place``, ``scene``, ``rules``, ``outcome`` and ``values`` of the run, and
    ``holds(motion, only)``; ``version`` is that of the engine. With ``search`` the note of another
    failure names the single conventions under which all rows would hold.
    """
    if any(row.verdict is Verdict.FAIL for row in rows):
        return list(_failing(rows, run, defects, version, search=search))
    here = concerned(defects, run.place, version)
    return [_fixed(row, run, here) for row in rows]


def _failing(
    rows: Sequence[Check], run: Any, defects: Sequence[KnownDefect], version: str, *, search: bool
) -> Iterator[Check]:
    what = (run.scene, run.rules, run.outcome, run.holds)
    defect = explain(defects, run.place, version, *what)
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
            marked = _with_defect(row, defect, f"{defect.undetermined}; {defect.note}")
            yield replace(marked, verdict=Verdict.NOT_TESTED, triage=Triage.NOT_TESTED)
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
