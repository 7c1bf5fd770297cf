"""Hold what was measured against the committed baseline: a row for every quantity of every record.

A record is what one run, or one search, left in numbers and a series. How far it may be from its
baseline is what its case allows. The same script, binary and machine give the
same bits: over ways to start an engine, over ranks and repetitions the spread is exactly 0. What a
case allows is what another compiler, processor or release does to the rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Required, TypedDict

from harness.comparison.compare import compare
from harness.comparison.series import Comparison, Series, compare_series
from harness.comparison.verdicts import (
    Cell,
    Check,
    Kind,
    Tolerance,
    Triage,
    Verdict,
    failed,
    judge,
    not_tested,
    of_divergence,
    of_error,
)
from harness.errors import EngineError, RequestError
from harness.observables.provenance import Provenance
from harness.observables.row import Row

UNSTATED = Tolerance(
    "", 0.0, 1e-9, "the case states none: round-off of 1e5 steps, and two orders of ten above"
)
"""Where a case says nothing of a quantity or series."""

ByCase = Mapping[str, Mapping[str, Tolerance]]
"""Tolerances by the name of the case, then of the quantity; ``series`` is the band of series."""


def allowed_change(tolerances: ByCase, case: str, quantity: str) -> Tolerance:
    """Return the tolerance of a case's quantity, that of round-off where the case states none."""
    return tolerances.get(case, {}).get(quantity, UNSTATED)


@dataclass(frozen=True)
class BaselineRecord:
    """A record, measured now or kept in the baseline; two of the same name are compared.

    ``name`` is ``engine/what`` and the path of its file. ``parameters`` is
    JSON-ready. ``levels`` are the levels of ``verify`` that run it. ``case`` is the name of the
    case, ``label`` says in short what the record is, and records of one ``family`` tell about
    each other.
    """

    name: str
    parameters: Mapping[str, Any]
    quantities: Mapping[str, Row]
    engine: str
    engine_version: str
    how: str = ""
    platform: str = ""
    script: str = ""
    script_sha256: str = ""
    levels: tuple[str, ...] = ()
    case: str = ""
    label: str = ""
    family: tuple[str, ...] = ()
    series: Series | None = field(default=None, repr=False)

    def at(self, level: str, platform: str) -> BaselineRecord:
        """Return the case as measured at a level of ``verify``, on a platform."""
        return replace(self, levels=(level,), platform=platform)


class RecordOrigin(TypedDict, total=False):
    """Who made a case, as fields of it."""

    engine: Required[str]
    engine_version: Required[str]
    how: str
    script: str
    script_sha256: str


def record_name(engine: str, case: str, words: str) -> str:
    """Return ``engine/case-words``, of the words letters, digits, points and underscores only."""
    kept = "".join(c if c.isalnum() or c in "._" else " " for c in words)
    return f"{engine}/{case}-{'-'.join(kept.split())}"


def name_in_cell(cell: Cell) -> str:
    """Return the name of the record of a cell's values, in its engine."""
    return record_name(cell.engine, cell.case, f"{cell.submodel} {cell.system}")


def made_by(provenance: Provenance | None, solver: str = "", version: str = "") -> RecordOrigin:
    """Return who made a case: an engine, or a solver of this harness in its ``version``."""
    if provenance is None:
        return {"engine": solver, "engine_version": f"dem-harness {version}"}
    return {
        "engine": provenance.engine,
        "engine_version": provenance.engine_version,
        "how": provenance.how,
        "script": provenance.script,
        "script_sha256": provenance.script_sha256,
    }


DERIVED = 1e-12
"""Part of itself that a derived parameter, as a duration, may differ by between processors: 2e-14
were seen. What anybody sets apart differs by more."""


def changed_parameters(now: Mapping[str, Any], accepted: Mapping[str, Any]) -> list[str]:
    """Say which parameters differ; one that only one side knows is no difference of the case."""
    lines = []
    for key, wanted in accepted.items():
        if key not in now:
            continue
        if isinstance(wanted, Mapping) and isinstance(now[key], Mapping):
            lines += [f"{key} {text}" for text in changed_parameters(now[key], wanted)]
        elif not _same(now[key], wanted):
            lines.append(f"{key} = {now[key]!r}, the baseline's is {wanted!r}")
    return lines


def _same(now: Any, wanted: Any) -> bool:
    """Return whether two values are one; of a derived one the last bits are the processor's."""
    if isinstance(now, float) and isinstance(wanted, float):
        return math.isclose(now, wanted, rel_tol=DERIVED)
    return bool(now == wanted)


