"""A system of contacts on its way: smooth pieces of motion between events that are located.

Free flight is a parabola, its end the root of a polynomial. In contact, an extrapolation step of
order 12 with error control goes on until an ending (:func:`harness.pair.rates.endings`) turns
positive, at the end of the step or between (:mod:`harness.pair.between`); the ending is located by
taking the same step shorter, to round-off (:mod:`harness.pair.locate`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from harness.errors import RequestError
from harness.pair.extrapolation import step
from harness.pair.flight import flown, next_contact
from harness.pair.friction import normal_force
from harness.pair.geometry import geometry
from harness.pair.locate import first_ending
from harness.pair.path import Event, EventKind, SliderName
from harness.pair.proceed import proceed
from harness.pair.rates import LOAD, OPEN, SIGN, SLIDERS, STATE, TOUCH, forces
from harness.pair.records import BODY, Floats, Integers, System
from harness.pair.scales import set_size, state_scales
from harness.pair.slider import OFF, SLIDE
from harness.pair.switching import begin, settle, stick, switch, turn
from harness.parameters.contact_scene import Segment

MOST_EVENTS_AT_ONCE = 50
START = 1e-12
"""[overlap / speed] for which springs stick as a contact begins: force and limit are 0 at first."""

PROBE = 1e-6
"""[overlap / speed] after which a slider shows whether it slides."""

LEAST = 1e-18
"""[overlap / speed] to which the time of an ending is located."""

SLIDER_NAMES: tuple[SliderName, ...] = ("tangential", "rolling", "twisting")


@dataclass
class Motion:
    """State, modes and events of an integration at a time."""

    system: System
    y: Floats
    modes: Integers
    tolerance: float
    time: float = 0.0
    h: float = 0.0
    steps: int = 0
    at_once: int = 0
    events: list[Event] = field(default_factory=list)

    def start(self) -> None:
        """Note contacts that overlap from the start as begun."""
        for c in self.closed():
            set_size(self.y, self.system, c)
            self._note("begins", c, "")
        self._rescale()
        if self.closed():
            self._settle()

    def closed(self) -> list[int]:
        """Return the contacts that are closed."""
        return [c for c, state in enumerate(self.modes[:, STATE].tolist()) if state != OPEN]

    def unit(self) -> float:
        """Return the shortest of the contacts' times overlap / speed [s]."""
        sizes = self.system.contacts
        times: list[float] = (sizes["overlap"] / sizes["speed"]).tolist()
        return min(times[c] for c in self.closed())

    def prescribe(self, segment: Segment) -> None:
        """Give every body the velocities of a segment; springs stay as they are."""
        slid = self._sliding()
        for c, kind in slid:
            stick(self.y, self.system, self.modes, c, kind)
        bodies = self.y[: BODY * len(self.system.bodies)].reshape(-1, BODY)
        bodies[:, 3:6], bodies[:, 6:9] = np.array(segment.velocities), np.array(segment.omegas)
        for c in self.closed():
            set_size(self.y, self.system, c)
            turn(self.y, self.system, self.modes, c)
        self._rescale()
        if self.closed():
            self._settle(slid)

    def advance(self, end: float) -> None:
        """Move on to a time."""
        while self.time < end:
            if self.closed():
                self._step(end)
            else:
                self._fly(end)

    def _fly(self, end: float) -> None:
        wait, c = next_contact(self.y, self.system)
        if self.time + wait > end:
            self.y = flown(self.y, self.system, end - self.time)
            self.time = end
            return
        self.y = flown(self.y, self.system, wait)
        self.time += wait
        self._begin(c)

    def _begin(self, c: int) -> None:
        slid = self._sliding()
        begin(self.y, self.system, self.modes, c, 0.0)
        set_size(self.y, self.system, c)
        self._note("begins", c, "")
        self._rescale()
        start = START * self.unit()
        self.y, _ = step(self.y, start, np.ones_like(self.y), self.system, self.modes)
        self.time += start
        self._settle(slid)
        self.h = start

    def _sliding(self) -> list[tuple[int, int]]:
        """Return contact and kind of every slider that slides."""
        found = np.argwhere(self.modes[:, SLIDERS : SLIDERS + 3] == SLIDE)
        return [(int(c), int(kind)) for c, kind in found]

    def _settle(self, slid: Sequence[tuple[int, int]] = ()) -> None:
        """Decide which sliders slide, and note what changed against those that ``slid``."""
        settle(self.y, self.system, self.modes, PROBE * self.unit())
        slides = self._sliding()
        for c, kind in sorted({*slides} ^ {*slid}):
            if self.modes[c, SLIDERS + kind] != OFF:
                self._note("slides" if (c, kind) in slides else "sticks", c, SLIDER_NAMES[kind])
        self._rescale()

    def _step(self, end: float) -> None:
        """Take steps up to a time or to the first ending."""
        self._rescale()
        span = (self.time, end)
        control = (self.h, 1e-17 * self.unit(), self.tolerance)
        states, (time, h, following), taken = proceed(
            self.y, span, control, self.system, self.modes
        )
        self.y, self.time, self.steps = states[0], time, self.steps + taken
        self.at_once = 0 if taken else self.at_once
        if math.isnan(h):
            raise ArithmeticError(f"contact integration: no step at t = {time!r} s")
        self.h = following
        if h == 0.0:
            return
        self.steps += 1
        first = first_ending(states, h, self.system, self.modes, LEAST * self.unit())
        if first is None:
            self.y, self.at_once = states[1], 0
            self.time = end if h == end - time else time + h
        else:
            self._switch(*first)

    def _switch(self, part: float, where: tuple[int, int]) -> None:
        if part > 0.0:
            self.y, _ = step(self.y, part, np.ones_like(self.y), self.system, self.modes)
            self.time += part
        self.at_once = 0 if part > 1e-12 * self.unit() else self.at_once + 1
        if self.at_once > MOST_EVENTS_AT_ONCE:
            raise RequestError(
                f"rules: sticking and sliding take turns without end at t = {self.time!r} s; a "
                "dashpot that acts while sticking only makes the force jump (damping_in_cap)"
            )
        c, column = where
        if column == TOUCH and self.modes[c, STATE] == OPEN:
            self._begin(c)
            return
        name: SliderName = ""
        if SLIDERS <= column < SLIDERS + 3:
            name = SLIDER_NAMES[column - SLIDERS]
        values, slid, before = self._event_values(c), self._sliding(), self._accelerations()
        kind = switch(self.y, self.system, self.modes, where)
        after = self._accelerations()
        self.events.append(Event(self.time, kind, self.name(c), *values, name, before, after))
        if column == LOAD:
            self._settle(slid)
        self._rescale()
        if self.closed():
            self.h = min(self.h, 0.1 * self.unit())

    def _rescale(self) -> None:
        if self.closed():
            state_scales(self.y, self.system, self.modes)  # a contact that outgrew its size
            self.h = self.h or 1e-3 * self.unit()

    def _event_values(self, c: int) -> tuple[float, float]:
        g = geometry(self.y, self.system, c)
        return g.overlap, normal_force(g, self.system, c, int(self.modes[c, SIGN])).force

    def _accelerations(self) -> Floats:
        """Return what the contacts accelerate the bodies by [m/s2, rad/s2], (bodies, 6)."""
        acting, bodies = forces(self.y, self.system, self.modes), self.system.bodies
        inverse = np.repeat([bodies["inverse_mass"], bodies["inverse_inertia"]], 3, axis=0).T
        return np.asarray(acting * inverse)

    def _note(self, kind: EventKind, c: int, slider: SliderName) -> None:
        values, now = self._event_values(c), self._accelerations()
        self.events.append(Event(self.time, kind, self.name(c), *values, slider, now, now))

    def name(self, c: int) -> tuple[int, int]:
        """Return the bodies of a contact, or its body and plane."""
        one = self.system.contacts[c]
        return int(one["first"]), int(one["second"])
