"""What was measured, held against the baseline: a row for every quantity of every record."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from harness.comparison.baseline_record import BaselineRecord, name_in_cell
from harness.comparison.divergence import Comparison, compare_series
from harness.comparison.metadata_diff import changed_parameters, metadata_changes
from harness.comparison.regression_tolerances import Allowed, ByCase, Override
from harness.comparison.triage import Triage, of_divergence, of_error
from harness.comparison.verdicts import Check, Kind, Verdict, judge, not_tested
from harness.errors import EngineError, RequestError

INPUT = frozenset({"step_s"})
"""Quantities that a run is given: one that moved is a wrong input, not a result."""

Family = tuple[str, ...]


@dataclass(frozen=True)
class Baseline:
    """The records that were accepted, by name, and the exceptions to their tolerances.

    ``digest`` stands for the contents of the files.
    """

    records: Mapping[str, BaselineRecord]
    where: str = ""
    overrides: Sequence[Override] = ()
    digest: str = ""

    def of_level(self, level: str) -> list[BaselineRecord]:
        """Return the records that a level of ``verify`` makes, by name."""
        return [one for name, one in sorted(self.records.items()) if level in one.levels]


@dataclass(frozen=True)
class Expected:
    """Which records of a baseline a run must have, and what explains one that is missing.

    Records of the ``engines`` (and solvers) and ``cases`` of the run are expected. ``errors`` are
    those of records whose run died, by name; ``reason`` returns why a record could not be made,
    or nothing: then that it is missing is a failure.
    """

    engines: Collection[str]
    cases: Collection[str]
    errors: Mapping[str, EngineError] = field(default_factory=dict)
    reason: Callable[[BaselineRecord], str] = lambda _: ""

    def covers(self, record: BaselineRecord) -> bool:
        """Return whether a record is one of the run's."""
        return record.engine in self.engines and record.case in self.cases


@dataclass(frozen=True)
class Regression:
    """The rows of a run against its baseline, and the series that left their bands."""

    checks: tuple[Check, ...] = ()
    divergences: tuple[Comparison, ...] = ()


@dataclass
class _Rows:
    """Rows in order; those of numbers and of series by the family of their record."""

    allowed: Allowed
    checks: list[Check] = field(default_factory=list)
    divergences: list[Comparison] = field(default_factory=list)
    families: list[Family] = field(default_factory=list)
    classes: dict[Family, str] = field(default_factory=dict)

    def add(self, check: Check, family: Family = ()) -> None:
        self.checks.append(check)
        self.families.append(family)


def against_baseline(
    measured: Sequence[BaselineRecord],
    baseline: Baseline,
    level: str,
    expected: Expected,
    tolerances: ByCase,
) -> Regression:
    """Hold what was measured at a level against the baseline, within the cases' tolerances.

    A record that is expected and missing fails with its error, is *not tested* where there is a
    reason, and fails where nothing explains it. A record without a baseline is not tested.
    """
    found = {record.name: record for record in measured}
    rows = _Rows(Allowed(tolerances, baseline.overrides))
    if not baseline.of_level(level):
        name, where = row_name(f"level {level}"), baseline.where or "any folder"
        reason_none = (
            f"no record of this level in {where}; `dem-harness baseline accept` writes them"
        )
        return Regression((not_tested(name, Kind.REGRESSION, reason_none),))
    for known in baseline.of_level(level):
        if known.name in found:
            _compare(found[known.name], known, rows)
        elif expected.covers(known):
            rows.add(_missing(known, expected))
    for record in measured:
        if record.name not in baseline.records:
            reason_new = "it has no baseline; `dem-harness baseline accept` writes one"
            rows.add(not_tested(row_name(record.name), Kind.REGRESSION, reason_new))
    return Regression(tuple(_with_relatives(rows)), tuple(rows.divergences))


def row_name(record: str, quantity: str = "") -> str:
    """Return the name of a row."""
    return f"baseline: {record}{f': {quantity}' if quantity else ''}"


def _missing(known: BaselineRecord, expected: Expected) -> Check:
    name, error = row_name(known.name), expected.errors.get(known.name)
    if error is not None:
        return _failed(name, f"{error.kind}: {error}", of_error(error))
    reason = expected.reason(known)
    if reason:
        return not_tested(name, Kind.REGRESSION, reason)
    return _failed(name, "it was not measured, and nothing says why", Triage.MISSING)


def _failed(name: str, note: str, triage: str) -> Check:
    nan = math.nan
    return Check(
        name, Kind.REGRESSION, "", nan, nan, nan, nan, Verdict.FAIL, "", note, triage
    )  # fmt: skip


def explained_by_cells(rows: Sequence[Check], judged: Iterable[Check]) -> tuple[Check, ...]:
    """Return rows against the baseline, with those told apart that a cell of the run explains.

    A baseline is that of one release. In another a value may have moved, or be missing, because of
    a known defect or a submodel that is not there: then the judged rows of its cell say so, and
    those of the same quantity. Where one of them fails, or holds, the row stays a failure.
    """
    cells: dict[str, list[Check]] = {}
    for check in judged:
        if check.cell is not None and not check.cell.invariance:
            cells.setdefault(row_name(name_in_cell(check.cell)), []).append(check)
    return tuple(_explained(row, cells) for row in rows)


