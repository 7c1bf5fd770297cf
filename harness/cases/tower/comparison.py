"""Two runs of the same tower held against each other: force, velocity, contacts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import trapezoid

from harness.cases.tower.contact_events import NEAR, EventPair, contact_events, match_events
from harness.comparison.alignment import Samples, align, distinct, missing
from harness.errors import RequestError
from harness.observables.summary import peak_force
from harness.observables.tower import Floats, TowerRun

ROUND_OFF = 1e-12
"""Times closer than this part of the longer run are the same: what printing and summing leave."""

DIVERGENCE = 1e-3
"""Part of the reference's peak force by which two runs differ when they have parted."""


@dataclass(frozen=True)
class Difference:
    """How far a series is from its reference, over ``scale``.

    ``l2`` is the root of the mean over time of the squared difference.
    ``interpolation_error`` is the bound of what interpolation adds to ``peak``,
    0 if the samples are at the same times.
    """

    peak: float
    l2: float
    interpolation_error: float
    scale: float  # [N] or [m/s]


@dataclass(frozen=True)
class SeriesComparison:
    """A run against a reference of the same tower.

    ``force`` is relative to the reference's peak force, ``velocity`` to the speed
    at the start (the reference's largest, if it starts at rest).
    ``force_difference`` (T,) is run - reference in these units at the common ``time`` (T,).
    ``divergence_time`` is the first time at which the force differs by more than
    :data:`DIVERGENCE`, None if it never does.
    """

    run: TowerRun
    reference: TowerRun
    time: Floats  # [s]
    force_difference: Floats  # [peak of the reference]
    force: Difference
    velocity: Difference
    divergence_time: float | None  # [s]
    events: tuple[EventPair, ...]

    @property
    def unmatched(self) -> tuple[EventPair, ...]:
        """Return the events that only one run has."""
        return tuple(pair for pair in self.events if not pair.matched)

    @property
    def largest_event_difference(self) -> float:
        """Return the largest time difference of matched events [s], NaN without any."""
        apart = [abs(pair.difference) for pair in self.events if pair.matched]
        return max(apart, default=float("nan"))


def compare(
    run: TowerRun, reference: TowerRun, *, across_laws: bool = False, least_force: float = 0.0
) -> SeriesComparison:
    """Return how ``run`` differs from ``reference``, over all of the reference.

    Above ``least_force`` [peak] a contact is closed, more than 0 for runs with profiles only.
    Raise RequestError for different cases (the law may differ where ``across_laws`` is set), for
    values that are not finite, for a run that lacks a part of its reference, and for a reference
    without force.
    """
    _same_case(run, reference, across_laws)
    for one in (run, reference):
        _usable(one)
    peak = peak_force(reference)
    if peak <= 0:
        raise RequestError("grain_force: is 0 throughout the reference, nothing to compare with")
    speed = reference.tower.speed or float(np.abs(reference.grain_velocity).max())
    same = ROUND_OFF * max(abs(run.time[-1]), abs(reference.time[-1]))
    lacking = missing(run.time, reference.time, same, thinned=False)
    if lacking:
        raise RequestError(f"time of {run.solver}: series incomplete: {lacking}")
    common = align(_samples(run), _samples(reference), same)
    force, velocity = ((common.value - common.reference) / (peak, speed)).T
    parted = np.flatnonzero(np.abs(force) > DIVERGENCE)
    if not (np.isfinite(least_force) and least_force >= 0):
        raise RequestError(f"least_force = {least_force}: must be finite and at least 0")
    near_s, least_N = NEAR * reference.tower.contact_time, least_force * peak
    return SeriesComparison(
        run=run,
        reference=reference,
        time=common.time,
        force_difference=force,
        force=_difference(common.time, force, float(common.error[0]), peak),
        velocity=_difference(common.time, velocity, float(common.error[1]), speed),
        divergence_time=float(common.time[parted[0]]) if parted.size else None,
        events=tuple(_events(run, reference, near_s, least_N)),
    )


def _samples(run: TowerRun) -> Samples:
    """Return force and velocity of the grain, smooth as long as its contacts stay."""
    contacts = run.contacts.copy()
    if run.tower.start != "gapped":
        rows = distinct(run.time, ROUND_OFF * abs(float(run.time[-1])))
        contacts[: rows[0] + 1] = contacts[rows[1]]  # in touch, though still without a force
    return Samples(run.time, np.column_stack([run.grain_force, run.grain_velocity]), contacts)


def _events(run: TowerRun, reference: TowerRun, near: float, least_force: float) -> list[EventPair]:
    """Return the events in pairs, without those whose counterpart may lie after the end."""
    last = float(min(run.time[-1], reference.time[-1]))
    pairs = match_events(
        contact_events(run, least_force), contact_events(reference, least_force), near
    )
    within = [pair for pair in pairs if pair.known.time <= last]
    return [pair for pair in within if pair.matched or pair.known.time < last - pair.resolution]


def _difference(time: Floats, values: Floats, error: float, scale: float) -> Difference:
    worst = int(np.argmax(np.abs(values)))
    mean_square = float(trapezoid(values**2, time) / (time[-1] - time[0]))
    return Difference(
        peak=float(np.abs(values[worst])),
        l2=float(np.sqrt(mean_square)),
        interpolation_error=error / scale,
        scale=scale,
    )


def _same_case(run: TowerRun, reference: TowerRun, across_laws: bool) -> None:
    ours, theirs = run.tower.model_dump(), reference.tower.model_dump()
    for name, value in ours.items():
        if value != theirs[name] and not (across_laws and name == "law"):
            raise RequestError(
                f"{name} = {value}: differs from the reference's {theirs[name]}; "
                "runs of different cases are not compared"
            )


def _usable(run: TowerRun) -> None:
    for name in ("time", "grain_force", "grain_velocity", "contacts"):
        values = getattr(run, name)
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise RequestError(f"{name} = {values[bad[0]]} in row {bad[0]} of {run.solver}")
    if run.time.size < 2 or (np.diff(run.time) < 0).any() or run.time[-1] <= run.time[0]:
        raise RequestError(f"time of {run.solver}: must rise, over at least two samples")
