"""Judge a value: what is expected of it, a tolerance with its reason, the verdict that follows.

A check is a row with a verdict. There are four kinds that are never mixed, and findings, which are
shown and not judged. A failure has a class (:class:`Triage`), so that the next thing to look at is
known. Checks go to JSON and back by their own fields: there is no second description of a result,
and a number that is not finite is null there.
"""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Annotated, NamedTuple

from pydantic import Field, computed_field, field_serializer

from harness.comparison.series import Divergence
from harness.errors import (
    EngineError,
    EngineInputError,
    EngineLostAtomsError,
    EngineMemoryError,
    EngineNaNError,
    EngineTimeoutError,
)
from harness.observables.row import Number, Row
from harness.shown import Record


@dataclass(frozen=True)
class Tolerance:
    """An absolute and a relative tolerance; a difference within their sum passes."""

    unit: str
    absolute: float
    relative: float
    reason: str

    def width(self, expected: float) -> float:
        """Return the tolerance about an expected value."""
        return self.absolute + self.relative * abs(expected)


class Triage(StrEnum):
    """The class of a failure. The text of a check's triage opens with one of these."""

    FIRST_STEP = "diverged from the first step"
    LATE = "diverged late"
    OUT_OF_TOLERANCE = "out of tolerance"
    WRONG_INPUT = "wrong input"
    ENGINE_ERROR = "engine error"
    NAN = "NaN"
    OUT_OF_TIME = "out of time"
    OUT_OF_MEMORY = "out of memory"
    HARNESS = "harness error"
    MISSING = "missing"
    NOT_TESTED = "not tested"


_BY_ERROR: tuple[tuple[type[EngineError], Triage], ...] = (
    (EngineTimeoutError, Triage.OUT_OF_TIME),
    (EngineMemoryError, Triage.OUT_OF_MEMORY),
    (EngineNaNError, Triage.NAN),
    # an atom that is lost was put in rightly
    (EngineLostAtomsError, Triage.ENGINE_ERROR),
    (EngineInputError, Triage.WRONG_INPUT),
)


def of_error(error: EngineError) -> str:
    """Return the class of an engine's error, with its kind where the class does not say it."""
    triage = next((t for kind, t in _BY_ERROR if isinstance(error, kind)), Triage.ENGINE_ERROR)
    return triage if error.kind == triage else f"{triage}: {error.kind}"


def of_divergence(divergence: Divergence) -> str:
    """Return the class of a series that left its reference, with the time."""
    if divergence.from_first_step:
        return f"{Triage.FIRST_STEP}: {divergence.column}, at {divergence.time:.6g} s"
    last = f"within its band up to {divergence.last_inside:.6g} s"
    back = "" if divergence.stays else "; it came back"
    return f"{Triage.LATE}: {divergence.column}, at {divergence.time:.6g} s ({last}){back}"


class Kind(StrEnum):
    """What a value is held against."""

    ANALYTIC = "analytic"
    CROSS_CODE = "cross-code"
    INVARIANCE = "invariance"
    REGRESSION = "regression"
    FINDING = "finding"


class Verdict(StrEnum):
    """What became of a check. A finding is reported, not judged.

    A known defect is a failure whose cause is known for the release; fixed is one that is gone.
    """

    PASS = "pass"
    FAIL = "fail"
    NOT_TESTED = "not tested"
    FINDING = "finding"
    KNOWN_DEFECT = "known defect"
    FIXED = "fixed"


RANK = dict.fromkeys(Verdict, 2) | {Verdict.FAIL: 0, Verdict.KNOWN_DEFECT: 1, Verdict.NOT_TESTED: 1}
"""From bad to good. What is not tested is worse than what holds: it may fail unseen."""


