"""Two runs of a tower held against each other: force, velocity, contacts, order in the step.

Onsets and breaks of the contacts of the grain's chain are matched one by one. A contact is in the
grain's chain while it and all contacts before it are closed. Its onset is when it joins, its break
when it leaves, be it by its own opening or by one before it. So a change of several contacts within
one sample and the same change spread over more samples in another run match.

Under the overlap law a whole row of just touching particles closes at once, the
far contacts with forces too small for any number: there the solvers' idea of 0
decides on the onset. A least force, given with profiles, leaves that out.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import trapezoid

from harness.comparison.convergence import slope_order
from harness.comparison.series import Samples, align, distinct, missing
from harness.errors import RequestError
from harness.observables.tower import Floats, TowerRun, peak_force

if TYPE_CHECKING:
    import pandas as pd


Kind = Literal["onset", "break"]

_Decision = Literal["both", "ours", "theirs"]

NEAR = 0.1
"""Events farther apart than this part of t0 are not the same event."""


@dataclass(frozen=True)
class ContactEvent:
    """A contact that joins or leaves the grain's chain; contact 1 is the grain's.

    ``time`` is that of the first sample with the new chain, or located before it where a least
    force is given; ``resolution`` is the distance of the sample before.
    """

    contact: int
    kind: Kind
    time: float  # [s]
    resolution: float  # [s]


@dataclass(frozen=True)
class EventPair:
    """The same event in two runs; one of them is None where the other run has no such event."""

    event: ContactEvent | None
    reference: ContactEvent | None

    @property
    def either(self) -> ContactEvent:
        """Return the event in the reference; where the reference has none, that in the run."""
        event = self.reference or self.event
        assert event is not None
        return event

    @property
    def matched(self) -> bool:
        """Return whether both runs have it."""
        return self.event is not None and self.reference is not None

    @property
    def difference(self) -> float:
        """Return run - reference [s], NaN if not matched."""
        if self.event is None or self.reference is None:
            return float("nan")
        return self.event.time - self.reference.time

    @property
    def resolution(self) -> float:
        """Return how far apart the samples leave the two times uncertain [s]."""
        return sum(event.resolution for event in (self.event, self.reference) if event)


def contact_events(run: TowerRun, least_force: float = 0.0) -> list[ContactEvent]:
    """Return all events of ``run`` in time order.

    A contact counts as closed above ``least_force`` [N]; more than 0 needs a run with profiles,
    else RequestError, and locates the events between samples, where the force is that.

    What is closed at the start has no onset. A row that just touches has one
    contact then, the grain's: the others close as soon as they feel it, and a run
    whose first sample sees them all closed agrees with one that sees them in turn.
    """
    lengths = _chain_lengths(run, least_force)
    events: list[ContactEvent] = []
    for row in np.flatnonzero(np.diff(lengths)) + 1:
        before, after = int(lengths[row - 1]), int(lengths[row])
        kind: Kind = "onset" if after > before else "break"
        first, last = min(before, after) + 1, max(before, after)
        moment = _moment(run, int(row), kind, first, least_force)
        resolution = float(run.time[row] - run.time[row - 1])
        events += [ContactEvent(c, kind, moment, resolution) for c in range(first, last + 1)]
    return events


def _moment(run: TowerRun, row: int, kind: Kind, cause: int, least_force: float) -> float:
    """Return when the force of contact ``cause`` is ``least_force`` [s], at most a sample early.

    By the parabola through the three samples at which that contact is closed, before a break or
    after an onset. The time of ``row``, the first sample with the new chain, where there is no
    least force, a sample is missing, or the parabola has no such root.
    """
    event = float(run.time[row])
    if run.profiles is None or least_force == 0.0:
        return event
    force = run.profiles.forces[:, cause - 1]
    rows = row - 1 - np.arange(3) if kind == "break" else row + np.arange(3)
    if rows.min() < 0 or rows.max() >= run.time.size or (force[rows] <= least_force).any():
        return event
    start = float(run.time[rows[0]])
    since = run.time[rows] - start
    if np.unique(since).size < 3:
        return event
    roots = np.roots(np.polyfit(since, force[rows] - least_force, 2))
    reach = 1.01 * float(run.time[row] - run.time[row - 1])
    sense = 1 if kind == "break" else -1
    ahead = [root for root in roots.real[roots.imag == 0.0] if 0.0 <= sense * root <= reach]
    return start + float(min(ahead, key=abs)) if ahead else event


def _chain_lengths(run: TowerRun, least_force: float) -> NDArray[np.int64]:
    """Return the contacts of the grain's chain (M,), 0 only where nothing touches."""
    if least_force == 0:
        lengths = run.contacts.astype(np.int64)
    elif run.profiles is None:
        raise RequestError(f"least_force = {least_force} N: needs profiles, {run.solver} has none")
    else:
        closed = run.profiles.forces > least_force
        lengths = np.logical_and.accumulate(closed, axis=1).sum(axis=1)
    if run.tower.start == "preloaded":
        lengths[:1] = lengths[1:2]
    elif run.tower.start == "touching" and (run.contacts[1:2] > 0).any():
        lengths[: max(1, int(np.argmax(lengths > 0)))] = 1
    return lengths


