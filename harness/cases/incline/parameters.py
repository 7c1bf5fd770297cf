"""The frictionless incline: one grain on a row of fixed, touching spheres."""

from __future__ import annotations

import math

from pydantic import Field, model_validator

from harness.cases.grain import Grain


class Incline(Grain):
    """One run of a grain over the row, in SI units.

    The row is periodic; the grain is a sphere as large as the fixed ones.
    """

    angle: float = Field(10.2, ge=0.0, le=30.0, description="[deg] tilt of the row")
    spheres: int = Field(9, ge=4, le=100_000, description="[-] fixed spheres in the periodic row")
    wells: int = Field(10, ge=1, le=10_000, description="[-] wells to pass in the steady route")
    phase: float = Field(
        0.0, ge=0.0, le=1.0, description="[-] fraction of a step by which the start is shifted"
    )
    time_limit: float = Field(
        400.0, gt=0.0, description="[-] longest motion, in units of sqrt(diameter / gravity)"
    )

    @model_validator(mode="after")
    def _is_sound(self) -> Incline:
        if not 1e-99 < self.diameter * self.density ** (1 / 3) < 1e99:
            raise ValueError(
                f"diameter = {self.diameter:g} m with density = {self.density:g} kg/m3 gives a "
                "mass that is beyond floating point: must be from about 1e-297 to 1e297 kg"
            )
        if self.static_overlap > 0.01:
            raise ValueError(
                f"stiffness = {self.stiffness:g} N/m is too soft: the grain's weight would press "
                f"it {100 * self.static_overlap:.3g} % of a diameter into the row; must be at "
                f"least {100 * self.mass * self.gravity / self.diameter:.4g} N/m (1 %)"
            )
        if self.steps_per_contact <= self.fewest_steps_per_contact:
            raise ValueError(
                f"steps_per_contact = {self.steps_per_contact:g} is unstable at damping ratio "
                f"{self.contact.zeta:.4g}: must be greater than {self.fewest_steps_per_contact:.3f}"
            )
        return self

    @property
    def weight_energy(self) -> float:
        """Return m g d [J], the unit of energy of this system."""
        return self.mass * self.gravity * self.diameter

    @property
    def static_overlap(self) -> float:
        """Return m g / (k d) [-], the relative overlap under the grain's weight."""
        return self.mass * self.gravity / (self.stiffness * self.diameter)

    @property
    def fewest_steps_per_contact(self) -> float:
        """Return the bound below which velocity Verlet is unstable in the well.

        In the well the two contacts stand 60 deg apart, so motion normal to the
        row feels 3/2 of one contact's spring and dashpot. LAMMPS damps with the
        half-step velocity: v+ = v (1 - 3 zeta a) - 3/2 a^2 x / dt, x+ = x + dt v+,
        a = omega dt. Jury's criterion on trace and determinant then asks for
        a < 2 (sqrt(zeta^2 + 2/3) - zeta), and a = pi / steps per contact.
        """
        zeta = self.contact.zeta_against_full_mass
        return math.pi / (2.0 * (math.sqrt(zeta * zeta + 2.0 / 3.0) - zeta))