@dataclass(frozen=True)
class Cell:
    """The place of a check in the matrix of cases and submodels, for a system and an engine.

    ``invariance`` names what must not change its runs, empty for their values. ``order`` is the
    order of convergence that was observed, with its interval. ``defect`` is the name of the known
    defect that explains a failure there, or that is gone.
    """

    case: str
    submodel: str
    system: str
    engine: str
    order: Number = math.nan
    order_low: Number = math.nan
    order_high: Number = math.nan
    invariance: str = ""
    defect: str = ""

    @property
    def place(self) -> tuple[str, str, str, str, str]:
        """Return case, submodel, system, engine and invariance."""
        return (self.case, self.submodel, self.system, self.engine, self.invariance)


@dataclass(frozen=True, kw_only=True)
class Check(Row, Record):
    """A row that was held against what is expected of it, and the verdict.

    ``difference`` is value - expected, always in full. ``why`` says where the
    tolerance comes from, ``note`` what went wrong or what is to be seen, and
    ``triage`` of what class a failure is (empty for a check that holds).
    ``log`` is the text that an engine left of a run that failed; results.json holds the name
    of its file. Its engine stands in ``cell``, and ``who`` is not published.
    """

    expected: Number = field()
    who: Annotated[str, Field(exclude=True)] = ""
    kind: Kind
    tolerance: Number
    verdict: Verdict
    why: str = ""
    triage: str = ""
    engine_died: bool = False
    log: str = field(default="", repr=False)
    cell: Cell | None = None

    @computed_field  # type: ignore[prop-decorator]
    @property
    def difference(self) -> Number:
        """Return value - expected."""
        return self.value - self.expected

    @property
    def judged(self) -> bool:
        """Return whether the check has a verdict that holds or fails."""
        return self.verdict in (Verdict.PASS, Verdict.FAIL)

    @property
    def log_name(self) -> str:
        """Return the name of the log's file: of the check, and of what the log says; or empty."""
        if not self.log:
            return ""
        digest = hashlib.sha256(self.log.encode()).hexdigest()[:8]
        words = re.sub(r"[^a-z0-9]+", "-", self.name.lower()).strip("-")
        return f"{words[:60]}-{digest}.log"

    @field_serializer("log")
    def _name_of_log(self, _: str) -> str:
        return self.log_name


def judge(
    name: str,
    kind: Kind,
    value: float,
    expected: float,
    tolerance: Tolerance,
    *,
    uncertainty: float = 0.0,
    note: str = "",
    triage: str = "",
) -> Check:
    """Return the check of a value against what is expected; NaN never passes.

    Neither does a value where what is expected, or the tolerance, is not finite: that is an error
    of the harness. ``triage`` is the class if it fails, where more is known than the number.
    """
    width = tolerance.width(expected)
    bounded = math.isfinite(expected) and math.isfinite(width)
    holds = bounded and abs(value - expected) <= width
    deviation = Triage.NAN if math.isnan(value) else Triage.OUT_OF_TOLERANCE
    if not bounded and not math.isnan(value):
        triage = f"{Triage.HARNESS}: expected {expected:g} within {width:g}"
    return Check(
        name,
        value,
        uncertainty,
        tolerance.unit,
        expected=expected,
        note=note,
        kind=kind,
        tolerance=width,
        verdict=Verdict.PASS if holds else Verdict.FAIL,
        why=tolerance.reason,
        triage="" if holds else triage or deviation,
    )


def is_undecided(value: float, expected: float, uncertainty: float, width: float) -> bool:
    """Return whether a value is too uncertain for a verdict.

    It holds where difference and uncertainty are within the width of the tolerance, and fails
    where the difference is more than both together. NaN is decided: it fails.
    """
    apart = abs(value - expected)
    holds = apart <= width and uncertainty <= width
    fails = math.isnan(apart) or apart > width + uncertainty
    return not (holds or fails)


