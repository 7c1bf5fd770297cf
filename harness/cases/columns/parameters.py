"""One grain over a row of columns: what the incline has, and how the columns give way."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import Field, model_validator

from harness.cases.incline.parameters import Incline
from harness.parameters.tower import Law

Inside = Literal["damped", "elastic"]

MOST_SUNK = 0.1
"""[d] by which a column may sink under its own weight: more is another geometry."""


class Columns(Incline):
    """One run of a grain over columns of ``n`` particles, in SI units.

    The fixed spheres of the incline's row are the tops of columns normal to it, whose particles
    move along the column's axis alone and whose last one is fixed: with ``n`` = 1 it is the
    incline. The contact of the grain with a top is the incline's, coefficient by coefficient,
    whatever ``n``.
    """

    n: int = Field(4, ge=1, le=100, strict=True, description="[-] particles of a column")
    law: Law = Field("overlap", description="[-] contact law, the source's or that of DEM codes")
    inside: Inside = Field(
        "damped", description="[-] contacts within columns: with the grain's dashpot or without"
    )
    spheres: int = Field(4, ge=4, le=100_000, description="[-] columns in the periodic row")

    @model_validator(mode="after")
    def _columns_stand(self) -> Columns:
        if self.sunk > MOST_SUNK:
            least = self.stiffness * self.sunk / MOST_SUNK
            raise ValueError(
                f"stiffness = {self.stiffness:g} N/m is too soft for columns of n = {self.n}: "
                f"under their own weight they would sink by {self.sunk:.3g} diameters; must be at "
                f"least {least:.4g} N/m ({MOST_SUNK:g} diameters)"
            )
        return self

    @property
    def deformable(self) -> bool:
        """Return whether the source's law couples the contacts of a particle."""
        return self.law == "deformable" and self.n > 1

    @property
    def sunk(self) -> float:
        """Return by how much columns sink under their own weight [d], upright."""
        pairs = 0.5 * self.n * (self.n - 1) * (2.0 if self.deformable else 1.0)
        return pairs * self.static_overlap

    @property
    def fewest_steps_per_contact(self) -> float:
        """Return the bound below which velocity Verlet is unstable.

        As for the incline, where the spring of the fastest motion is ``lambda`` contacts' and its
        dashpot ``mu`` contacts': Jury's criterion asks for lambda a^2 + 4 zeta mu a < 4 with
        a = omega dt = pi / steps per contact. One sphere: 3/2 both. Columns: 4 both, the largest
        sum of a row of D M^-1 D^T (contacts of a grain in a well: 2 + 1/2 + 1). The deformable law
        divides the spring by the lowest eigenvalue of T, tau = 2 sin^2(pi / (2 (n + 1))):
        D M^-1 D^T <= 4 - 2 T + 1/2, hence lambda = 4.5 / tau - 2.
        """
        zeta = self.contact.zeta_against_full_mass
        if self.n == 1:
            return super().fewest_steps_per_contact
        spring = 4.0
        if self.deformable:
            spring = 4.5 / (2.0 * math.sin(math.pi / (2.0 * (self.n + 1))) ** 2) - 2.0
        dashpot = 2.0 * zeta * 4.0 / spring
        return math.pi / (math.sqrt(dashpot**2 + 4.0 / spring) - dashpot)