def metadata_changes(case: BaselineRecord, accepted: BaselineRecord) -> list[str]:
    """Say what differs between the two runs besides the case."""
    lines = []
    if case.engine_version != accepted.engine_version:
        lines.append(f"baseline of {accepted.engine} {accepted.engine_version}")
    if case.platform != accepted.platform:
        lines.append(f"baseline of {accepted.platform}")
    if case.script_sha256 != accepted.script_sha256:
        lines.append(f"script {case.script} is not the baseline's")
    return lines


INPUT = frozenset({"step_s"})
"""Quantities that a run is given: one that moved is a wrong input, not a result."""

Family = tuple[str, ...]


@dataclass(frozen=True)
class Baseline:
    """The records that were accepted, by name.

    ``digest`` stands for the contents of the files.
    """

    records: Mapping[str, BaselineRecord]
    where: str = ""
    digest: str = ""

    def of_level(self, level: str) -> list[BaselineRecord]:
        """Return the records that a level of ``verify`` makes, by name."""
        return [record for name, record in sorted(self.records.items()) if level in record.levels]


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

    tolerances: ByCase
    checks: list[Check] = field(default_factory=list)
    divergences: list[Comparison] = field(default_factory=list)
    families: list[Family] = field(default_factory=list)
    classes: dict[Family, str] = field(default_factory=dict)

    def allowed(self, case: str, quantity: str) -> Tolerance:
        return allowed_change(self.tolerances, case, quantity)

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
    records = {record.name: record for record in measured}
    rows = _Rows(tolerances)
    if not baseline.of_level(level):
        name, where = row_name(f"level {level}"), baseline.where or "any folder"
        reason_none = (
            f"no record of this level in {where}; `dem-harness baseline accept` writes them"
        )
        return Regression((not_tested(name, Kind.REGRESSION, reason_none),))
    for accepted in baseline.of_level(level):
        if accepted.name in records:
            _compare(records[accepted.name], accepted, rows)
        elif expected.covers(accepted):
            rows.add(_missing(accepted, expected))
    for record in measured:
        if record.name not in baseline.records:
            reason_new = "it has no baseline; `dem-harness baseline accept` writes one"
            rows.add(not_tested(row_name(record.name), Kind.REGRESSION, reason_new))
    return Regression(tuple(_with_relatives(rows)), tuple(rows.divergences))


def row_name(record: str, quantity: str = "") -> str:
    """Return the name of a row."""
    return f"baseline: {record}{f': {quantity}' if quantity else ''}"


def _missing(accepted: BaselineRecord, expected: Expected) -> Check:
    name, error = row_name(accepted.name), expected.errors.get(accepted.name)
    if error is not None:
        return failed(name, Kind.REGRESSION, f"{error.kind}: {error}", of_error(error))
    reason = expected.reason(accepted)
    if reason:
        return not_tested(name, Kind.REGRESSION, reason)
    return failed(
        name, Kind.REGRESSION, "it was not measured, and nothing says why", Triage.MISSING
    )


def explained_by_cells(rows: Sequence[Check], judged: Iterable[Check]) -> tuple[Check, ...]:
    """Return rows against the baseline, with failures that a cell of the run explains marked.

    A baseline is that of one release. In another a value may have moved, or be missing, because of
    a known defect or a submodel that is not there: then the judged rows of its cell say so, and
    those of the same quantity. Where one of them fails, or holds, the row stays a failure, as does
    one of a run with other parameters: no cell explains these.
    """
    cells: dict[str, list[Check]] = {}
    for check in judged:
        if check.cell is not None and not check.cell.invariance:
            cells.setdefault(row_name(name_in_cell(check.cell)), []).append(check)
    return tuple(_explained(row, cells) for row in rows)


def _explained(row: Check, cells: Mapping[str, list[Check]]) -> Check:
    if row.verdict is not Verdict.FAIL or row.triage.startswith(Triage.WRONG_INPUT):
        return row
    record, _, quantity = row.name.removeprefix("baseline: ").partition(": ")
    checks = cells.get(row_name(record), [])
    if quantity:
        checks = [check for check in checks if check.name.endswith(f": {quantity}")]
    verdicts = {check.verdict for check in checks if check.verdict is not Verdict.FINDING}
    for verdict in (Verdict.KNOWN_DEFECT, Verdict.FIXED, Verdict.NOT_TESTED):
        if verdict in verdicts and not verdicts & {Verdict.FAIL, Verdict.PASS}:
            why = next(check.note for check in checks if check.verdict is verdict)
            note = "; ".join(filter(None, (why, row.note if quantity else "")))
            return replace(row, verdict=verdict, note=note)
    return row


