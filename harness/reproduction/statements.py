"""Statements of the source as functions: each leaves a row whose expected value is the printed one.

A statement that is recomputed within its tolerance passes. One that is not is a finding: it is
reported, never a failure of the harness. Where a correction makes it hold, a second row, with the
check "corrected", has the corrected formula as expected value.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from harness.cases.bench import OWN, Bench
from harness.cases.checks import failed_run
from harness.errors import EngineError, Unsupported
from harness.results.rows import Kind, Row, Tolerance, Verdict, finding, judge, not_tested

CASE = "source"
CORRECTED = "corrected"
ROUND_OFF = 1e-12  # of numbers of about 1, by two routes in double precision
REASONS = {ROUND_OFF: "two routes in double precision: round-off"}


class Outcome(NamedTuple):
    """A recomputed value, the printed one, and the one expected once the statement is corrected.

    The three are numbers, or arrays of one shape of samples. A statement in words has 1 for true.
    """

    value: ArrayLike
    printed: ArrayLike
    corrected: ArrayLike | None = None
    note: str = ""
    uncertainty: float = 0.0
    tolerance: float | None = None  # that of the statement unless given
    value_corrected: ArrayLike | None = None  # recomputed for the corrected form, where it differs


def holds(condition: Any, note: str = "", *, corrected: Any = None) -> Outcome:
    """Return the outcome of a statement in words, and whether its corrected form holds."""
    right = None if corrected is None else 1.0
    return Outcome(float(bool(condition)), 1.0, right, note, tolerance=0.0,
                   value_corrected=float(bool(corrected)))  # fmt: skip


@dataclass
class Statement:
    """A place in the source and its text there; a decorator of the function that recomputes it.

    ``tolerance`` [unit] is the largest difference between the printed and the recomputed value,
    with its reason. ``correction`` makes it hold where it does not as printed. The function gets
    nothing, or the bench of the ``engine`` that runs the incline.
    """

    where: str
    text: str
    tolerance: float = ROUND_OFF
    unit: str = "1"
    reason: str = ""
    _: KW_ONLY
    correction: str = ""
    engine: bool = False
    key: str = field(default="", init=False)
    measure: Callable[..., Outcome] = field(init=False)

    def __call__(self, measure: Callable[..., Outcome]) -> Callable[..., Outcome]:
        """Register a function as the statement: the key of ``_eq_2`` is ``eq-2``."""
        self.key, self.measure = measure.__name__.strip("_").replace("_", "-"), measure
        if self.key in REGISTRY:
            raise ValueError(f"two statements {self.key!r}")
        REGISTRY[self.key] = self
        return measure

    def rows(self, bench: Bench | None = None) -> list[Row]:
        """Return its row as printed, and its row as corrected where that is another value.

        The bench is that of the engine of a statement on runs in one, not tested without.
        """
        blank = Row(case=CASE, setup=self.where, quantity=self.key, engine=OWN, unit=self.unit,
                    kind=Kind.ANALYTIC, level="default")  # fmt: skip
        if not self.engine:
            return self._judged(blank, self.measure())
        blank = replace(blank, kind=Kind.CROSS_CODE)
        if bench is None:
            return [not_tested(blank, "no engine was given to run the incline")]
        version = bench.engine.identify().engine_version
        blank = replace(blank, engine=bench.name, version=version)
        try:
            return self._judged(blank, self.measure(bench))
        except Unsupported as error:
            return [not_tested(blank, str(error))]
        except EngineError as error:
            return [failed_run(blank, error)]

    def _judged(self, blank: Row, outcome: Outcome) -> list[Row]:
        width = self.tolerance if outcome.tolerance is None else outcome.tolerance
        reason = self.reason or REASONS.get(width, "the statement is true or not")
        tolerance = Tolerance(width, 0.0, reason)
        row = replace(blank, note=outcome.note, uncertainty=outcome.uncertainty)
        printed = judge(_worst_sample(row, outcome.value, outcome.printed), tolerance)
        if printed.verdict is Verdict.PASS:
            return [printed]
        if outcome.corrected is None:
            return [finding(printed)]
        value = outcome.value if outcome.value_corrected is None else outcome.value_corrected
        right = replace(row, check=CORRECTED, note=self.correction)
        return [finding(printed), judge(_worst_sample(right, value, outcome.corrected), tolerance)]


REGISTRY: dict[str, Statement] = {}


def _worst_sample(row: Row, value: ArrayLike, expected: ArrayLike) -> Row:
    """Return the row with the sample that differs most, the middle one where none differs."""
    values, targets = np.broadcast_arrays(
        np.atleast_1d(np.asarray(value, float)), np.atleast_1d(np.asarray(expected, float))
    )
    errors = np.nan_to_num(np.abs(values - targets), nan=math.inf).ravel()
    at = int(np.argmax(errors)) if errors.max() > ROUND_OFF else errors.size // 2
    return replace(row, value=float(values.flat[at]), expected=float(targets.flat[at]))
