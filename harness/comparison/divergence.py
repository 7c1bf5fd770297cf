"""When two series of the same case diverge.

The difference of two runs crosses zero while they part, and a change of
contacts that is seen a sample later makes a spike that is gone with the next
sample. So neither the first sample out of the band nor the first after which
all are out of it will do. The *divergence* is the start of the last excursion: the
first sample outside the band since the series was last inside it for as long as
:data:`RETURN` of the record. A series that ends inside the band for that long has
come back; then its longest excursion counts, and ``stays`` is false.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.comparison.alignment import Samples, align, missing
from harness.errors import RequestError

Floats = NDArray[np.float64]

RETURN = 0.05
"""Part of the record that a series must stay inside its band to have come back."""

SAME_TIME = 1e-10
"""Times closer than this part of the record are the same: they are written to 12 digits."""


@dataclass(frozen=True)
class Series:
    """Columns over time [s], all of shape (T,); a column's name ends in its unit."""

    time: Floats
    columns: Mapping[str, Floats]

    def thinned(self, first: int = 8, rows: int = 200) -> Series:
        """Return the ``first`` samples, and the last, and at most ``rows`` of the others.

        Their distance is a power of two of samples, so that a run with twice the
        step has most of them too.
        """
        count = self.time.size
        if count <= first + rows + 1:
            return self
        stride = 2 ** math.ceil(math.log2(count / rows))
        keep = np.union1d(np.arange(first), [*range(0, count, stride), count - 1])
        return Series(self.time[keep], {name: c[keep] for name, c in self.columns.items()})


@dataclass(frozen=True)
class Divergence:
    """Where a column left the band about its reference.

    ``last_inside`` [s] is the sample before, in the band; ``stays`` is false for a
    series that came back.
    """

    column: str
    time: float  # [s]
    last_inside: float  # [s]
    from_first_step: bool
    stays: bool


@dataclass(frozen=True)
class Comparison:
    """A column of a series against the same of its reference, at common times (T,).

    ``band`` is the tolerance and what interpolation adds, in the unit of the column.
    """

    case: str
    column: str
    time: Floats  # [s]
    value: Floats
    reference: Floats
    band: float
    run_label: str = "run"
    reference_label: str = "baseline"

    @property
    def difference(self) -> Floats:
        """Return value - reference (T,)."""
        return self.value - self.reference

    @property
    def largest(self) -> float:
        """Return the largest difference, NaN if the run holds one."""
        return float(np.max(np.abs(self.difference)))

    @property
    def holds(self) -> bool:
        """Return whether every sample is inside the band; NaN is not."""
        return self.largest <= self.band

    @property
    def divergence(self) -> Divergence | None:
        """Return when the difference leaves the band for good, None if it does not."""
        return part(self.column, self.time, self.difference, self.band)

    def record(self) -> dict[str, Any]:
        """Return it without the series as a JSON-ready mapping."""
        found = self.divergence
        return {
            "case": self.case,
            "column": self.column,
            "largest_difference": self.largest,
            "band": self.band,
            "divergence_time_s": found.time if found else None,
            "from_first_step": found.from_first_step if found else None,
            "stays": found.stays if found else None,
        }


def part(column: str, time: Floats, difference: Floats, band: float) -> Divergence | None:
    """Return when a difference (T,) at ``time`` (T,) [s] leaves ``band``; None if it never does.

    What is not a number is outside.
    """
    outside = np.flatnonzero(~(np.abs(difference) <= band))
    if outside.size == 0:
        return None
    long_enough = RETURN * float(time[-1] - time[0])
    starts = [0]
    for i, (before, after) in enumerate(pairwise(outside), 1):
        if time[after] - time[before] > long_enough:
            starts.append(i)
    stays = bool(time[-1] - time[outside[-1]] <= long_enough)
    chosen = len(starts) - 1 if stays else _longest(time, outside, starts)
    first = int(outside[starts[chosen]])
    # the start itself may be equal by construction: the next sample then is the first to tell
    return Divergence(
        column, float(time[first]), float(time[max(first - 1, 0)]), first <= 1, stays
    )  # fmt: skip


def _longest(time: Floats, outside: NDArray[np.intp], starts: list[int]) -> int:
    ends = [*(start - 1 for start in starts[1:]), outside.size - 1]
    lasting = [time[outside[b]] - time[outside[a]] for a, b in zip(starts, ends, strict=True)]
    return int(np.argmax(lasting))


def compare_series(
    case: str, run: Series, reference: Series, relative: float, absolute: float = 0.0
) -> list[Comparison]:
    """Return each column of a reference against the run's, at their common times.

    The band is ``relative`` times the largest value of the reference's column, and
    ``absolute``, and what interpolation adds where the times are others
    (:func:`harness.comparison.alignment.align`). Raise RequestError for a run that lacks a
    column, a time or the end of its reference, unless what it has leaves the band already.
    """
    same = SAME_TIME * float(reference.time[-1] - reference.time[0])
    common = [name for name in reference.columns if name in run.columns]
    lost = [name for name in reference.columns if name not in run.columns]
    lacking = f"no column {', '.join(lost)}" if lost else ""
    lacking = lacking or missing(run.time, reference.time, same, thinned=True)
    found = []
    if common:
        try:
            aligned = align(_samples(run, common), _samples(reference, common), same)
        except RequestError as error:
            raise RequestError(f"{case}: series incomplete: {lacking or error}") from None
        largest = np.max(np.abs(aligned.reference), axis=0)
        bands = absolute + relative * largest + aligned.error
        found = [
            Comparison(case, name, aligned.time, value, wanted, float(band))
            for name, value, wanted, band in zip(
                common, aligned.value.T, aligned.reference.T, bands, strict=True
            )
        ]
    if lacking and all(column.holds for column in found):
        raise RequestError(f"{case}: series incomplete: {lacking}")
    return found


def _samples(series: Series, names: Sequence[str]) -> Samples:
    return Samples(series.time, np.column_stack([series.columns[name] for name in names]))
