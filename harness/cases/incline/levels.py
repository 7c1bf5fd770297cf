"""How much of the incline a verification runs: quick, default or full."""

from __future__ import annotations

from dataclasses import dataclass

from harness.cases.contract import LevelName
from harness.cases.incline.ladder import FULL_LADDER, QUICK_LADDER, Ladder
from harness.cases.incline.parameters import Incline
from harness.parameters.contact import CLIPPED, PLASTIC, SOURCE, Contact

SOURCE_CLIPPED = Contact(
    name="source, clipped", restitution=SOURCE.restitution, damping_ratio=None, tail="clipped"
)

PLASTIC_CASE = Incline(contact=PLASTIC, stiffness=1e6, steps_per_contact=100.0)
SOURCE_CASE = Incline(contact=SOURCE, stiffness=1e6, steps_per_contact=50.0)

STATED = (1e6, 100.0)
"""Stiffness [N/m] and steps per contact at which engines are held against one another."""


@dataclass(frozen=True)
class Level:
    """The ladder to extrapolate, the stiffnesses and steps of the contacts beside it, and so on.

    ``routes`` are the cases in which steady motion is held against passage. ``engines`` are
    stiffness [N/m] and steps per contact of the angles of engines beside the main one, the stated
    ones first, each averaged over ``phases_of_engines``.
    """

    name: LevelName
    ladder: Ladder
    stiffnesses: tuple[float, ...]
    steps: tuple[float, ...]
    steady_tolerance_deg: float
    phases_beside: int
    routes: tuple[Incline, ...]
    engines: tuple[tuple[float, float], ...] = (STATED,)
    phases_of_engines: int = 4

    def beside(self) -> list[Incline]:
        """Return the cases of the source's contact and the clipped one, the costliest first."""
        cases = [
            Incline(contact=contact, stiffness=stiffness, steps_per_contact=steps)
            for contact in (SOURCE, CLIPPED)
            for stiffness in self.stiffnesses
            for steps in self.steps
        ]
        return sorted(cases, key=lambda case: case.step)


LEVELS: dict[LevelName, Level] = {
    "quick": Level(
        name="quick",
        ladder=QUICK_LADDER,
        stiffnesses=(1e5, 1e6),
        steps=(50.0, 100.0),
        steady_tolerance_deg=5e-3,
        phases_beside=4,
        routes=(SOURCE_CASE,),
        phases_of_engines=2,
    ),
    "default": Level(
        name="default",
        ladder=Ladder(),
        stiffnesses=(1e5, 1e6, 1e7),
        steps=(25.0, 50.0, 100.0, 200.0),
        steady_tolerance_deg=1e-3,
        phases_beside=4,
        routes=(PLASTIC_CASE, SOURCE_CASE),
    ),
    "full": Level(
        name="full",
        ladder=FULL_LADDER,
        stiffnesses=(1e4, 1e5, 1e6, 1e7, 1e8),
        steps=(25.0, 50.0, 100.0, 200.0, 400.0),
        steady_tolerance_deg=1e-3,
        phases_beside=8,
        routes=(PLASTIC_CASE, SOURCE_CASE),
        engines=(
            STATED,
            *((k, n) for k in (1e5, 1e6, 1e7) for n in (50.0, 100.0, 200.0) if (k, n) != STATED),
        ),
    ),
}
