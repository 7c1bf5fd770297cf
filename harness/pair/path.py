"""What the reference integration of a contact system gives back."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
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