def decided(check: Check, limit: str) -> Check:
    """Return a check, one that is too uncertain for a verdict as not tested.

    ``limit`` says what ended the series of its runs.
    """
    doubts = check.value, check.expected, check.uncertainty, check.tolerance
    if not check.judged or not is_undecided(*doubts):
        return check
    why = (
        f"undecided: {abs(check.difference):.2g} apart, uncertain by {check.uncertainty:.2g}, "
        f"tolerance {check.tolerance:.2g}; {limit}"
    )
    note = "; ".join(filter(None, (check.note, why)))
    return replace(check, verdict=Verdict.NOT_TESTED, note=note, triage=Triage.NOT_TESTED)


def finding(
    name: str, value: float, expected: float, unit: str, note: str, uncertainty: float = 0.0
) -> Check:
    """Return a row for a difference between models: shown, not judged."""
    row = without_value(name, Kind.FINDING, Verdict.FINDING, note, "", unit)
    return replace(row, value=value, expected=expected, uncertainty=uncertainty)


def without_value(
    name: str, kind: Kind, verdict: Verdict, note: str, triage: str, unit: str = ""
) -> Check:
    """Return the row of a check that has no value, with the reason."""
    nan = math.nan
    return Check(
        name,
        nan,
        nan,
        unit,
        expected=nan,
        note=note,
        kind=kind,
        tolerance=nan,
        verdict=verdict,
        triage=triage,
    )


def failed(name: str, kind: Kind, note: str, triage: str, unit: str = "") -> Check:
    """Return the row of a check that failed before it had a value, with the reason."""
    return without_value(name, kind, Verdict.FAIL, note, triage, unit)


def failed_run(name: str, kind: Kind, error: EngineError, unit: str = "") -> Check:
    """Return the row of a check whose engine died: a failure that says how."""
    row = failed(name, kind, f"{error.kind}: {error}", of_error(error), unit)
    return replace(row, engine_died=True, log=error.log)


def not_tested(name: str, kind: Kind, reason: str, unit: str = "") -> Check:
    """Return the row of a check that could not be made, with the reason; never a pass."""
    return without_value(name, kind, Verdict.NOT_TESTED, reason, Triage.NOT_TESTED, unit)


class Planned(NamedTuple):
    """A check that the plan of a level names: how the name of its row begins.

    Rows of what must not change a run (``invariance``) and of its values are separate checks.
    """

    name: str
    invariance: bool = False

    def includes(self, row: Check) -> bool:
        """Return whether a row is of the check."""
        return row.name.startswith(self.name) and self.invariance is (row.kind is Kind.INVARIANCE)


def missing_from(rows: Sequence[Check], planned: Iterable[Planned]) -> list[Planned]:
    """Return the planned checks that no row is of; a row is of one check, the longest name."""
    unassigned, missing = dict(enumerate(rows)), []
    for check in sorted(planned, key=lambda check: len(check.name), reverse=True):
        at = next((i for i, row in unassigned.items() if check.includes(row)), None)
        if at is None:
            missing.append(check)
        else:
            del unassigned[at]
    return missing


def judge_plan(name: str, rows: Sequence[Check], planned: Sequence[Planned]) -> list[Check]:
    """Return the check that a verification left all that its plan names, and what is missing.

    ``name`` is that of the count; a check that is missing is a failed row of its own name.
    """
    missing = missing_from(rows, planned)
    why = "a count: each row that the plan of the level has is there"
    counts = float(len(rows)), float(len(planned))
    count = judge(name, Kind.ANALYTIC, *counts, Tolerance("", 0.0, 0.0, why))
    # there may be more rows than the plan names
    count = replace(count, verdict=Verdict.PASS, triage="")
    if missing:
        note = f"missing: {'; '.join(check.name for check in missing)}"
        count = replace(count, verdict=Verdict.FAIL, triage=Triage.MISSING, note=note)
    lost = "the plan of the level names it, and no run left it"
    kinds = (Kind.INVARIANCE if check.invariance else Kind.ANALYTIC for check in missing)
    pairs = zip(missing, kinds, strict=True)
    return [count, *(failed(check.name, kind, lost, Triage.MISSING) for check, kind in pairs)]
