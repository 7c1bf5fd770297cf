"""A grain's motion until it passes a place or turns back, in fixed or in adaptive steps.

In fixed steps, as in the LAMMPS script, it is looked at every 50 steps whether the grain has passed
a place or turned back.

Adaptive steps are restarted where the contacts change. Between two changes of contact the motion is
smooth: SciPy's DOP853 (Dormand and Prince, order 8) at a tight tolerance is exact for our purposes,
and its events locate the changes. Each of the two spheres about the grain, or the only one, is
apart, or pushes, or (clipped tail only) overlaps without a force.
"""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import OdeSolution, solve_ivp

from harness.errors import EngineMemoryError, EngineNaNError, EngineTimeoutError
from harness.observables.reference import Trajectory
from harness.solvers.grain.row import (
    VELOCITY_VERLET,
    End,
    Grain,
    Row,
    Scheme,
    State,
    begin,
    energy,
    overlap,
    rate_of_change,
    stretch,
    unclipped_force,
)

MOST_SAMPLES = 10_000_000


class TrajectoryIntegrator(ABC):
    """A grain in motion: ``grain``, ``steps`` taken, ``time`` [s], and its samples."""

    grain: Grain
    steps: int = 0

    def __init__(self, grain: Grain, seconds: float) -> None:
        self.grain = grain
        self._deadline = time.monotonic() + seconds
        self._seconds = seconds
        self._samples: list[NDArray[np.float64]] = []
        self._count = 0

    @property
    @abstractmethod
    def time(self) -> float:
        """Return the time [s] since the start."""

    @property
    @abstractmethod
    def over(self) -> bool:
        """Return whether the time limit is reached."""

    @property
    def touching(self) -> bool | None:
        """Return whether the grain is in contact; None where its place tells."""
        return None

    @np.errstate(over="ignore", invalid="ignore")  # NaN is the method's to name
    def energy(self, row: Row) -> float:
        """Return the mechanical energy [J] that decides whether a grain that moves back is lost."""
        x, y, vx, vy = self.grain[:4]
        behind = 0 if row.single or not math.isfinite(x) else math.floor(x / row.diameter)
        return energy(np.array([x - behind * row.diameter, y, vx, vy]), behind, row)

    @abstractmethod
    def watch(self, place: float, floor: float) -> None:
        """Move until x > ``place`` [m], the grain turns back, or the time limit.

        A grain that moves back is given up when its energy falls below ``floor``
        [J]: a method without steps needs to be told. Raise EngineNaNError when
        the state overflows, EngineTimeoutError when it takes too long.
        """

    @abstractmethod
    def finish(self) -> None:
        """Move to the time limit, whatever the grain does. Errors as for ``watch``."""

    def trajectory(self) -> Trajectory:
        """Return the samples taken."""
        return Trajectory(*np.concatenate(self._samples).T)

    def _keep(self, rows: NDArray[np.float64]) -> None:
        """Keep samples, shape (rows, 5)."""
        self._count += len(rows)
        if self._count > MOST_SAMPLES:
            raise EngineMemoryError(f"reference: more than {MOST_SAMPLES:g} samples of one run")
        self._samples.append(rows)

    def _look_at_clock(self) -> None:
        if time.monotonic() > self._deadline:
            raise EngineTimeoutError(
                f"reference: not finished after {self._seconds:g} s of wall time, "
                f"at step {self.steps}"
            )


class InFixedSteps(TrajectoryIntegrator):
    """The grain in steps of ``step`` [s], at most ``longest`` of them, sampled every so many."""

    def __init__(
        self, grain: Grain, step: float, longest: int, every: int | None, seconds: float
    ) -> None:
        super().__init__(grain, seconds)
        self._step, self._longest, self._every = step, longest, every or 0
        if every:
            self._keep(np.array([[0.0, *grain[:4]]]))

    @property
    def time(self) -> float:
        """Return the time [s] since the start."""
        return self.steps * self._step

    @property
    def over(self) -> bool:
        """Return whether the time limit is reached."""
        return self.steps >= self._longest

    def finish(self) -> None:
        """Move to the time limit."""
        self._go(math.inf, watched=False)

    @abstractmethod
    def _go(self, place: float, *, watched: bool = True) -> None:
        """Move to the time limit, or where ``watch`` ends if it is watched."""


AT_ONCE = 20_000_000
"""Steps between two looks at the clock."""

ROWS = 65_536
"""Samples kept at once."""


