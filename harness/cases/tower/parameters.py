"""The parameters of one run of the tower."""

from __future__ import annotations

from pydantic import Field

from harness.observables.windows import SEARCH
from harness.parameters.tower import Height, Law, Tower


class TowerRunParameters(Tower):
    """A tower, how long it runs and with which step.

    The defaults are those of the scripts: three particles under the overlap law, which every code
    has.
    """

    height: Height = 2
    law: Law = Field(default="overlap", description="[-] contact law")
    duration: float = Field(
        default=SEARCH,
        ge=SEARCH,
        description="[t0] from the start to the final velocity, in contact times of grain and one "
        "fixed particle",
    )
    steps_per_contact: float | None = Field(
        default=None,
        gt=0,
        description="[-] steps in pi sqrt(m/k); 1000 in engines and 4000 in RK4 if not given",
    )

    @property
    def tower(self) -> Tower:
        """Return the tower alone."""
        return Tower(**{name: getattr(self, name) for name in Tower.model_fields})
