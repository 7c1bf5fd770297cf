"""How much a verification runs: quick, default or full."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from harness.cases.incline.ladder import FULL_LADDER, QUICK_LADDER, Ladder
from harness.cases.incline.parameters import Incline
from harness.errors import RequestError
from harness.parameters.contact import CLIPPED, PLASTIC, SOURCE, Contact

SOURCE_CLIPPED = Contact(
    name="source, clipped", restitution=SOURCE.restitution, damping_ratio=None, tail="clipped"
)


PLASTIC_CASE = Incline(contact=PLASTIC, stiffness=1e6, steps_per_contact=100.0)
SOURCE_CASE = Incline(contact=SOURCE, stiffness=1e6, steps_per_contact=50.0)


@dataclass(frozen=True)
class Level:
    """The ladder to extrapolate, the stiffnesses and steps of the contacts beside it, and so on.

    ``routes`` are the cases in which steady motion is held against passage;
    ``heights`` and ``gammas`` (of the map of alpha) are those of the tower.
    """

    name: str
    ladder: Ladder
    stiffnesses: tuple[float, ...]
    steps: tuple[float, ...]
    steady_tolerance_deg: float
    phases_beside: int
    routes: tuple[Incline, ...]
    heights: tuple[int, ...]
    gammas: tuple[float, ...]
    chain_figures: bool = True

    def beside(self) -> list[Incline]:
        """Return the cases of the source's contact and the clipped one, the costliest first."""
        cases = [
            Incline(contact=contact, stiffness=stiffness, steps_per_contact=steps)
            for contact in (SOURCE, CLIPPED)
            for stiffness in self.stiffnesses
            for steps in self.steps
        ]
        return sorted(cases, key=lambda case: case.step)


GAMMAS = tuple(float(gamma) for gamma in np.geomspace(1e-4, 0.3, 25))
"""From stiff and fast to soft and slow: the source's six runs lie between 0.0008 and 0.016."""

LEVELS = {
    "quick": Level(
        name="quick",
        ladder=QUICK_LADDER,
        stiffnesses=(1e5, 1e6),
        steps=(50.0, 100.0),
        steady_tolerance_deg=5e-3,
        phases_beside=4,
        routes=(SOURCE_CASE,),
        heights=(1, 2, 19),
        gammas=(),
        chain_figures=False,
    ),
    "default": Level(
        name="default",
        ladder=Ladder(),
        stiffnesses=(1e5, 1e6, 1e7),
        steps=(25.0, 50.0, 100.0, 200.0),
        steady_tolerance_deg=1e-3,
        phases_beside=4,
        routes=(PLASTIC_CASE, SOURCE_CASE),
        heights=(1, 2, 3, 10, 19),
        gammas=GAMMAS[::3],
    ),
    "full": Level(
        name="full",
        ladder=FULL_LADDER,
        stiffnesses=(1e4, 1e5, 1e6, 1e7, 1e8),
        steps=(25.0, 50.0, 100.0, 200.0, 400.0),
        steady_tolerance_deg=1e-3,
        phases_beside=8,
        routes=(PLASTIC_CASE, SOURCE_CASE),
        heights=tuple(range(1, 20)),
        gammas=GAMMAS,
    ),
}


def level(name: str) -> Level:
    """Return a level by name; raise RequestError for a name that is not one."""
    if name not in LEVELS:
        raise RequestError(f"level = {name!r} is not known: must be one of {', '.join(LEVELS)}")
    return LEVELS[name]
