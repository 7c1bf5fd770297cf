"""Rows: a value, the value expected of it, and the verdict.

Every result of the package is a row, and a set of rows is a pandas table. Verdicts, regressions,
differences of runs and the matrix of releases all work on that table. Its key is the five columns
``KEY``; no name is ever parsed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    import pandas as pd

NAN = math.nan
Level = Literal["quick", "default", "full"]
LEVELS: tuple[Level, ...] = ("quick", "default", "full")


class Kind(StrEnum):
    """What a value is compared with. Kinds are counted separately and never added up."""

    ANALYTIC = "analytic"  # a closed form
    CROSS_CODE = "cross-code"  # the reference, an independent solver, another code
    FINDING = "finding"  # a difference between models: reported, not judged
    RECORDED = "recorded"  # the accepted run alone


class Verdict(StrEnum):
    """The outcome of a row, from the one to read first to the one to read last."""

    FAIL = "fail"
    KNOWN_DEFECT = "known defect"  # fails, and holds with the switch of a known defect
    NOT_TESTED = "not tested"  # no value, or one that decides nothing; never a pass
    FIXED = "fixed"  # holds, and fails with the switch of a defect declared for this release
    PASS = "pass"
    RECORDED = "recorded"
    FINDING = "finding"


class Failure(StrEnum):
    """The class of a failure: where to look next."""

    NONE = ""
    OUT_OF_TOLERANCE = "out of tolerance"
    NOT_A_NUMBER = "not a number"
    FROM_FIRST_STEP = "diverged from the first step"
    LATE = "diverged late"
    WRONG_INPUT = "wrong input"
    ENGINE = "engine error"
    TIMEOUT = "out of time"
    MEMORY = "out of memory"
    HARNESS = "harness error"


ENGINE_FAILURES = frozenset({Failure.ENGINE, Failure.TIMEOUT, Failure.MEMORY, Failure.WRONG_INPUT})
"""Failures that leave an engine's verdicts incomplete: exit status 3."""


@dataclass(frozen=True)
class Tolerance:
    """Largest difference that passes: ``absolute + relative * |expected|``, and its reason.

    With ``whole_interval`` the value passes only where value +- uncertainty is within: a test of
    equivalence. Otherwise value and uncertainty must be within, each for itself.
    """

    absolute: float = 0.0
    relative: float = 0.0
    reason: str = ""
    whole_interval: bool = False

    def width(self, expected: float) -> float:
        """Return the largest difference from an expected value that passes."""
        return self.absolute + self.relative * abs(expected)


@dataclass(frozen=True, kw_only=True)
class Row:
    """A value with its verdict. The first five fields are its key.

    ``setup`` names the parameters in short ("plastic contact, k = 1e6 N/m, 100 steps"); ``check``
    names the route where one quantity of a setup is compared with two things, or the variation of
    the engine that was run, and is empty otherwise.
    """

    case: str
    setup: str
    quantity: str
    engine: str
    check: str = ""
    version: str = ""  # of the engine
    value: float = NAN
    unit: str = ""
    uncertainty: float = 0.0
    expected: float = NAN
    tolerance: float = NAN
    kind: Kind = Kind.ANALYTIC
    verdict: Verdict = Verdict.NOT_TESTED
    failure: Failure = Failure.NONE
    reason: str = ""  # of the tolerance
    note: str = ""  # what went wrong, or what to look at
    defect: str = ""  # names of the known defects behind the verdict
    level: str = ""  # shortest level of `verify` that runs it
    inputs: str = ""  # digest of what the engine was given
    log: str = ""  # of a failed run: its text, and the name of its file in a stored run

    @property
    def difference(self) -> float:
        """Return value - expected."""
        return self.value - self.expected

    @property
    def key(self) -> tuple[str, str, str, str, str]:
        """Return the fields that no two rows of a table share."""
        return (self.case, self.setup, self.quantity, self.engine, self.check)

    @property
    def name(self) -> str:
        """Return :func:`row_name` of the key."""
        return row_name(*self.key)


KEY = ("case", "setup", "quantity", "engine", "check")
_FIELDS = tuple(field.name for field in fields(Row))
_AFTER_EXPECTED = _FIELDS.index("expected") + 1
COLUMNS = (*_FIELDS[:_AFTER_EXPECTED], "difference", *_FIELDS[_AFTER_EXPECTED:])
NUMBERS = ("value", "uncertainty", "expected", "difference", "tolerance")


def row_name(case: str, setup: str, quantity: str, engine: str, check: str) -> str:
    """Return a name for people: case, setup, check, engine and quantity."""
    about = ", ".join(filter(None, (setup, check)))
    case = f"{case} ({about})" if about else case
    return ": ".join(filter(None, (f"{case}, {engine}", quantity)))