class FixedStep(InFixedSteps):
    """The grain over a row, in fixed steps of a method."""

    def __init__(
        self, method: int, grain: Grain, row: Row, step: float, longest: int,
        every: int | None, seconds: float,
    ) -> None:  # fmt: skip
        super().__init__(begin(method, grain, row), step, longest, every, seconds)
        self._method, self._row = method, row
        self._buffer = np.empty((ROWS if every else 1, 5))

    def watch(self, place: float, floor: float) -> None:  # noqa: ARG002 - looked at every 50 steps
        """Move until x > ``place`` [m], the grain moves back, or the time limit."""
        if self._method == VELOCITY_VERLET:  # LAMMPS's ``run`` takes the forces anew
            self.grain = begin(self._method, self.grain, self._row)
        self._go(place)

    def _go(self, place: float, *, watched: bool = True) -> None:
        end, scheme = End.FULL, Scheme(self._method, self._row, self._step)
        while end is End.FULL or (end is End.LAST_STEP and not self.over):
            self._look_at_clock()
            last = min(self._longest, self.steps + AT_ONCE)
            self.grain, self.steps, taken, code = stretch(
                scheme, self.grain, self.steps, last, watched, place, self._every, self._buffer
            )
            end = End(code)
            if taken:
                self._keep(self._buffer[:taken].copy())
        if end is End.NOT_A_NUMBER:
            raise EngineNaNError(
                f"reference: the grain's state overflowed (NaN) by step {self.steps}"
            )


RELATIVE, ABSOLUTE = 1e-11, 1e-13
"""Tolerances of a step; the absolute one in units of d, and sqrt(g d) plus the first speed."""

LONGEST_STEP = 0.5
"""[contact time] so that no contact begins and ends within a step unseen."""

STEPS_AT_ONCE = 2000
"""Longest steps between two looks at the clock."""

ROUNDING = 1e-13
"""Overlaps [d] and energies [m g d] below this are rounding."""

OVERRUN = 1e-9
"""[d] past a sphere's centre before the pair of spheres changes: a grain may rest on the centre."""


class Touch(IntEnum):
    """What a sphere does to the grain. SLACK: it overlaps, and its force is clipped."""

    APART = 0
    PUSHES = 1
    SLACK = 2


class Event(NamedTuple):
    """A sign change of ``value(state)`` in a direction, and what is to be done there."""

    value: Callable[[State], float]
    direction: int
    act: Callable[[], bool]


