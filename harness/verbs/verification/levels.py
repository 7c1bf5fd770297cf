"""How much a verification runs: quick, default or full."""

from __future__ import annotations

from dataclasses import dataclass

from harness.errors import RequestError
from harness.parameters.contact import CLIPPED, SOURCE, Contact
from harness.parameters.incline import Incline
from harness.parameters.ladder import FULL_LADDER, QUICK_LADDER, Ladder

SOURCE_CLIPPED = Contact(
    name="source, clipped", restitution=SOURCE.restitution, damping_ratio=None, tail="clipped"
)


@dataclass(frozen=True)
class Level:
    """The ladder to extrapolate, and the stiffnesses and steps of the contacts beside it."""

    name: str
    ladder: Ladder
    stiffnesses: tuple[float, ...]
    steps: tuple[float, ...]
    steady_tolerance_deg: float

    def beside(self) -> list[Incline]:
        """Return the cases of the source's contact and the clipped one, the costliest first."""
        cases = [
            Incline(contact=contact, stiffness=stiffness, steps_per_contact=steps)
            for contact in (SOURCE, CLIPPED)
            for stiffness in self.stiffnesses
            for steps in self.steps
        ]
        return sorted(cases, key=lambda case: case.step)


LEVELS = {
    "quick": Level("quick", QUICK_LADDER, (1e5, 1e6), (50.0, 100.0), 5e-3),
    "default": Level("default", Ladder(), (1e5, 1e6, 1e7), (25.0, 50.0, 100.0, 200.0), 1e-3),
    "full": Level(
        "full", FULL_LADDER, (1e4, 1e5, 1e6, 1e7, 1e8), (25.0, 50.0, 100.0, 200.0, 400.0), 1e-3
    ),
}


def level(name: str) -> Level:
    """Return a level by name; raise RequestError for a name that is not one."""
    if name not in LEVELS:
        raise RequestError(f"level = {name!r} is not known: must be one of {', '.join(LEVELS)}")
    return LEVELS[name]
