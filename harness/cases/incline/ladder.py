"""The ladder of stiffnesses and steps over which a critical angle is extrapolated."""

from __future__ import annotations

from pydantic import Field, model_validator

from harness.cases.incline.parameters import Incline
from harness.parameters.base import Parameters


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
