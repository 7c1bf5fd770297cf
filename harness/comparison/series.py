"""Two series of samples: brought to common times, and where they part for good.

Where both have samples at the same times, to round-off, those are taken and nothing is
interpolated. Else the series with more samples is interpolated to the times of the other, by
cubic splines within its smooth pieces: no spline may reach across a kink, so times in the
sampling interval that holds one are left out, and so are pieces too short to tell the error. That
error is measured, not assumed: the same splines through every second sample miss the samples in
between by it. At half the spacing it is some 16 times smaller. It is no more than that of the
series with fewer samples: noise of a run, which its own splines miss, shall not widen its band.

The difference of two runs crosses zero while they part, and a change of contacts that is seen a
sample later makes a spike that is gone with the next sample. So neither the first sample out of the
band nor the first after which all are out of it will do. The *divergence* is the start of the last
excursion: the first sample outside the band since the series was last inside it for as long as
:data:`RETURN` of the record. A series that ends inside the band for that long has come back; then
its longest excursion counts, and ``stays`` is false.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.shown import Record

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

ENOUGH_SHARED = 0.5
"""Part of the coarser series' samples that must be shared for interpolation not to be needed."""

SHORTEST_PIECE = 5
"""Samples that a spline and its error need."""

HOLE = 1.5
"""Usual sampling intervals that two neighbouring samples may be apart."""

COARSER = 2.05
"""How many times the sampling interval of its reference a series may have: twice the step."""

FIRST = 8
"""Samples that a thinned series keeps from its start, at their own distance."""


class Samples(NamedTuple):
    """Columns (T, C) at rising times (T,) [s].

    ``pieces`` (T,) numbers the smooth pieces: it changes where a column has a kink; None for a
    series without one.
    """

    time: Floats
    values: Floats
    pieces: NDArray[np.generic] | None = None


class Aligned(NamedTuple):
    """Two series at common times (M,) [s], values (M, C) each.

    ``error`` (C,) bounds what interpolation adds to the difference, 0 for shared samples.
    """

    time: Floats
    value: Floats
    reference: Floats
    error: Floats


def align(run: Samples, reference: Samples, same: float) -> Aligned:
    """Return both series at common times; times within ``same`` [s] of each other are the same.

    Raise RequestError if they have fewer than two in common.
    """
    first = max(run.time[0], reference.time[0])
    last = min(run.time[-1], reference.time[-1])
    ours, theirs = (_distinct(samples.time, first, last, same) for samples in (run, reference))
    if ours.size < 2 or theirs.size < 2:
        raise RequestError(
            f"time = {run.time[0]:.6g} to {run.time[-1]:.6g} s: shares fewer than two samples "
            f"with the reference, {reference.time[0]:.6g} to {reference.time[-1]:.6g} s"
        )
    coarser = min(ours.size, theirs.size)
    rows, others = _shared(run.time[ours], reference.time[theirs], same)
    if rows.size >= max(2, ENOUGH_SHARED * coarser):
        rows, others = ours[rows], theirs[others]
        none = np.zeros(run.values.shape[1])
        return Aligned(run.time[rows], run.values[rows], reference.values[others], none)
    if ours.size >= theirs.size:
        return _onto(run, reference, theirs, same)
    aligned = _onto(reference, run, ours, same)
    return aligned._replace(value=aligned.reference, reference=aligned.value)


def missing(run: Floats, reference: Floats, same: float, *, thinned: bool) -> str:
    """Return what the times (T,) [s] of a run lack of those of its reference, empty if nothing.

    A run must span its reference, without holes; it may end a sample early only where its samples
    lie at other times. Samples may be as far apart as the reference's are there. Where the
    reference is ``thinned`` this says nothing: they must be equally far apart, and half as many
    as the reference had, as with twice the step, at least.
    """
    if run.size < 2 or reference.size < 2:
        return f"{run.size} samples of {reference.size}"
    gaps = np.diff(run)
    usual = float(np.median(gaps))
    shared = _shared(run, reference, same)[0].size
    slack = same if shared >= ENOUGH_SHARED * min(run.size, reference.size) else usual + same
    if run[0] > reference[0] + slack or run[-1] < reference[-1] - slack:
        return (
            f"from {run[0]:.6g} to {run[-1]:.6g} s, the reference from {reference[0]:.6g} to "
            f"{reference[-1]:.6g} s"
        )
    allowed = np.full(gaps.shape, HOLE * usual + same)
    if not thinned:
        after = np.searchsorted(reference, 0.5 * (run[:-1] + run[1:])).clip(1, reference.size - 1)
        allowed = np.maximum(allowed, HOLE * (reference[after] - reference[after - 1]))
    wide = np.flatnonzero(gaps > allowed)
    if wide.size:
        return f"no sample between {run[wide[0]]:.6g} and {run[wide[0] + 1]:.6g} s"
    if thinned:
        for ours, theirs in zip(_distances(run), _distances(reference), strict=True):
            if ours > COARSER * theirs + same:
                return f"a sample each {ours:.3g} s, the reference one each {theirs:.3g} s"
    return ""


