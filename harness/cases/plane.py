"""What cases of a grain in a plane share: equal spheres with a linear contact, and the path."""

from __future__ import annotations

import math

from pydantic import Field

from harness.engines.base import Output
from harness.engines.output import Table
from harness.model.base import Parameters
from harness.model.law import PLASTIC, NamedContact

UNIT_MASS_DENSITY = 6.0 / math.pi  # [kg/m3] gives a sphere of 1 m the mass of 1 kg
COLUMNS = ("time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s")


class EqualSpheres(Parameters):
    """A grain and spheres of its size, with a linear spring and a dashpot, in SI units."""

    # fmt: off
    contact: NamedContact = Field(PLASTIC, description="[-] dissipation of the contact")
    stiffness: float = Field(1e6, gt=0.0, description="[N/m] normal stiffness")
    steps_per_contact: float = Field(
        100.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)")
    diameter: float = Field(1.0, gt=0.0, description="[m] diameter of all spheres")
    density: float = Field(UNIT_MASS_DENSITY, gt=0.0, description="[kg/m3] density of the grain")
    gravity: float = Field(9.81, gt=0.0, description="[m/s2] acceleration of gravity")
    # fmt: on

    @property
    def mass(self) -> float:
        """Return the grain's mass [kg]."""
        return self.density * math.pi / 6.0 * self.diameter**3

    @property
    def contact_time(self) -> float:
        """Return pi sqrt(m / k) [s], the undamped contact time in which steps are counted."""
        return math.pi * math.sqrt(self.mass / self.stiffness)

    @property
    def step(self) -> float:
        """Return the time step [s]."""
        return self.contact_time / self.steps_per_contact


def path_in(output: Output, rows: int | None = None) -> Table:
    """Return the path of the grain, which is the first of several bodies, each column (M,).

    Raise EngineOutputError for samples that are missing, and for another number of ``rows``.
    """
    table = output.table(COLUMNS, rows)
    names = [name for name in ("step", *COLUMNS) if name in table]
    return {n: table[n][:, 0] if table[n].ndim == 2 else table[n] for n in names}
