"""The first divergence of a sampled series from its reference: from the first step, or late.

Both series have the same times, as at equal steps; nothing is interpolated. The difference of two
runs crosses zero while they diverge, and an event that is seen a sample later leaves a spike. So
the divergence is the start of the last excursion from the band, or of the first one where the
series came back.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from harness.results.rows import Failure

Floats = NDArray[np.float64]
RETURN = 0.05  # [-] part of the record inside the band after which a series has come back
SAME_TIME = 1e-9  # [-] of the record: differences of times that round-off makes


@dataclass(frozen=True)
class Divergence:
    """Where a column left the band about its reference.

    ``time`` [s] is the first sample of the excursion, ``largest`` the largest difference of the
    whole series in the unit of the column.
    """

    column: str
    time: float
    largest: float
    failure: Failure

    @property
    def note(self) -> str:
        """Return the place and the size in words."""
        return f"{self.failure}: {self.column} at {self.time:.6g} s, by up to {self.largest:.3g}"


def first_divergence(
    time: ArrayLike,
    columns: Mapping[str, ArrayLike],
    reference: Mapping[str, ArrayLike],
    *,
    reference_time: ArrayLike | None = None,
    relative: float = 0.0,
    absolute: float = 0.0,
) -> Divergence | None:
    """Return the earliest divergence of any column of the reference, None where all hold.

    ``time`` [s] and each column have shape (samples,). The band is ``absolute`` plus ``relative``
    times the largest value of the reference's column; NaN is outside. Raise ValueError for a
    column that the run lacks, and for other times.
    """
    seconds = np.asarray(time, dtype=float)
    _check_times(seconds, seconds if reference_time is None else np.asarray(reference_time))
    found = []
    for name, wanted in reference.items():
        if name not in columns:
            raise ValueError(f"the series has no column {name!r}")
        expected = np.asarray(wanted, dtype=float)
        difference = np.abs(np.asarray(columns[name], dtype=float) - expected)
        band = absolute + relative * float(np.max(np.abs(expected)))
        start = excursion_start(seconds, ~(difference <= band))
        if start is not None:
            failure = Failure.FROM_FIRST_STEP if start <= 1 else Failure.LATE
            largest = float(np.max(difference))
            found.append(Divergence(name, float(seconds[start]), largest, failure))
    return min(found, key=lambda divergence: divergence.time, default=None)


def excursion_start(time: Floats, outside: NDArray[np.bool_]) -> int | None:
    """Return the first sample of the last excursion from the band, None without any.

    Of a series that came back for :data:`RETURN` of the record at its end, it is the first sample
    of the first excursion.
    """
    places = np.flatnonzero(outside)
    if places.size == 0:
        return None
    long = RETURN * float(time[-1] - time[0])
    new = np.flatnonzero(np.diff(time[places]) > long) + 1
    starts = places[np.concatenate([[0], new])]
    stays = time[-1] - time[places[-1]] <= long
    return int(starts[-1] if stays else starts[0])


def _check_times(time: Floats, reference: Floats) -> None:
    if time.shape != reference.shape:
        raise ValueError(f"{time.size} samples, and {reference.size} of the reference")
    record = float(np.ptp(reference)) if reference.size else 0.0
    if not np.all(np.abs(time - reference) <= SAME_TIME * record):
        raise ValueError("the samples have other times than those of the reference")
