"""Statements of the source as functions that return rows: the printed value is the expected one.

A statement that is recomputed within its tolerance passes. One that is not is a finding: it is
reported, never a failure of the harness. Where a correction makes it hold, a second row, with the
check "corrected", has the corrected formula as expected value.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from harness.cases.bench import OWN, Bench
from harness.errors import EngineError, Unsupported
from harness.results.rows import (
    Failure,
    Kind,
    Row,
    Tolerance,
    Verdict,
    failed,
    finding,
    judge,
    not_tested,
)

CASE = "source"
CORRECTED = "corrected"
ROUND_OFF = 1e-12  # of numbers of about 1, by two routes in double precision
REASONS = {ROUND_OFF: "two routes in double precision: round-off"}


@dataclass(frozen=True)
class Outcome:
    """What a statement gives as printed, by an independent route, and once it is corrected.

    The three are numbers, or arrays of one shape of samples. A statement in words has 1 for true.
    """

    found: ArrayLike
    printed: ArrayLike
    corrected: ArrayLike | None = None
    note: str = ""
    uncertainty: float = 0.0
    tolerance: float | None = None  # that of the statement unless given
    found_corrected: ArrayLike | None = None  # for the corrected form, where it is not ``found``


def holds(condition: Any, note: str = "", *, corrected: Any = None) -> Outcome:
    """Return the outcome of a statement in words, and whether its corrected form holds."""
    right = None if corrected is None else 1.0
    return Outcome(float(bool(condition)), 1.0, right, note, tolerance=0.0,
                   found_corrected=float(bool(corrected)))  # fmt: skip


@dataclass(frozen=True)
class Statement:
    """A place in the source and what it states.

    ``tolerance`` [unit] is the largest difference between the printed and the recomputed value,
    with its reason. ``correction`` makes it hold where it does not as printed. ``measure`` is a
    function of nothing, or of the bench of the engine that runs the incline.
    """

    key: str
    where: str
    says: str
    measure: Callable[..., Outcome]
    tolerance: float = ROUND_OFF
    unit: str = "1"
    reason: str = ""
    correction: str = ""
    engine: bool = False

    def rows(self, bench: Bench | None = None) -> list[Row]:
        """Return its row as printed, and its row as corrected where that is another value."""
        blank = self._blank(bench)
        if self.engine and bench is None:
            return [not_tested(blank, "no engine was given to run the incline")]
        try:
            outcome = self.measure(bench) if self.engine else self.measure()
        except Unsupported as error:
            return [not_tested(blank, str(error))]
        except EngineError as error:
            return [failed(blank, Failure.ENGINE, f"{error.kind}: {error}", error.log)]
        return self._judged(blank, outcome)

    def _judged(self, blank: Row, outcome: Outcome) -> list[Row]:
        width = self.tolerance if outcome.tolerance is None else outcome.tolerance
        reason = self.reason or REASONS.get(width, "the statement is true or not")
        row = replace(blank, note=outcome.note, uncertainty=outcome.uncertainty)
        printed = judge(_worst(row, outcome.found, outcome.printed), Tolerance(width, 0.0, reason))
        if printed.verdict is Verdict.PASS or outcome.corrected is None:
            return [printed if printed.verdict is Verdict.PASS else finding(printed)]
        found = outcome.found if outcome.found_corrected is None else outcome.found_corrected
        right = _worst(row, found, outcome.corrected)
        right = replace(right, check=CORRECTED, note=self.correction)
        return [finding(printed), judge(right, Tolerance(width, 0.0, reason))]

    def _blank(self, bench: Bench | None) -> Row:
        name, version = OWN, ""
        if bench is not None and self.engine:
            name, version = bench.name, bench.engine.identify().engine_version
        return Row(
            case=CASE,
            setup=self.where,
            quantity=self.key,
            engine=name,
            version=version,
            unit=self.unit,
            kind=Kind.CROSS_CODE if self.engine else Kind.ANALYTIC,
            level="default",
        )


REGISTRY: dict[str, Statement] = {}


def statement(
    key: str, where: str, says: str, tolerance: float = ROUND_OFF, unit: str = "1", **more: Any
) -> Callable[[Callable[..., Outcome]], Callable[..., Outcome]]:
    """Register a function as the measurement of a statement; ``more`` are fields of it."""

    def register(measure: Callable[..., Outcome]) -> Callable[..., Outcome]:
        if key in REGISTRY:
            raise ValueError(f"two statements {key!r}")
        REGISTRY[key] = Statement(key, where, says, measure, tolerance, unit, **more)
        return measure

    return register


def _worst(row: Row, found: ArrayLike, expected: ArrayLike) -> Row:
    """Return the row with the sample that differs most, the middle one where none differs."""
    values, wanted = np.broadcast_arrays(
        np.atleast_1d(np.asarray(found, float)), np.atleast_1d(np.asarray(expected, float))
    )
    off = np.nan_to_num(np.abs(values - wanted), nan=math.inf).ravel()
    at = int(np.argmax(off)) if off.max() > ROUND_OFF else off.size // 2
    return replace(row, value=float(values.flat[at]), expected=float(wanted.flat[at]))