def distinct(time: Floats, same: float) -> Rows:
    """Return the rows of a rising array, of those within ``same`` of each other the last one."""
    return np.flatnonzero(np.diff(time, append=np.inf) > same)


def _distinct(time: Floats, first: float, last: float, same: float) -> Rows:
    """Return the distinct rows from ``first`` to ``last`` [s]."""
    rows = np.flatnonzero((time >= first - same) & (time <= last + same))
    return np.asarray(rows[distinct(time[rows], same)])


def _distances(time: Floats) -> tuple[float, float]:
    """Return the usual distance of samples at the start and over the whole series [s]."""
    gaps = np.diff(time)
    return float(np.median(gaps[: FIRST - 1])), float(np.median(gaps))


def _shared(time: Floats, other: Floats, same: float) -> tuple[Rows, Rows]:
    """Return which entries of two rising arrays are equal within ``same`` [s]."""
    right = np.clip(np.searchsorted(other, time), 1, max(other.size - 1, 1))
    if other.size < 2:
        right = np.zeros_like(right)
    nearest = np.where(time - other[right - 1] < other[right] - time, right - 1, right)
    equal = np.abs(other[nearest] - time) <= same
    return np.flatnonzero(equal), np.asarray(nearest[equal])


def _onto(fine: Samples, coarse: Samples, rows: Rows, same: float) -> Aligned:
    from scipy.interpolate import CubicSpline  # listing cases must not wait for it

    time = coarse.time[rows]
    values = np.full((time.size, fine.values.shape[1]), np.nan)
    error = np.zeros(fine.values.shape[1])
    covered = np.zeros(time.size, dtype=bool)
    for piece in _pieces(fine, same):
        at, samples = fine.time[piece], fine.values[piece]
        inside = (time >= at[0]) & (time <= at[-1])
        if not inside.any():
            continue
        covered |= inside
        if not np.isfinite(samples).all():
            values[inside] = np.column_stack([np.interp(time[inside], at, c) for c in samples.T])
            continue
        values[inside] = CubicSpline(at, samples)(time[inside])
        error = np.maximum(error, _missed(at, samples))
    error = np.fmin(error, _largest_missed(coarse, same))
    if covered.sum() < 2:
        raise RequestError(
            f"time: too few samples between kinks ({fine.time.size} in all) to be interpolated"
        )
    return Aligned(time[covered], values[covered], coarse.values[rows][covered], error)


def _missed(at: Floats, samples: Floats) -> Floats:
    """Return by how much splines through every second sample miss the others at most (C,)."""
    from scipy.interpolate import CubicSpline

    missed = CubicSpline(at[::2], samples[::2])(at[1:-1:2]) - samples[1:-1:2]
    return np.asarray(np.abs(missed).max(axis=0))


def _largest_missed(series: Samples, same: float) -> Floats:
    """Return what splines miss in any piece (C,); infinite where no piece can tell."""
    pieces = [rows for rows in _pieces(series, same) if np.isfinite(series.values[rows]).all()]
    missed = [_missed(series.time[rows], series.values[rows]) for rows in pieces]
    return np.max(missed, axis=0) if missed else np.full(series.values.shape[1], np.inf)


def _pieces(series: Samples, same: float) -> list[Rows]:
    rows = distinct(series.time, same)
    if series.pieces is None:
        parts = [rows]
    else:
        pieces = series.pieces[rows]
        parts = np.split(rows, np.flatnonzero(pieces[1:] != pieces[:-1]) + 1)
    return [part for part in parts if part.size >= SHORTEST_PIECE]


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
class Comparison(Record):
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

    JSON: ClassVar = {
        "case": "case",
        "column": "column",
        "largest_difference": "largest",
        "band": "band",
        "divergence_time_s": "divergence.time",
        "from_first_step": "divergence.from_first_step",
        "stays": "divergence.stays",
    }

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
    (:func:`harness.comparison.series.align`). Raise RequestError for a run that lacks a
    column, a time or the end of its reference, unless what it has leaves the band already.
    """
    same = SAME_TIME * float(reference.time[-1] - reference.time[0])
    common = [name for name in reference.columns if name in run.columns]
    lost = [name for name in reference.columns if name not in run.columns]
    lacking = f"no column {', '.join(lost)}" if lost else ""
    lacking = lacking or missing(run.time, reference.time, same, thinned=True)
    pieces = []
    if common:
        try:
            aligned = align(_samples(run, common), _samples(reference, common), same)
        except RequestError as error:
            raise RequestError(f"{case}: series incomplete: {lacking or error}") from None
        largest = np.max(np.abs(aligned.reference), axis=0)
        bands = absolute + relative * largest + aligned.error
        pieces = [
            Comparison(case, name, aligned.time, value, wanted, float(band))
            for name, value, wanted, band in zip(
                common, aligned.value.T, aligned.reference.T, bands, strict=True
            )
        ]
    if lacking and all(column.holds for column in pieces):
        raise RequestError(f"{case}: series incomplete: {lacking}")
    return pieces


def _samples(series: Series, names: Sequence[str]) -> Samples:
    return Samples(series.time, np.column_stack([series.columns[name] for name in names]))
