"""Onsets and breaks of the contacts of the grain's chain, matched one by one.

A contact is in the grain's chain while it and all contacts before it are
closed. Its onset is when it joins, its break when it leaves, be it by its own
opening or by one before it. So a change of several contacts within one sample
and the same change spread over more samples in another run match.

Under the overlap law a whole row of just touching particles closes at once, the
far contacts with forces too small for any number: there the solvers' idea of 0
decides on the onset. A least force, asked for with profiles, leaves that out.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from harness.errors import RequestError
from harness.observables.tower import TowerRun

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
    def known(self) -> ContactEvent:
        """Return the event in the reference, or where that is missing in the run."""
        found = self.reference or self.event
        assert found is not None
        return found

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
    found: list[ContactEvent] = []
    for row in np.flatnonzero(np.diff(lengths)) + 1:
        before, after = int(lengths[row - 1]), int(lengths[row])
        kind: Kind = "onset" if after > before else "break"
        first, last = min(before, after) + 1, max(before, after)
        moment = _moment(run, int(row), kind, first, least_force)
        resolution = float(run.time[row] - run.time[row - 1])
        found += [ContactEvent(c, kind, moment, resolution) for c in range(first, last + 1)]
    return found


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
    return sorted(pairs, key=lambda pair: (pair.known.time, pair.known.contact))


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
