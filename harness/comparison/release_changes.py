"""Classes of a change from one release to another, and when a series parted from the other."""

from __future__ import annotations

from enum import StrEnum

from harness.comparison.baseline_record import BaselineRecord, Quantity
from harness.comparison.divergence import compare_series
from harness.comparison.regression import earliest
from harness.comparison.regression_tolerances import Allowed
from harness.errors import RequestError

ROUND_OFF = 1e-12
"""Relative change that is taken for rounding: some thousand units in the last place."""


class Change(StrEnum):
    """The class of a change against the reference release."""

    REFERENCE = "reference"
    SAME = "same to the last bit"
    ROUNDING = "within round-off"
    TOLERATED = "within tolerance"
    MOVED = "moved"
    DIED = "engine error"
    NOT_TESTED = "not tested"


def classify(here: Quantity, wanted: Quantity, width: float) -> Change:
    """Return the class of the change from one number to another."""
    difference = abs(here.value - wanted.value)
    if difference == 0.0:
        return Change.SAME
    if difference <= ROUND_OFF * abs(wanted.value):
        return Change.ROUNDING
    return Change.TOLERATED if difference <= width else Change.MOVED


def parted(record: BaselineRecord, known: BaselineRecord, allowed: Allowed) -> str:
    """Say when the series of a record that moved left that of the reference."""
    if record.series is None or known.series is None:
        return ""
    width = allowed.of(record.case, known.name, "series")[0]
    try:
        columns = compare_series(known.name, record.series, known.series, width.relative)
    except RequestError as error:
        return str(error)
    return earliest(columns)
