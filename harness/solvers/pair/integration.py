"""The reference integration of a scene: smooth pieces of motion between events that are located.

:func:`integrate` returns the sampled motion and its events. Free flight is a parabola, its end the
root of a polynomial. In contact, an extrapolation step of order 12 with error control goes on until
an ending (:func:`harness.solvers.pair.rates.endings`) turns positive, at the end of the step or
between; the ending is located by taking the same step shorter, to round-off
(:mod:`harness.solvers.pair.steps`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from typing import Literal

import numpy as np

from harness.errors import RequestError
from harness.parameters.rules import Rules
from harness.parameters.scene import ContactScene, Segment
from harness.solvers.pair.friction import (
    OFF,
    SLIDE,
    STICK,
    Slider,
    limited,
    limits,
    normal_force,
    slider_of,
    sliding_direction,
    spring,
)
from harness.solvers.pair.geometry import flown, geometry, next_contact, normal_and_gap, vector
from harness.solvers.pair.normal import ELASTIC, MDR, PLASTIC, SWELLING, sprung_back
from harness.solvers.pair.rates import (
    CLIPPED,
    CLOSED,
    LOAD,
    OPEN,
    OPENING,
    SIGN,
    SLIDERS,
    STAGE,
    STATE,
    TOUCH,
    TURN,
    forces,
    place_of,
    sampled,
    set_size,
    state_scales,
)
from harness.solvers.pair.records import (
    BODY,
    CONTACT,
    TWIST_NONE,
    Floats,
    Integers,
    System,
    length,
    scaled,
)
from harness.solvers.pair.steps import first_ending, proceed, step
from harness.solvers.pair.system import first_modes, system_of

SliderName = Literal["", "tangential", "rolling", "twisting"]
EventKind = Literal[
    "begins",
    "ends",
    "turns",
    "clips",
    "attracts",
    "repels",
    "slides",
    "sticks",
    "yields",
    "swells",
    "reloads",
]


@dataclass(frozen=True)
class Event:
    """What happens to a contact at a time [s], to which of its sliders where it is one of them.

    ``contact`` names both bodies by their number, or body and plane: (0, 1) or (0, -1) for the
    first plane. ``force`` is the normal force [N] just before, ``overlap`` in m. ``turns``:
    the overlap is largest or smallest there; ``attracts``: the normal force turns negative;
    ``swells``: the radius of a sphere that yields begins to grow; ``reloads``: the overlap passes
    the one from which it opened before, where mdr tells them apart. ``before`` and ``after`` are
    the accelerations [m/s2, rad/s2] by the contacts at the event, (bodies, 6).
    """

    time: float
    kind: EventKind
    contact: tuple[int, int]
    overlap: float
    force: float
    slider: SliderName = ""
    before: Floats = field(default_factory=lambda: np.zeros((0, 6)), compare=False, repr=False)
    after: Floats = field(default_factory=lambda: np.zeros((0, 6)), compare=False, repr=False)


@dataclass(frozen=True)
class ContactPath:
    """Samples of the motion: at the start and after every ``scene.every`` steps.

    times (S,) [s]; positions, velocities, omegas (S, bodies, 3) [m, m/s, rad/s]; forces, torques
    (S, bodies, 3) [N, N m] of the contacts alone, without gravity; overlaps (S, contacts) [m],
    negative where apart; springs (S, contacts, 3, 3) [N, N, N m], elastic force of the tangential,
    rolling and twisting spring on the first body of the contact. ``contacts`` names them.
    """

    times: Floats
    positions: Floats
    velocities: Floats
    omegas: Floats
    forces: Floats
    torques: Floats
    overlaps: Floats
    springs: Floats
    contacts: tuple[tuple[int, int], ...]
    events: tuple[Event, ...]
    steps: int
    """Accepted steps of the integration."""

    def of_kind(self, *kinds: EventKind) -> tuple[Event, ...]:
        """Return the events of some kinds, in order of time."""
        return tuple(event for event in self.events if event.kind in kinds)

    def contact_times(self) -> tuple[float, ...]:
        """Return how long each contact that has ended lasted [s], in order of their ends."""
        began: dict[tuple[int, int], float] = {}
        lasted = []
        for event in self.of_kind("begins", "ends"):
            if event.kind == "begins":
                began[event.contact] = event.time
            else:
                lasted.append(event.time - began[event.contact])
        return tuple(lasted)


# ---- from one smooth piece of the motion to the next

CLOSE_TO_LIMIT = 1e-9
"""[limit] below which a probe, not the force itself, tells whether a slider slides."""


def begin(y: Floats, system: System, modes: Integers, c: int, overlap: float) -> None:
    """Close a contact with unstretched springs, its sliders undecided (sticking)."""
    at = place_of(system, c)
    y[at : at + CONTACT] = 0.0
    y[at] = overlap
    law = system.law
    active = (law["tangential"], law["rolling"], law["twisting"] != TWIST_NONE)
    modes[c, SLIDERS : SLIDERS + 3] = np.where(active, STICK, OFF)
    modes[c, STATE], modes[c, SIGN] = CLOSED, 1
    if system.contacts[c]["stage"] != ELASTIC:
        raise RequestError("bodies: mdr with yield takes one contact: a second one is not flat")
    system.contacts[c]["largest"] = 0.0
    turn(y, system, modes, c)


def open_contacts(y: Floats, system: System, modes: Integers) -> None:
    """Close every contact that overlaps at the start."""
    for c in range(len(system.contacts)):
        overlap = normal_and_gap(y, system, c)[1]
        if overlap > 0.0 and system.law["yields"]:
            raise RequestError("bodies: mdr with yield takes bodies that begin apart")
        if overlap > 0.0:
            begin(y, system, modes, c, overlap)


def turn(y: Floats, system: System, modes: Integers, c: int) -> None:
    """Note whether a contact opens, and from where: mdr remembers its largest overlap."""
    g = geometry(y, system, c)
    opens = g.closing < 0.0
    modes[c, OPENING] = opens
    contact = system.contacts[c]
    if opens and system.law["normal"] == MDR and g.overlap > contact["largest"]:
        contact["largest"] = g.overlap
        if contact["stage"] != ELASTIC:
            flats = 1.0 if contact["second"] < 0 else 2.0
            radius = system.bodies[contact["first"]]["radius"]
            dent = sprung_back(system.law, contact, g.overlap / flats, radius)
            contact["last"] = flats * dent.residual


def switch(y: Floats, system: System, modes: Integers, where: tuple[int, int]) -> EventKind:
    """Change the mode of a contact after an ending (contact, column); return what it was.

    After a change of the normal force's sign its sliders stick, to be settled.
    """
    c, column = where
    if column == TOUCH:
        modes[c] = (OPEN, 1, OFF, OFF, OFF, 0)
        y[place_of(system, c) : place_of(system, c) + CONTACT] = 0.0
        return "ends"
    if column == LOAD:
        return _switch_load(y, system, modes, c)
    if column == TURN:
        opens = 1 - modes[c, OPENING]
        turn(y, system, modes, c)
        modes[c, OPENING] = opens
        return "turns"
    if column == STAGE:
        return _next_stage(system, c)
    kind = column - SLIDERS
    if modes[c, column] == STICK:
        slide(y, system, modes, c, kind)
        return "slides"
    stick(y, system, modes, c, kind)
    return "sticks"


def _next_stage(system: System, c: int) -> EventKind:
    """Let a contact yield, or swell: at once where its radius grows from the onset on.

    One that does not yield is loaded on from where it opened before.
    """
    contact = system.contacts[c]
    if not system.law["yields"]:
        contact["largest"] = 0.0
        return "reloads"
    if contact["stage"] == ELASTIC and contact["onset"] < contact["swells"]:
        contact["stage"] = PLASTIC
        return "yields"
    first = contact["stage"] == ELASTIC
    contact["stage"] = SWELLING
    return "yields" if first else "swells"


def _switch_load(y: Floats, system: System, modes: Integers, c: int) -> EventKind:
    """Change the sign of the normal force, or clip it, or let it act again."""
    for slider in range(3):
        stick(y, system, modes, c, slider)
    kind: EventKind
    if system.law["clipped"]:
        modes[c, STATE] = CLOSED if modes[c, STATE] == CLIPPED else CLIPPED
        kind = "clips" if modes[c, STATE] == CLIPPED else "repels"
    else:
        modes[c, SIGN] = -modes[c, SIGN]
        kind = "attracts" if modes[c, SIGN] < 0 else "repels"
    if kind == "repels" and system.law["clipped"]:
        _relax(y, system, modes, c)
    return kind


def _relax(y: Floats, system: System, modes: Integers, c: int) -> None:
    """Set springs to what the limit 0 cut them back to: they balance the dashpot."""
    for kind in range(3):
        cut_back, _ = limits(kind, system.law)
        slider, _ = _slider(y, system, modes, c, kind)
        if modes[c, SLIDERS + kind] != OFF and cut_back:
            _set(y, system, c, kind, scaled(-slider.dashpot / slider.stiffness, slider.velocity))


def stick(y: Floats, system: System, modes: Integers, c: int, kind: int) -> None:
    """Let a slider stick with the spring that it has."""
    mode = modes[c, SLIDERS + kind]
    if mode != SLIDE:
        return
    cut_back, damping = limits(kind, system.law)
    if cut_back:
        slider, load = _slider(y, system, modes, c, kind)
        cap = slider.friction * load
        held = spring(slider, _get(y, system, c, kind), mode, cap, damping)
        _set(y, system, c, kind, scaled(-1.0 / slider.stiffness, held))
    modes[c, SLIDERS + kind] = STICK


def slide(
    y: Floats, system: System, modes: Integers, c: int, kind: int, later: Floats | None = None
) -> None:
    """Let a slider that sticks slide in the direction of its force, in a ``later`` state if any."""
    cut_back, damping = limits(kind, system.law)
    if cut_back:
        probed = y if later is None else later
        slider, _ = _slider(probed, system, modes, c, kind)
        held = sliding_direction(slider, _get(probed, system, c, kind), damping)
        _set(y, system, c, kind, held)
    modes[c, SLIDERS + kind] = SLIDE


def settle(y: Floats, system: System, modes: Integers, probe: float) -> None:
    """Decide of every slider that sticks whether it slides.

    Beyond the limit it does. Where force and limit are equal, as at the begin of a contact,
    the state after a time ``probe`` decides.
    """
    open_cases = []
    for c in range(len(system.contacts)):
        for kind in range(3) if modes[c, STATE] == CLOSED else ():
            if modes[c, SLIDERS + kind] != STICK:
                continue
            over, size = _over(y, system, modes, c, kind)
            if over > CLOSE_TO_LIMIT * size:
                slide(y, system, modes, c, kind)
            elif over >= -CLOSE_TO_LIMIT * size:
                open_cases.append((c, kind))
    if not open_cases:
        return
    later, _ = step(y, probe, np.ones_like(y), system, modes)
    for c, kind in open_cases:
        over, _ = _over(later, system, modes, c, kind)
        if over > 0.0:
            slide(y, system, modes, c, kind, later)


def _over(y: Floats, system: System, modes: Integers, c: int, kind: int) -> tuple[float, float]:
    """Return by how much a slider that sticks is beyond its limit, and the size of the limit.

    Where the normal force vanishes in a contact, that size is of its elastic part alone.
    """
    g = geometry(y, system, c)
    normal = normal_force(g, system, c, modes[c, SIGN])
    slider = slider_of(kind, g, normal, system, c, modes[c, OPENING] == 1)
    held = limited(slider, _get(y, system, c, kind), limits(kind, system.law)[1])
    cap = slider.friction * normal.load
    return length(held) - cap, max(cap, slider.friction * normal.elastic.force)


def _slider(y: Floats, system: System, modes: Integers, c: int, kind: int) -> tuple[Slider, float]:
    g = geometry(y, system, c)
    normal = normal_force(g, system, c, modes[c, SIGN])
    return slider_of(kind, g, normal, system, c, modes[c, OPENING] == 1), normal.load


def _get(y: Floats, system: System, c: int, kind: int) -> tuple[float, float, float]:
    return vector(y, place_of(system, c) + 1 + 3 * kind)


def _set(y: Floats, system: System, c: int, kind: int, value: tuple[float, float, float]) -> None:
    at = place_of(system, c) + 1 + 3 * kind
    y[at : at + 3] = value


# ---- the motion, piece by piece

MOST_EVENTS_AT_ONCE = 50
START = 1e-12
"""[overlap / speed] for which springs stick as a contact begins: force and limit are 0 at first."""

PROBE = 1e-6
"""[overlap / speed] after which a slider shows whether it slides."""

LEAST = 1e-18
"""[overlap / speed] to which the time of an ending is located."""

SLIDER_NAMES: tuple[SliderName, ...] = ("tangential", "rolling", "twisting")


@dataclass
class Integration:
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
        places = np.argwhere(self.modes[:, SLIDERS : SLIDERS + 3] == SLIDE)
        return [(int(c), int(kind)) for c, kind in places]

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
        contact = self.system.contacts[c]
        return int(contact["first"]), int(contact["second"])


TOLERANCE = 1e-15
"""[overlap, speed of the contact] local error of a step."""


def integrate(
    scene: ContactScene, rules: Rules | None = None, tolerance: float = TOLERANCE
) -> ContactPath:
    """Return the motion of a scene under its law, or the forces along prescribed motion.

    ``tolerance`` bounds the local error of a step in units of the contact's overlap and speed.
    """
    system = system_of(scene, rules or Rules())
    motion = Integration(system, _first_state(scene, system), first_modes(system), tolerance)
    open_contacts(motion.y, system, motion.modes)
    motion.start()
    samples = []
    starts = dict(
        zip(accumulate(s.steps for s in scene.segments), scene.segments[1:], strict=False)
    )
    if scene.segments:
        motion.prescribe(scene.segments[0])
    for number in sorted({*range(0, scene.steps + 1, scene.every), *starts}):
        motion.advance(number * scene.step)
        if number % scene.every == 0:
            samples.append(_sample(motion))
        if number in starts:
            motion.prescribe(starts[number])
    times, bodies, acting, overlaps, springs = (
        np.array(part) for part in zip(*samples, strict=True)
    )
    return ContactPath(
        times=times,
        positions=bodies[:, :, 0],
        velocities=bodies[:, :, 1],
        omegas=bodies[:, :, 2],
        forces=acting[:, :, :3],
        torques=acting[:, :, 3:],
        overlaps=overlaps,
        springs=springs,
        contacts=tuple(motion.name(c) for c in range(len(system.contacts))),
        events=tuple(motion.events),
        steps=motion.steps,
    )


def _first_state(scene: ContactScene, system: System) -> Floats:
    y = np.zeros(BODY * len(scene.bodies) + CONTACT * len(system.contacts))
    for b, body in enumerate(scene.bodies):
        y[BODY * b : BODY * b + BODY] = (*body.position, *body.velocity, *body.omega)
    return y


def _sample(motion: Integration) -> tuple[Floats, ...]:
    """Return time, bodies, forces, overlaps and springs as they are now."""
    y, system = motion.y, motion.system
    bodies = y[: BODY * len(system.bodies)].reshape(-1, 3, 3).copy()
    return np.array(motion.time), bodies, *sampled(y, system, motion.modes)
