"""Two runs on the same times.

Where both have samples at the same times, to round-off, those are taken and
nothing is interpolated. Else the run with more samples is interpolated to the
times of the other, by cubic splines between changes of contacts: the force has
a kink there, across which no spline may reach, so times in the sampling
interval that holds a change are left out, and so are stretches too short to
tell the error. That error is measured, not assumed: the same splines through
every second sample miss the samples in between by it. At half the spacing it is
some 16 times smaller.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from harness.errors import RequestError
from harness.observables.tower import Floats, TowerRun

ROUND_OFF = 1e-12
"""Times closer than this part of the longer run are the same: what printing and summing leave."""

ENOUGH_SHARED = 0.5
"""Part of the coarser run's samples that must be shared for interpolation not to be needed."""

SHORTEST_STRETCH = 5
"""Samples between two changes of contacts that a spline and its error need."""

Indices = NDArray[np.intp]


class CommonSeries(NamedTuple):
    """Force and velocity of the grain in two runs on common times, (T,) each.

    The interpolation errors are upper bounds, 0 for shared samples; ``left_out``
    are samples of the coarser run at whose times nothing is said of the other.
    """

    time: Floats  # [s]
    force: Floats  # [N]
    reference_force: Floats  # [N]
    velocity: Floats  # [m/s]
    reference_velocity: Floats  # [m/s]
    force_interpolation_error: float  # [N]
    velocity_interpolation_error: float  # [m/s]
    left_out: int


def on_common_times(run: TowerRun, reference: TowerRun) -> CommonSeries:
    """Return both runs on common times.

    Raise RequestError if they have none.
    """
    first = max(run.time[0], reference.time[0])
    last = min(run.time[-1], reference.time[-1])
    same = ROUND_OFF * max(abs(run.time[-1]), abs(reference.time[-1]))
    rows, others = _distinct(run, first, last, same), _distinct(reference, first, last, same)
    if rows.size < 2 or others.size < 2:
        raise RequestError(
            f"time = {run.time[0]:.6g} to {run.time[-1]:.6g} s: shares fewer than two samples "
            f"with the reference, {reference.time[0]:.6g} to {reference.time[-1]:.6g} s"
        )
    ours, theirs = _shared(run.time[rows], reference.time[others], same)
    if ours.size >= max(2, ENOUGH_SHARED * min(rows.size, others.size)):
        return _at_samples(run, reference, rows[ours], others[theirs], min(rows.size, others.size))
    if rows.size >= others.size:
        return _interpolated(run, reference, others)
    return _swapped(_interpolated(reference, run, rows))


def _distinct(run: TowerRun, first: float, last: float, same: float) -> Indices:
    """Return the rows from ``first`` to ``last`` [s], of those at the same time the last one."""
    rows = np.flatnonzero((run.time >= first - same) & (run.time <= last + same))
    keep = np.diff(run.time[rows], append=np.inf) > same
    return np.asarray(rows[keep])


def _shared(time: Floats, other: Floats, same: float) -> tuple[Indices, Indices]:
    """Return which entries of two rising arrays are equal within ``same`` [s]."""
    right = np.clip(np.searchsorted(other, time), 1, other.size - 1)
    nearest = np.where(time - other[right - 1] < other[right] - time, right - 1, right)
    found = np.abs(other[nearest] - time) <= same
    return np.flatnonzero(found), np.asarray(nearest[found])


def _at_samples(
    run: TowerRun, reference: TowerRun, rows: Indices, others: Indices, coarser: int
) -> CommonSeries:
    return CommonSeries(
        run.time[rows], run.grain_force[rows], reference.grain_force[others],
        run.grain_velocity[rows], reference.grain_velocity[others], 0.0, 0.0, coarser - rows.size,
    )  # fmt: skip


def _interpolated(fine: TowerRun, coarse: TowerRun, rows: Indices) -> CommonSeries:
    """Return ``fine`` on the times of the ``rows`` of ``coarse``."""
    time = coarse.time[rows]
    values = np.full((time.size, 2), np.nan)
    error = np.zeros(2)
    for stretch in _stretches(fine):
        at, known = fine.time[stretch], np.column_stack(
            [fine.grain_force[stretch], fine.grain_velocity[stretch]]
        )  # fmt: skip
        inside = (time >= at[0]) & (time <= at[-1])
        if not inside.any():
            continue
        values[inside] = CubicSpline(at, known)(time[inside])
        missed = CubicSpline(at[::2], known[::2])(at[1:-1:2]) - known[1:-1:2]
        error = np.maximum(error, np.abs(missed).max(axis=0))
    told = np.isfinite(values[:, 0])
    if told.sum() < 2:
        raise RequestError(
            f"time: {fine.solver} has too few samples between its changes of contacts "
            f"({fine.time.size} in all) to be interpolated"
        )
    return CommonSeries(
        time[told], values[told, 0], coarse.grain_force[rows][told],
        values[told, 1], coarse.grain_velocity[rows][told],
        float(error[0]), float(error[1]), int(time.size - told.sum()),
    )  # fmt: skip


def _stretches(run: TowerRun) -> list[Indices]:
    """Return the rows between changes of contacts, those that are long enough.

    Rows whose times are closer than round-off count once.
    """
    rows = _distinct(run, run.time[0], run.time[-1], ROUND_OFF * abs(float(run.time[-1])))
    contacts = run.contacts[rows]
    if run.tower.start != "gapped":
        contacts[0] = contacts[1]  # in touch, though still without a force
    cuts = np.flatnonzero(np.diff(contacts)) + 1
    return [part for part in np.split(rows, cuts) if part.size >= SHORTEST_STRETCH]


def _swapped(series: CommonSeries) -> CommonSeries:
    return series._replace(
        force=series.reference_force, reference_force=series.force,
        velocity=series.reference_velocity, reference_velocity=series.velocity,
    )  # fmt: skip