def _compare(record: BaselineRecord, accepted: BaselineRecord, rows: _Rows) -> None:
    changed = changed_parameters(record.parameters, accepted.parameters)
    note = "; ".join([*changed, *metadata_changes(record, accepted)])
    family = (record.engine, record.case, *record.family) if record.family else ()
    class_of_series = ""
    if accepted.series is not None and not changed:
        class_of_series = _series(record, accepted, note, rows)
        if class_of_series and family:
            rows.classes[family] = class_of_series

    def width(wanted: Row, _: Row) -> float:
        return rows.allowed(record.case, wanted.name).width(wanted.value)

    for quantity, pair in compare(accepted.quantities, record.quantities, width).items():
        if pair.before is None:
            continue
        name, wanted = row_name(accepted.name, quantity), pair.before
        if pair.after is None:
            note_gone = "it is not measured any more"
            rows.add(failed(name, Kind.REGRESSION, note_gone, Triage.MISSING))
            continue
        tolerance = rows.allowed(record.case, quantity)
        row = judge(
            name, Kind.REGRESSION, pair.after.value, wanted.value,
            replace(tolerance, unit=wanted.unit), uncertainty=pair.after.uncertainty, note=note,
        )  # fmt: skip
        if changed:
            row = replace(row, verdict=Verdict.FAIL, triage=f"{Triage.WRONG_INPUT}: {changed[0]}")
        elif row.verdict is Verdict.FAIL and quantity in INPUT:
            row = replace(row, triage=f"{Triage.WRONG_INPUT}: {quantity} is not the baseline's")
        elif row.verdict is Verdict.FAIL and class_of_series:
            row = replace(row, triage=class_of_series)
        rows.add(row, family)


def _series(record: BaselineRecord, accepted: BaselineRecord, note: str, rows: _Rows) -> str:
    """Add one row for the series of a record, its worst column; return the class of a failure."""
    name = row_name(accepted.name, "series")
    assert accepted.series is not None
    width = rows.allowed(record.case, "series")
    if record.series is None:
        rows.add(failed(name, Kind.REGRESSION, "its series was not recorded", Triage.MISSING))
        return str(Triage.MISSING)
    try:
        columns = compare_series(
            accepted.name, record.series, accepted.series, width.relative, width.absolute
        )
    except RequestError as error:
        rows.add(failed(name, Kind.REGRESSION, str(error), Triage.MISSING))
        return str(Triage.MISSING)
    now, then = (f"{version.engine} {version.engine_version}" for version in (record, accepted))
    columns = [
        replace(c, run_label=f"this run, {now}", reference_label=f"baseline, {then}")
        for c in columns
    ]
    diverged = [column for column in columns if not column.holds]
    rows.divergences += diverged
    worst = max(columns, key=_over_band)
    triage = earliest(diverged)
    row = Check(
        f"{name}, largest difference of {worst.column}",
        worst.largest,
        0.0,
        "",
        expected=0.0,
        note=note,
        kind=Kind.REGRESSION,
        tolerance=worst.band,
        verdict=Verdict.FAIL if diverged else Verdict.PASS,
        why=width.reason,
        triage=triage,
    )
    rows.add(row)
    return triage


def _over_band(column: Comparison) -> float:
    size = column.largest / column.band if column.band > 0 else column.largest
    return size if math.isfinite(size) else math.inf


def earliest(diverged: Sequence[Comparison]) -> str:
    """Return the class of the column that left its band first, empty if none did."""
    divergences = [d for d in (column.divergence for column in diverged) if d is not None]
    if not divergences:
        return ""
    first = min(divergences, key=lambda d: d.time)
    return of_divergence(replace(first, stays=any(d.stays for d in divergences)))


def _with_relatives(rows: _Rows) -> list[Check]:
    """Give a failed number without a series the class of a failed series of its family.

    A number that comes from many runs keeps no series, but one run of its family does: if that
    left its band, the number moved for the same cause.
    """
    checks = []
    for check, family in zip(rows.checks, rows.families, strict=True):
        of_series = rows.classes.get(family, "")
        if check.verdict is Verdict.FAIL and check.triage == Triage.OUT_OF_TOLERANCE and of_series:
            check = replace(check, triage=f"{of_series} (series of the same family)")
        checks.append(check)
    return checks