class Adaptive(TrajectoryIntegrator):
    """The grain moved for at most ``longest`` [s], sampled every ``sampling`` [s] if at all."""

    def __init__(
        self, grain: Grain, row: Row, longest: float, sampling: float | None, seconds: float
    ) -> None:
        super().__init__(grain, seconds)
        self._row, self._longest, self._sampling = row, longest, sampling
        self._time, self._sampled = 0.0, 0
        self._behind = 0 if row.single else math.floor(grain.x / row.diameter)
        local = grain.x - self._behind * row.diameter
        self._state = np.array([local, grain.y, grain.vx, grain.vy])
        self._touch = [self._touching(sphere) for sphere in (0, 1)]
        g_d = math.hypot(row.along, row.normal) * row.diameter
        speed = ABSOLUTE * (math.sqrt(g_d) + math.hypot(grain.vx, grain.vy))
        length = ABSOLUTE * row.diameter
        self._absolute = np.array([length, length, speed, speed])
        self._energy_rounding = ROUNDING * row.mass * g_d
        self._longest_step = LONGEST_STEP * row.contact_time
        if sampling is not None:
            self._keep(np.array([[0.0, *grain[:4]]]))

    @property
    def time(self) -> float:
        """Return the time [s] since the start."""
        return self._time

    @property
    def over(self) -> bool:
        """Return whether the time limit is reached."""
        return self._time >= self._longest

    def watch(self, place: float, floor: float) -> None:
        """Move until x > ``place`` [m], the grain turns back or falls below the floor, or time."""
        decided = False
        while not decided and not self.over:
            if self._state[2] < 0.0:
                decided = self._piece(*self._backward(floor))
            else:
                decided = self._piece(*self._forward(place))
        # the place is located from either side of it
        if abs(self.grain.x - place) <= ROUNDING * self._row.diameter and self.grain.vx > 0.0:
            self.grain = self.grain._replace(x=math.nextafter(place, math.inf))

    def finish(self) -> None:
        """Move to the time limit."""
        while not self.over:
            self._piece()

    def _piece(self, *decisions: Event) -> bool:
        """Move to the next event, or as long as may go without a look; return if one decides."""
        self._look_at_clock()
        spheres = (
            self._events(0)
            if self._row.single
            else [*self._cell_events(), *self._events(0), *self._events(1)]
        )
        events = [*decisions, *spheres]
        until = min(self._longest, self._time + STEPS_AT_ONCE * self._longest_step)
        pushing = [touch is Touch.PUSHES for touch in self._touch]
        solution = solve_ivp(
            lambda _, state: rate_of_change(state, self._row, *pushing),
            (self._time, until),
            self._state,
            method="DOP853",
            rtol=RELATIVE,
            atol=self._absolute,
            max_step=self._longest_step,
            events=[_terminal(event) for event in events],
            dense_output=self._sampling is not None,
        )
        if not solution.success or not np.isfinite(solution.y[:, -1]).all():
            raise EngineNaNError(
                f"reference: the grain's state overflowed (NaN) at {solution.t[-1]:g} s "
                f"({solution.message})"
            )
        self.steps += solution.t.size - 1
        self._state = solution.y[:, -1].copy()
        if solution.sol is not None:
            self._sample(solution.sol, float(solution.t[-1]))
        self._time = float(solution.t[-1])
        fired = [e for e, times in zip(events, solution.t_events or [], strict=True) if times.size]
        decided = max([event.act() for event in fired], default=False)  # every one is to act
        x, y, vx, vy = self._state
        self.grain = Grain(x + self._behind * self._row.diameter, y, vx, vy)
        return decided

    def _sample(self, path: OdeSolution, end: float) -> None:
        """Keep the samples up to ``end`` [s]; the path's x is that within the cell."""
        assert self._sampling is not None
        last = math.floor(end / self._sampling * (1.0 + 1e-15))
        times = self._sampling * np.arange(self._sampled + 1, last + 1)
        if times.size:
            rows = np.column_stack([times, np.asarray(path(times), dtype=np.float64).T])
            rows[:, 1] += self._behind * self._row.diameter
            self._keep(rows)
            self._sampled = last

    def _forward(self, place: float) -> list[Event]:
        """Return what decides on a grain that moves on: it passes the place, or turns back."""
        ahead = place - self._behind * self._row.diameter
        return [
            Event(lambda s: s[0] - ahead, 1, lambda: True),
            Event(lambda s: s[2], -1, lambda: self._turn(-1)),
        ]

    def _backward(self, floor: float) -> list[Event]:
        """Return what decides on a grain that moves back: it is too low, or turns again."""
        low = floor - self._energy_rounding
        return [
            Event(lambda s: energy(s, self._behind, self._row) - low, -1, lambda: True),
            Event(lambda s: s[2], 1, lambda: self._turn(1)),
        ]

    def _cell_events(self) -> list[Event]:
        """Return the passages over the sphere ahead, and back over the one behind."""
        beyond = OVERRUN * self._row.diameter
        return [
            Event(lambda s: s[0] - self._row.diameter - beyond, 1, lambda: self._shift(1)),
            Event(lambda s: s[0] + beyond, -1, lambda: self._shift(-1)),
        ]

    def _events(self, sphere: int) -> list[Event]:
        """Return the changes that the contact with a sphere (0 behind, 1 ahead) can see next."""

        def gap(state: State) -> float:
            return -overlap(state, self._row, sphere)

        def force(state: State) -> float:
            return unclipped_force(state, self._row, sphere)

        def becomes(touch: Touch) -> Callable[[], bool]:
            return lambda: self._change(sphere, touch)

        match self._touch[sphere]:
            case Touch.APART:
                # a grain that has parted at the speed of rounding shall not part for ever
                begun = ROUNDING * self._row.diameter
                return [Event(lambda s: gap(s) + begun, -1, becomes(Touch.PUSHES))]
            case Touch.SLACK:
                return [Event(gap, 1, becomes(Touch.APART)), Event(force, 1, becomes(Touch.PUSHES))]
        if self._row.clipped:
            return [Event(force, -1, lambda: self._clip(sphere))]
        return [Event(gap, 1, becomes(Touch.APART))]

    def _change(self, sphere: int, touch: Touch) -> bool:
        self._touch[sphere] = touch
        return False

    def _clip(self, sphere: int) -> bool:
        """Let the force go; where the overlap goes with it (no damping), they part."""
        overlaps = overlap(self._state, self._row, sphere) > ROUNDING * self._row.diameter
        return self._change(sphere, Touch.SLACK if overlaps else Touch.APART)

    def _shift(self, cells: int) -> bool:
        """Go on between the next two spheres; the new one is a diameter away or more."""
        self._behind += cells
        self._state[0] -= cells * self._row.diameter
        first, second = self._touch
        self._touch = [second, Touch.APART] if cells > 0 else [Touch.APART, first]
        return False

    def _turn(self, direction: int) -> bool:
        """Put vx on the side it turns to, as its root lies on either; turning back decides."""
        self._state[2] = direction * max(direction * self._state[2], math.ulp(0.0))
        return direction < 0

    def _touching(self, sphere: int) -> Touch:
        if (sphere > 0 and self._row.single) or overlap(self._state, self._row, sphere) <= 0.0:
            return Touch.APART
        if self._row.clipped and unclipped_force(self._state, self._row, sphere) < 0.0:
            return Touch.SLACK
        return Touch.PUSHES


def _terminal(event: Event) -> Callable[[float, State], float]:
    """Return an event as SciPy wants it: a function with attributes."""

    def value(_: float, state: State) -> float:
        return event.value(state)

    value.terminal = True  # type: ignore[attr-defined]
    value.direction = event.direction  # type: ignore[attr-defined]
    return value
