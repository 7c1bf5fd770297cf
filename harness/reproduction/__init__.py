"""The source paper (Harper, Dufek and Breard, arXiv:2409.13633), statement by statement.

Functions of ``incline``, ``chains`` and ``towers`` yield the statements of one subject, each with
the printed value and the value recomputed by an independent route. ``run`` makes rows, pages and
figures of them.

A statement that is recomputed within its tolerance passes. One that is not is a finding: it is
reported, never a failure of the harness. Where a correction makes it hold, a second row, with the
check "corrected", has the corrected formula as expected value.
"""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.cases.bench import OWN
from harness.cases.checks import error_row
from harness.errors import EngineError, Unsupported
from harness.report.content import Badge
from harness.results.rows import Kind, Row, Tolerance, Verdict, finding, judge

Floats = NDArray[np.float64]

CASE = "source"
CORRECTED = "corrected"
ROUND_OFF = 1e-12  # of numbers of about 1, by two routes in double precision
HALF_DIGIT = "half of the last digit"
SEED = 2409_13633
STATUSES = (  # in the colours that verdicts have on a page
    Badge("reproduced", "pass"), Badge("reproduced with a correction", "not tested"),
    Badge("not reproduced", "fail"), Badge("not tested", "recorded"),
)  # fmt: skip
REPRODUCED, WITH_CORRECTION, NOT_REPRODUCED, UNTESTED = STATUSES


@dataclass(frozen=True)
class Statement:
    """A statement of the source: its place, its text, and what becomes of it.

    ``value`` is recomputed and ``printed`` in the source: numbers, or arrays of one shape of
    samples. Without a printed value the statement is in words, and ``value`` is whether it is true.
    ``corrected`` is the value of the corrected formula, or whether the corrected words are true.
    The value of a run that was refused or died is its error.
    """

    key: str
    where: str
    text: str
    value: ArrayLike | Unsupported | EngineError
    printed: ArrayLike | None = None
    corrected: ArrayLike | None = None
    _: KW_ONLY
    unit: str = "1"
    tolerance: float = ROUND_OFF  # [unit] on the difference of value and printed value
    reason: str = ""  # of the tolerance
    correction: str = ""
    note: str = ""
    uncertainty: float = 0.0
    kind: Kind = Kind.ANALYTIC
    engine: str = OWN
    version: str = ""

    @cached_property
    def rows(self) -> list[Row]:
        """Return its row as printed, and its row as corrected where that is another value."""
        row = Row(case=CASE, setup=self.where, quantity=self.key, engine=self.engine,
                  version=self.version, unit=self.unit, kind=self.kind, level="default",
                  note=self.note, uncertainty=self.uncertainty)  # fmt: skip
        if isinstance(self.value, Unsupported | EngineError):
            return [error_row(row, self.value)]
        words = self.printed is None
        exact = (
            "the statement is true or not" if words else "two routes in double precision: round-off"
        )
        tolerance = Tolerance(0.0 if words else self.tolerance, reason=self.reason or exact)
        expected = 1.0 if self.printed is None else self.printed
        printed = judge(_worst_sample(row, self.value, expected), tolerance)
        if printed.verdict is Verdict.PASS:
            return [printed]
        if self.corrected is None:
            return [finding(printed)]
        value, expected = (self.corrected, 1.0) if words else (self.value, self.corrected)
        row = replace(row, check=CORRECTED, note=self.correction)
        return [finding(printed), judge(_worst_sample(row, value, expected), tolerance)]

    @property
    def status(self) -> Badge:
        """Return whether it is reproduced, with a correction or not, or not tested."""
        verdicts = [row.verdict for row in self.rows]
        if verdicts[0] is Verdict.PASS:
            return REPRODUCED
        if verdicts[0] is not Verdict.FINDING:
            return UNTESTED
        return WITH_CORRECTION if verdicts[-1] is Verdict.PASS else NOT_REPRODUCED


def _worst_sample(row: Row, value: ArrayLike, expected: ArrayLike) -> Row:
    """Return the row with the sample that differs most, the middle one where none differs."""
    values, targets = np.broadcast_arrays(
        np.atleast_1d(np.asarray(value, float)), np.atleast_1d(np.asarray(expected, float))
    )
    errors = np.nan_to_num(np.abs(values - targets), nan=math.inf).ravel()
    at = int(np.argmax(errors)) if errors.max() > ROUND_OFF else errors.size // 2
    return replace(row, value=float(values.flat[at]), expected=float(targets.flat[at]))


def generator() -> np.random.Generator:
    """Return a generator that gives the same numbers in every run."""
    return np.random.default_rng(SEED)