def _explained(row: Check, cells: Mapping[str, list[Check]]) -> Check:
    if row.verdict is not Verdict.FAIL:
        return row
    record, _, quantity = row.name.removeprefix("baseline: ").partition(": ")
    found = cells.get(row_name(record), [])
    if quantity:
        found = [check for check in found if check.name.endswith(f": {quantity}")]
    verdicts = {check.verdict for check in found if check.verdict is not Verdict.FINDING}
    for verdict in (Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED):
        if verdict in verdicts and not verdicts & {Verdict.FAIL, Verdict.PASS}:
            why = next(check.note for check in found if check.verdict is verdict)
            note = "; ".join(filter(None, (why, row.note if quantity else "")))
            return replace(row, verdict=verdict, note=note)
    return row


def _compare(record: BaselineRecord, known: BaselineRecord, rows: _Rows) -> None:
    """Add the rows of one record."""
    changed = changed_parameters(record.parameters, known.parameters)
    note = "; ".join([*changed, *metadata_changes(record, known)])
    family = (record.engine, record.case, *record.family) if record.family else ()
    class_of_series = ""
    if known.series is not None and not changed:
        class_of_series = _series(record, known, note, rows)
        if class_of_series and family:
            rows.classes[family] = class_of_series
    for quantity, wanted in known.quantities.items():
        name = row_name(known.name, quantity)
        if quantity not in record.quantities:
            rows.add(_failed(name, "it is not measured any more", Triage.MISSING))
            continue
        here = record.quantities[quantity]
        width, exception = rows.allowed.of(record.case, known.name, quantity)
        remark = "; ".join(filter(None, (note, exception and f"override {exception!r}")))
        row = judge(
            name, Kind.REGRESSION, here.value, wanted.value, replace(width, unit=wanted.unit),
            uncertainty=here.uncertainty, note=remark,
        )  # fmt: skip
        if changed:
            row = replace(row, verdict=Verdict.FAIL, triage=f"{Triage.WRONG_INPUT}: {changed[0]}")
        elif row.verdict is Verdict.FAIL and quantity in INPUT:
            row = replace(row, triage=f"{Triage.WRONG_INPUT}: {quantity} is not the baseline's")
        elif row.verdict is Verdict.FAIL and class_of_series:
            row = replace(row, triage=class_of_series)
        rows.add(row, family)


def _series(record: BaselineRecord, known: BaselineRecord, note: str, rows: _Rows) -> str:
    """Add one row for the series of a record, its worst column; return the class of a failure."""
    name = row_name(known.name, "series")
    assert known.series is not None
    width, _ = rows.allowed.of(record.case, known.name, "series")
    if record.series is None:
        rows.add(_failed(name, "its series was not recorded", Triage.MISSING))
        return str(Triage.MISSING)
    try:
        columns = compare_series(
            known.name, record.series, known.series, width.relative, width.absolute
        )
    except RequestError as error:
        rows.add(_failed(name, str(error), Triage.MISSING))
        return str(Triage.MISSING)
    now, then = (f"{one.engine} {one.engine_version}" for one in (record, known))
    columns = [
        replace(c, run_label=f"this run, {now}", reference_label=f"baseline, {then}")
        for c in columns
    ]
    diverged = [column for column in columns if not column.holds]
    rows.divergences += diverged
    worst = max(columns, key=_over_band)
    triage = earliest(diverged)
    rows.add(
        Check(
            f"{name}, largest difference of {worst.column}",
            Kind.REGRESSION,
            "",
            worst.largest,
            0.0,
            0.0,
            worst.band,
            Verdict.FAIL if diverged else Verdict.PASS,
            width.reason,
            note,
            triage,
        )
    )
    return triage


def _over_band(column: Comparison) -> float:
    size = column.largest / column.band if column.band > 0 else column.largest
    return size if math.isfinite(size) else math.inf


def earliest(diverged: Sequence[Comparison]) -> str:
    """Return the class of the column that left its band first, empty if none did."""
    found = [d for d in (column.divergence for column in diverged) if d is not None]
    if not found:
        return ""
    first = min(found, key=lambda d: d.time)
    return of_divergence(replace(first, stays=any(d.stays for d in found)))


def _with_relatives(rows: _Rows) -> list[Check]:
    """Give a failed number without a series the class of a failed series of its family.

    A number that comes from many runs keeps no series, but one run of its family does: if that
    left its band, the number moved for the same cause.
    """
    found = []
    for check, family in zip(rows.checks, rows.families, strict=True):
        beside = rows.classes.get(family, "")
        if check.verdict is Verdict.FAIL and check.triage == Triage.OUT_OF_TOLERANCE and beside:
            check = replace(check, triage=f"{beside} (series of the same family)")
        found.append(check)
    return found