def match_events(
    events: Sequence[ContactEvent], references: Sequence[ContactEvent], near: float
) -> list[EventPair]:
    """Return the events of two runs in pairs, in time order, and those left single.

    Onsets are matched with onsets and breaks with breaks of the same contact,
    in their order, so that the sum of the time differences and of ``near`` [s] for
    every pair of singles is least. An extra grazing touch stays single and
    moves no other pair.
    """
    groups: dict[tuple[int, Kind], tuple[list[ContactEvent], list[ContactEvent]]]
    groups = defaultdict(lambda: ([], []))
    for side, listed in enumerate((events, references)):
        for event in listed:
            groups[event.contact, event.kind][side].append(event)
    pairs = [pair for ours, theirs in groups.values() for pair in _aligned(ours, theirs, near)]
    return sorted(pairs, key=lambda pair: (pair.either.time, pair.either.contact))


def _aligned(
    ours: list[ContactEvent], theirs: list[ContactEvent], near: float
) -> list[EventPair]:  # fmt: skip
    """Return the cheapest alignment of two lists in time order: dynamic programming.

    Each cell keeps the decision that led to it: costs are not compared again on the way back.
    """
    n, m = len(ours), len(theirs)
    cost = np.zeros((n + 1, m + 1))
    cost[:, 0] = 0.5 * near * np.arange(n + 1)
    cost[0, :] = 0.5 * near * np.arange(m + 1)
    taken: dict[tuple[int, int], _Decision] = {(i, 0): "ours" for i in range(1, n + 1)}
    taken |= {(0, j): "theirs" for j in range(1, m + 1)}
    for i, event in enumerate(ours, 1):
        for j, reference in enumerate(theirs, 1):
            choices: list[tuple[float, _Decision]] = [
                (cost[i - 1, j] + 0.5 * near, "ours"),
                (cost[i, j - 1] + 0.5 * near, "theirs"),
            ]
            apart = abs(event.time - reference.time)
            if apart <= near:
                choices.insert(0, (cost[i - 1, j - 1] + apart, "both"))
            cost[i, j], taken[i, j] = min(choices, key=lambda choice: choice[0])
    pairs = []
    i, j = n, m
    while i or j:
        decision = taken[i, j]
        i -= decision != "theirs"
        j -= decision != "ours"
        pairs.append(
            EventPair(
                None if decision == "theirs" else ours[i], None if decision == "ours" else theirs[j]
            )
        )
    return pairs


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
    for motion in (run, reference):
        _usable(motion)
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
    within = [pair for pair in pairs if pair.either.time <= last]
    return [pair for pair in within if pair.matched or pair.either.time < last - pair.resolution]


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


FLOOR = 1e-12
"""Relative differences below this are rounding, and tell nothing of an order."""

LEAST = 3
"""Steps that an order with an interval needs."""


