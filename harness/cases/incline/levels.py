"""What a level runs of the incline, what it costs an engine, and the tolerances of its checks.

Tolerances and their reasons are in ``case.toml``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pydantic import Field, model_validator

from harness.cases.contract import LevelName
from harness.cases.incline.system import Incline, Route
from harness.cases.text import tolerances_of
from harness.engines.cost import engine_seconds
from harness.engines.traits import Traits
from harness.parameters.base import Parameters
from harness.parameters.law import CLIPPED, PLASTIC, SOURCE, Contact

_TOLD = tolerances_of(__file__)

CLOSED_FORM = _TOLD["CLOSED_FORM"]
EXTRAPOLATED = _TOLD["EXTRAPOLATED"]
ALL_WELLS = _TOLD["ALL_WELLS"]
TWO_WAYS = _TOLD["TWO_WAYS"]
SCALES = _TOLD["SCALES"]
REFERENCE_ANGLE = _TOLD["REFERENCE_ANGLE"]
REFERENCE_PATH = _TOLD["REFERENCE_PATH"]
REFERENCE_SPEED = _TOLD["REFERENCE_SPEED"]
REFERENCE_PASSAGE = _TOLD["REFERENCE_PASSAGE"]
REFERENCE_FIRST_CRESTS = _TOLD["REFERENCE_FIRST_CRESTS"]
REFERENCE_CRESTS = _TOLD["REFERENCE_CRESTS"]
TOLD_ENERGY = _TOLD["TOLD_ENERGY"]
ENERGY_RISE = _TOLD["ENERGY_RISE"]
ADAPTIVE_RESTITUTION = _TOLD["ADAPTIVE_RESTITUTION"]
ENGINES_PLASTIC = _TOLD["ENGINES_PLASTIC"]
ENGINES_OF_ONE_CLASS = _TOLD["ENGINES_OF_ONE_CLASS"]
RIGID = _TOLD["RIGID"]

MOST_ROUTE_JITTER = 2e-3
"""[deg] a stated uncertainty may add to the resolution of a search: where in a step a contact
begins moves the angle of the source's contact by 1e-3 deg at 50 steps in the reference DEM."""

"""Of the baseline's records, by quantity; ``series`` is the band about every series."""


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
        """Return the refined cases, the costliest first so that no core idles at the end."""
        refined = [
            case.replace(stiffness=case.stiffness * factor, steps_per_contact=steps)
            for factor in self.factors
            for steps in self.steps_per_contact
        ]
        return sorted(refined, key=lambda refined_case: refined_case.step)


QUICK_LADDER = Ladder(factors=(0.1, 10**-0.5, 1.0, 10**0.5), steps_per_contact=(50.0, 100.0, 200.0))

FULL_LADDER = Ladder(
    factors=(0.1, 10**-0.5, 1.0, 10**0.5, 10.0, 10**1.5, 100.0),
    steps_per_contact=(50.0, 100.0, 200.0, 400.0),
)


@dataclass(frozen=True)
class Level:
    """Stiffnesses and steps of a level: to extrapolate over, of the other contacts, of engines.

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

    def other_angles(self) -> list[Incline]:
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


PASSAGE, WELL = 2.1, 4.5
"""[sqrt(d/g)] that a run takes by the passage route, and for each well by the steady route: the
mean over the runs of an angle, the same at k = 1e5, 1e6 and 1e8 N/m in the reference DEM."""

COARSE, COARSE_WELLS = 20.0, 100
"""Steps per contact below which fates are not taken to be monotone before they were probed, and
the wells to pass there."""

RUNS_BY_PASSAGE, STEADY_RUNS, COARSE_RUNS = 12, 16, 70
"""Runs behind an angle, likewise; the last at steps so coarse that fates are probed, 60 to 71 at
4.8 steps per contact and k = 1e5 to 1e7 N/m."""


def run_seconds(case: Incline, route: Route, rules: Traits) -> float:
    """Return what one run is expected to take [s]."""
    longest = PASSAGE if route == "passage" else min(WELL * case.wells, case.time_limit)
    steps = longest * math.sqrt(case.diameter / case.gravity) / case.step
    return engine_seconds(steps, case.particles, rules)


def angle_seconds(case: Incline, route: Route, rules: Traits) -> float:
    """Return what a critical angle is expected to take [s], by a case with the wells to pass."""
    runs = RUNS_BY_PASSAGE
    if route == "steady":
        runs = COARSE_RUNS if case.steps_per_contact < COARSE else STEADY_RUNS
    return runs * run_seconds(case, route, rules)


def extrapolation_seconds(case: Incline, rules: Traits) -> float:
    """Return what the angles of all stiffnesses and steps are expected to take [s]."""
    return sum(angle_seconds(refined, "passage", rules) for refined in Ladder().cases(case))
