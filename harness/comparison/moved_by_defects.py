"""Rows against the baseline of one release that known defects of another, or of it, have moved.

A defect of one of the two moves the recorded run, also where the limit of a small step holds: by
what both runs, step by step with the defects of each, differ. Another size stays a failure.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from harness.comparison.known_defects import KnownDefect, Prediction, merged
from harness.comparison.regression import BaselineRecord, name_in_cell, row_name
from harness.comparison.verdicts import Check, Verdict

UNRECORDED = 1e-9
"""Sizes up to which a quantity has no value in a record."""

AGAIN = ("", "continued with a setup")
"""What a run in another release is: its values, and the same run made again."""


def moved_by_defects(
    rows: Sequence[Check],
    judged: Iterable[Check],
    records: Mapping[str, BaselineRecord],
    defects: Sequence[KnownDefect],
    versions: Mapping[str, str],
) -> tuple[Check, ...]:
    """Return rows against the baseline, failures of the size that defects predict marked.

    ``judged`` are the checks of the run with what predicts their sizes, ``records`` those of the
    baseline by name, and ``versions`` the engines' that ran.
    """
    of_rows = {}
    for check in judged:
        if check.cell is not None and not check.cell.invariance and hasattr(check.predict, "moved"):
            quantity = check.name.rpartition(": ")[2]
            of_rows[row_name(name_in_cell(check.cell), quantity)] = (check, quantity)
    moved = []
    for row in rows:
        if row.verdict is Verdict.FAIL and row.name in of_rows:
            check, quantity = of_rows[row.name]
            assert check.cell is not None
            record = records[name_in_cell(check.cell)]
            row = _marked(row, check, quantity, record, defects, versions)
        moved.append(row)
    return tuple(moved)


def _marked(
    row: Check,
    check: Check,
    quantity: str,
    record: BaselineRecord,
    defects: Sequence[KnownDefect],
    versions: Mapping[str, str],
) -> Check:
    here = _of_runs(check, defects, versions)
    there = _of_runs(check, defects, {record.engine: record.engine_version})
    apart = [one for one in (*here, *there) if (one in here) is not (one in there)]
    known = record.quantities.get(quantity)
    if not apart or known is None:
        return row
    there_is_none = math.isnan(row.value)
    difference = (0.0 if there_is_none else row.value) - known.value
    width = UNRECORDED if there_is_none else 2.0 * row.tolerance
    try:
        size = check.predict.moved(merged(here), merged(there), width)  # type: ignore[union-attr]
    except (ArithmeticError, ValueError) as error:
        return replace(row, note=f"{row.note}; what defects predict cannot be computed: {error}")
    names = " and ".join(f"{one.name} ({'here' if one in here else 'there'})" for one in apart)
    said = f"{names} predict a difference of {size}, it is {difference:.6g}"
    note = "; ".join(filter(None, (*(one.note for one in apart), said, row.note)))
    if not size.includes(difference):
        return replace(row, note="; ".join(filter(None, (said, row.note))))
    return replace(row, verdict=Verdict.KNOWN_DEFECT, note=note, triage="")


def _of_runs(
    check: Check, defects: Sequence[KnownDefect], versions: Mapping[str, str]
) -> list[KnownDefect]:
    """Return the defects of a release that a run of a check's cell can be computed with."""
    assert check.cell is not None
    ways = [replace(check, cell=replace(check.cell, invariance=name)) for name in AGAIN]
    return [
        defect
        for defect in defects
        if _computed(defect.predicts) and any(defect.concerns(way, versions) for way in ways)
    ]


def _computed(prediction: Prediction) -> bool:
    return bool(prediction.law or prediction.rules or prediction.scheme)