def judge(row: Row, tolerance: Tolerance, *, failure: Failure = Failure.NONE) -> Row:
    """Return the row with its verdict: pass for ``|value - expected| <= width``; NaN never passes.

    A value whose uncertainty keeps it from deciding is not tested. A finding is not judged, nor is
    a recorded value unless one is expected: it must be finite, and the tolerance is how far it may
    be from the accepted run. ``failure`` is the class of a failure where more than the number is
    known of it.
    """
    unjudged = Verdict.FINDING if row.kind is Kind.FINDING else None
    if row.kind is Kind.RECORDED and math.isnan(row.expected):
        unjudged = Verdict.RECORDED
    width = tolerance.width(row.value if unjudged else row.expected)
    error, uncertainty, note = abs(row.difference), row.uncertainty, row.note
    reach = error + uncertainty if tolerance.whole_interval else max(error, uncertainty)
    verdict, failure = Verdict.FAIL, failure or Failure.OUT_OF_TOLERANCE
    is_number = math.isfinite(row.value) if unjudged else not math.isnan(row.value)
    needs_width = is_number if unjudged is Verdict.RECORDED else not unjudged
    if needs_width and not math.isfinite(width):
        failure, note = Failure.HARNESS, f"expected {row.expected:g} within {width:g}"
    elif not is_number or math.isnan(uncertainty):
        failure = Failure.NOT_A_NUMBER
    elif unjudged:
        verdict = unjudged
        width = width or NAN if row.kind is Kind.FINDING else width
    elif math.isnan(error - uncertainty):  # of two infinite ones
        failure = Failure.NOT_A_NUMBER
    elif reach <= width:
        verdict = Verdict.PASS
    elif error <= width + uncertainty:
        verdict = Verdict.NOT_TESTED
        doubt = f"undecided: off by {error:.2g} ± {uncertainty:.2g}, tolerance {width:.2g}"
        note = joined(note, doubt)
    failure = failure if verdict is Verdict.FAIL else Failure.NONE
    reason = tolerance.reason
    return replace(row, tolerance=width, reason=reason, verdict=verdict, failure=failure, note=note)


def finding(row: Row) -> Row:
    """Return the row as a finding: a difference between models, shown and not judged."""
    return replace(row, kind=Kind.FINDING, verdict=Verdict.FINDING)


def not_tested(row: Row, reason: str) -> Row:
    """Return the row without a value, with the reason; never a pass."""
    return replace(row, value=NAN, verdict=Verdict.NOT_TESTED, note=reason)


def failed(row: Row, failure: Failure, note: str, log: str = "") -> Row:
    """Return the row of a run that ended without a value."""
    return replace(row, value=NAN, verdict=Verdict.FAIL, failure=failure, note=note, log=log)


def matches(path: str, only: str) -> bool:
    """Return whether a pattern matches ``case/setup/quantity``, its start, or its end."""
    return any(fnmatchcase(path, pattern) for pattern in (only, f"{only}/*", f"*/{only}"))


def defects_of(names: str) -> list[str]:
    """Return the names of a row's known defects."""
    return names.split(", ")


def joined(*notes: str) -> str:
    """Return notes as one text, without empty ones."""
    return "; ".join(filter(None, notes))


def table(rows: Iterable[Row]) -> pd.DataFrame:
    """Return rows as a table with ``COLUMNS``; raise ValueError where two have the same key."""
    import numpy as np
    import pandas as pd

    every = list(rows)
    cells = {name: [_plain(getattr(row, name)) for row in every] for name in COLUMNS}
    numbers = {name: np.array(cells[name], float) for name in NUMBERS}
    values = cells if every else {}  # an empty list would be a column of numbers
    frame = pd.DataFrame(values | numbers, columns=list(COLUMNS))
    check_keys(frame)
    return frame


def check_keys(frame: pd.DataFrame) -> None:
    """Raise ValueError where two rows of a table have the same key."""
    is_twice = frame.duplicated(list(KEY))
    if is_twice.any():
        raise ValueError(f"two rows of one key: {tuple(frame.loc[is_twice, list(KEY)].iloc[0])}")


def rows_of(frame: pd.DataFrame) -> list[Row]:
    """Return the rows of a table."""
    enums: dict[str, type[StrEnum]] = {"kind": Kind, "verdict": Verdict, "failure": Failure}
    cells = zip(*(frame[name].tolist() for name in _FIELDS), strict=True)
    records: list[dict[str, Any]] = [dict(zip(_FIELDS, row, strict=True)) for row in cells]
    return [Row(**record | {n: enum(record[n]) for n, enum in enums.items()}) for record in records]


def _plain(value: object) -> object:
    """Return the value of a cell; halves of surrogate pairs become question marks."""
    return str(value).encode("utf-8", "replace").decode() if isinstance(value, str) else value