@dataclass(frozen=True)
class Order:
    """The order p of error ~ step^p and its 95 % interval; NaN where it is not resolved."""

    value: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class StepConvergence:
    """The errors of one code against a reference at S steps, coarsest first.

    Errors are those of :class:`harness.cases.tower.comparison.Difference`: force over
    the reference's peak, velocity over the speed at the start. ``floor`` (S,)
    is what rounding and interpolation leave; errors of the force at or below it do
    not enter the orders.
    """

    reference: TowerRun
    solver: str
    steps_per_contact: Floats  # (S,)
    step: Floats  # (S,) [s], as run
    peak_error: Floats  # (S,) of the force
    l2_error: Floats  # (S,) of the force
    velocity_error: Floats  # (S,) largest
    floor: Floats  # (S,) of the peak error
    peak_order: Order
    l2_order: Order
    velocity_order: Order

    def to_json(self) -> dict[str, Any]:
        """Return the result as a JSON-ready mapping."""
        tower = self.reference.tower
        return {
            "law": tower.law,
            "height": tower.height,
            "solver": self.solver,
            "reference": self.reference.solver,
            **_order_record("peak_force", self.peak_order),
            **_order_record("l2_force", self.l2_order),
            **_order_record("velocity", self.velocity_order),
            "errors": self.to_frame().to_dict(orient="records"),
        }

    def to_frame(self) -> pd.DataFrame:
        """Return the errors as a table, one row a step."""
        import pandas as pd

        return pd.DataFrame(
            {
                "steps_per_contact": self.steps_per_contact,
                "step_s": self.step,
                "peak_force_error": self.peak_error,
                "l2_force_error": self.l2_error,
                "velocity_error": self.velocity_error,
                "floor": self.floor,
            }
        )


def step_convergence(
    run: Callable[[float], TowerRun], reference: TowerRun, steps_per_contact: Sequence[float]
) -> StepConvergence:
    """Return errors and observed orders of ``run(steps_per_contact)`` against ``reference``.

    Raise RequestError for fewer than three different steps, for a run without a
    step, and for what :func:`harness.cases.tower.comparison.compare` refuses.
    """
    resolutions = sorted(set(steps_per_contact))
    if len(resolutions) < LEAST:
        raise RequestError(
            f"steps_per_contact = {resolutions}: must be at least {LEAST} different ones"
        )
    comparisons = [compare(run(steps), reference) for steps in resolutions]
    taken = [comparison.run.step for comparison in comparisons]
    steps = np.array([step for step in taken if step is not None])
    if steps.size < len(resolutions):
        raise RequestError(f"solver = {comparisons[0].run.solver!r}: has no step to converge in")
    peak = np.array([c.force.peak for c in comparisons])
    l2 = np.array([c.force.l2 for c in comparisons])
    velocity = np.array([c.velocity.peak for c in comparisons])
    # the bound is at twice the spacing of a fourth-order interpolant
    floor = np.array([max(FLOOR, c.force.interpolation_error / 16) for c in comparisons])
    resolved = peak > floor
    return StepConvergence(
        reference=reference,
        solver=comparisons[0].run.solver,
        steps_per_contact=np.array(resolutions),
        step=steps,
        peak_error=peak,
        l2_error=l2,
        velocity_error=velocity,
        floor=floor,
        peak_order=_order(steps, peak, resolved),
        l2_order=_order(steps, l2, resolved),
        velocity_order=_order(steps, velocity, resolved),
    )


def _order(steps: Floats, errors: Floats, resolved: NDArray[np.bool_]) -> Order:
    resolved = resolved & (errors > 0)
    if resolved.sum() < LEAST:
        return Order(float("nan"), (float("nan"), float("nan")))
    return Order(*slope_order(steps[resolved], errors[resolved]))


def _order_record(name: str, order: Order) -> dict[str, Any]:
    """Return an order for JSON: None where it is not resolved."""
    finite = bool(np.isfinite(order.value))
    return {
        f"{name}_order": order.value if finite else None,
        f"{name}_order_interval": list(order.interval) if finite else None,
    }
