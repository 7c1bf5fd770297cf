"""How a system of contacts goes from one smooth piece of its motion to the next."""

from __future__ import annotations

import numpy as np

from harness.errors import RequestError
from harness.pair.extrapolation import step
from harness.pair.friction import limits, normal_force, slider_of
from harness.pair.geometry import geometry, normal_and_gap, vector
from harness.pair.normal import MDR
from harness.pair.path import EventKind
from harness.pair.plastic import ELASTIC, PLASTIC, SWELLING, sprung_back
from harness.pair.rates import (
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
    place_of,
)
from harness.pair.records import CONTACT, TWIST_NONE, Floats, Integers, System
from harness.pair.slider import OFF, SLIDE, STICK, Slider, limited, sliding_direction, spring
from harness.pair.vectors import length, scaled

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
    one = system.contacts[c]
    if opens and system.law["normal"] == MDR and g.overlap > one["largest"]:
        one["largest"] = g.overlap
        if one["stage"] != ELASTIC:
            flats = 1.0 if one["second"] < 0 else 2.0
            radius = system.bodies[one["first"]]["radius"]
            one["last"] = flats * sprung_back(system.law, one, g.overlap / flats, radius).left


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
    one = system.contacts[c]
    if not system.law["yields"]:
        one["largest"] = 0.0
        return "reloads"
    if one["stage"] == ELASTIC and one["onset"] < one["swells"]:
        one["stage"] = PLASTIC
        return "yields"
    first = one["stage"] == ELASTIC
    one["stage"] = SWELLING
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


def slide(y: Floats, system: System, modes: Integers, c: int, kind: int) -> None:
    """Let a slider that sticks slide in the direction of its force."""
    cut_back, damping = limits(kind, system.law)
    if cut_back:
        slider, _ = _slider(y, system, modes, c, kind)
        held = sliding_direction(slider, _get(y, system, c, kind), damping)
        _set(y, system, c, kind, held)
    modes[c, SLIDERS + kind] = SLIDE


def settle(y: Floats, system: System, modes: Integers, probe: float) -> None:
    """Decide of every slider that sticks whether it slides.

    Beyond the limit it does. Where force and limit are equal, as at the begin of a contact,
    the state after a time ``probe`` tells.
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
            slider, _ = _slider(later, system, modes, c, kind)
            cut_back, damping = limits(kind, system.law)
            if cut_back:
                held = sliding_direction(slider, _get(later, system, c, kind), damping)
                _set(y, system, c, kind, held)
            modes[c, SLIDERS + kind] = SLIDE


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
