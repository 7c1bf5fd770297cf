"""How much of the incline a verification runs: quick, default or full."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import Field, model_validator

from harness.cases.contract import LevelName
from harness.cases.incline.parameters import Incline
from harness.parameters.base import Parameters
from harness.parameters.contact import CLIPPED, PLASTIC, SOURCE, Contact

SOURCE_CLIPPED = Contact(
    name="source, clipped", restitution=SOURCE.restitution, damping_ratio=None, tail="clipped"
)

PLASTIC_CASE = Incline(contact=PLASTIC, stiffness=1e6, steps_per_contact=100.0)
SOURCE_CASE = Incline(contact=SOURCE, stiffness=1e6, steps_per_contact=50.0)

STATED = (1e6, 100.0)
"""Stiffness [N/m] and steps per contact at which engines are held against one another."""


class Ladder(Parameters):
    """Stiffness factors (times the case's stiffness) and steps per contact time."""

    factors: tuple[float, ...] = Field(
        (0.1, 10**-0.5, 1.0, 10**0.5, 10.0), description="[-] stiffness over the case's stiffness"
    )
    steps_per_contact: tuple[float, ...] = Field(
        (50.0, 100.0, 200.0, 400.0), description="[-] steps per contact time"
    )

    @model_validator(mode="after")
    def _is_long_enough(self) -> Ladder:
        if len(set(self.factors)) < 4 or min(self.factors) <= 0.0:
            raise ValueError(f"factors = {self.factors}: needs four different positive ones")
        if len(set(self.steps_per_contact)) < 3:
            raise ValueError(f"steps_per_contact = {self.steps_per_contact}: needs three different")
        return self

    def cases(self, case: Incline) -> list[Incline]:
        """Return the rungs for a case, the costliest first so that no core idles at the end."""
        rungs = [
            case.replace(stiffness=case.stiffness * factor, steps_per_contact=steps)
            for factor in self.factors
            for steps in self.steps_per_contact
        ]
        return sorted(rungs, key=lambda rung: rung.step)


QUICK_LADDER = Ladder(factors=(0.1, 10**-0.5, 1.0, 10**0.5), steps_per_contact=(50.0, 100.0, 200.0))

FULL_LADDER = Ladder(
    factors=(0.1, 10**-0.5, 1.0, 10**0.5, 10.0, 10**1.5, 100.0),
    steps_per_contact=(50.0, 100.0, 200.0, 400.0),
)


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
