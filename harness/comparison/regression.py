"""What was measured, held against the baseline: a row for every quantity of every case."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.divergence import Comparison, compare_series
from harness.comparison.metadata_diff import changed_parameters, circumstances
from harness.comparison.regression_tolerances import Override, regression_tolerance
from harness.comparison.triage import Triage, of_divergence, of_error
from harness.comparison.verdicts import Check, Kind, Verdict, judge, not_tested
from harness.errors import EngineError, RequestError

INPUT = frozenset({"step_s"})
"""Quantities that a run is given: one that moved is a wrong input, not a result."""


@dataclass(frozen=True)
class Baseline:
    """The cases that were accepted, by name, and the exceptions to the table of tolerances."""

    cases: Mapping[str, BaselineRecord]
    where: str = ""
    overrides: Sequence[Override] = ()

    def of_level(self, level: str) -> list[BaselineRecord]:
        """Return the cases that a level of ``verify`` runs, by name."""
        return [case for name, case in sorted(self.cases.items()) if level in case.levels]


@dataclass(frozen=True)
class Regression:
    """The rows of a run against its baseline, and the series that left their bands."""

    checks: tuple[Check, ...] = ()
    parted: tuple[Comparison, ...] = ()


@dataclass
class _Rows:
    checks: list[Check] = field(default_factory=list)
    parted: list[Comparison] = field(default_factory=list)


def against_baseline(
    measured: Sequence[BaselineRecord],
    baseline: Baseline,
    level: str,
    *,
    engines: Collection[str],
    errors: Mapping[str, EngineError] | None = None,
    reason: Callable[[BaselineRecord], str] = lambda _: "it was not run",
) -> Regression:
    """Hold what was measured at a level against the baseline.

    Cases of other ``engines`` (and solvers) than these are left out. ``errors``
    are those of the cases whose run died, by name; a case that is missing without
    one is *not tested*, for the ``reason`` that is asked for. A case without a
    baseline is not tested either.
    """
    found, rows = {case.name: case for case in measured}, _Rows()
    if not baseline.of_level(level):
        name, where = row_name(f"level {level}"), baseline.where or "any folder"
        reason_none = f"no case of this level in {where}; `dem-harness baseline accept` writes them"
        return Regression((not_tested(name, Kind.REGRESSION, reason_none),))
    for known in baseline.of_level(level):
        if known.engine not in engines:
            continue
        if known.name in found:
            _compare(found[known.name], known, baseline.overrides, rows)
        elif errors and known.name in errors:
            rows.checks.append(_died(known, errors[known.name]))
        else:
            rows.checks.append(not_tested(row_name(known.name), Kind.REGRESSION, reason(known)))
    for case in measured:
        if case.name not in baseline.cases:
            reason_new = "it has no baseline; `dem-harness baseline accept` writes one"
            rows.checks.append(not_tested(row_name(case.name), Kind.REGRESSION, reason_new))
    return Regression(tuple(_with_relatives(rows)), tuple(rows.parted))


def row_name(case: str, quantity: str = "") -> str:
    """Return the name of a row."""
    return f"baseline: {case}{f': {quantity}' if quantity else ''}"


def _died(known: BaselineRecord, error: EngineError) -> Check:
    nan, note = math.nan, f"{error.kind}: {error}"
    return Check(
        row_name(known.name), Kind.REGRESSION, "", nan, nan, nan, nan, Verdict.FAIL, "", note,
        of_error(error),
    )  # fmt: skip


def _compare(
    case: BaselineRecord, known: BaselineRecord, overrides: Sequence[Override], rows: _Rows
) -> None:
    """Add the rows of one case."""
    changed = changed_parameters(case.parameters, known.parameters)
    note = "; ".join([*changed, *circumstances(case, known)])
    wrong = f"{Triage.WRONG_INPUT}: {changed[0]}" if changed else ""
    parted: list[Comparison] = []
    if known.series is not None and not changed:
        parted = _series(case, known, overrides, note, rows)
    class_of_series = earliest(parted)
    for quantity, wanted in known.quantities.items():
        name = row_name(known.name, quantity)
        if quantity not in case.quantities:
            rows.checks.append(not_tested(name, Kind.REGRESSION, "it is not measured any more"))
            continue
        here = case.quantities[quantity]
        width, exception = regression_tolerance(known.name, quantity, overrides)
        remark = "; ".join(filter(None, (note, exception and f"override {exception!r}")))
        row = judge(
            name, Kind.REGRESSION, here.value, wanted.value, replace(width, unit=wanted.unit),
            uncertainty=here.uncertainty, note=remark,
        )  # fmt: skip
        if changed:
            row = replace(row, verdict=Verdict.FAIL, triage=wrong)
        elif row.verdict is Verdict.FAIL and quantity in INPUT:
            row = replace(row, triage=f"{Triage.WRONG_INPUT}: {quantity} is not the baseline's")
        elif row.verdict is Verdict.FAIL and class_of_series:
            row = replace(row, triage=class_of_series)
        rows.checks.append(row)


def _series(
    case: BaselineRecord,
    known: BaselineRecord,
    overrides: Sequence[Override],
    note: str,
    rows: _Rows,
) -> list[Comparison]:
    """Add one row for the series of a case, its worst column; return the columns that parted."""
    name = row_name(known.name, "series")
    assert known.series is not None
    width, _ = regression_tolerance(known.name, "series", overrides)
    if case.series is None:
        rows.checks.append(not_tested(name, Kind.REGRESSION, "its series was not recorded"))
        return []
    try:
        columns = compare_series(
            known.name, case.series, known.series, width.relative, width.absolute
        )
    except RequestError as error:
        rows.checks.append(not_tested(name, Kind.REGRESSION, str(error)))
        return []
    now, then = (f"{one.engine} {one.engine_version}" for one in (case, known))
    columns = [
        replace(c, run_label=f"this run, {now}", reference_label=f"baseline, {then}")
        for c in columns
    ]
    parted = [column for column in columns if not column.holds]
    rows.parted += parted
    worst = max(columns, key=_over_band)
    holds = not parted
    lacking = [
        f"series incomplete: {text}" for text in {c.incomplete: 0 for c in columns if c.incomplete}
    ]
    note = "; ".join(filter(None, [note, *lacking]))
    rows.checks.append(
        Check(
            f"{name}, largest difference of {worst.column}",
            Kind.REGRESSION,
            "",
            worst.largest,
            0.0,
            0.0,
            worst.band,
            Verdict.PASS if holds else Verdict.FAIL,
            width.reason,
            note,
            earliest(parted) or "".join(lacking[:1]),
        )
    )
    return parted


def _over_band(column: Comparison) -> float:
    size = column.largest / column.band if column.band > 0 else column.largest
    return size if math.isfinite(size) else math.inf


def earliest(parted: Sequence[Comparison]) -> str:
    """Return the class of the column that left its band first, empty if none did."""
    found = [p for p in (column.divergence for column in parted) if p is not None]
    if not found:
        return ""
    first = min(found, key=lambda p: p.time)
    return of_divergence(replace(first, stays=any(p.stays for p in found)))


def _with_relatives(rows: _Rows) -> list[Check]:
    """Give a failed number without a series the class of the series that failed beside it.

    A critical angle keeps no series, but the path of the same contact at a
    fixed angle does: if that left its band, the angle moved for the same cause.
    """
    classes = {
        _family(check.name): check.triage
        for check in rows.checks
        if ": series" in check.name and check.verdict is Verdict.FAIL
    }
    found = []
    for check in rows.checks:
        beside = classes.get(_family(check.name), "")
        if check.verdict is Verdict.FAIL and check.triage == Triage.OUT_OF_TOLERANCE and beside:
            check = replace(check, triage=f"{beside} (series of the same contact or law)")
        found.append(check)
    return found


def _family(name: str) -> tuple[str, ...]:
    """Return engine, system and contact or law of a row."""
    engine, _, what = name.removeprefix("baseline: ").partition("/")
    words = what.split(":")[0].split("-")
    if words[0] == "tower" or words[0] == "impulse":
        return engine, "tower", words[1] if words[0] == "tower" else words[2]
    return engine, "incline", words[2] if len(words) > 2 else ""
