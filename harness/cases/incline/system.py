"""A grain on a tilted row of touching spheres: parameters of a run.

A run takes one of two *routes*:

``passage``  The grain starts 10 deg behind the first crest with the energy of a grain at rest on
             that crest, passes one well, and its energy before the next crest is measured.
``steady``   It starts in a well, fast enough to leave it, and passes many wells (as in the source).

``OverRow`` is what the incline, whose grain may have friction and another size, and the case
``columns``, whose row gives way, have in common.
"""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from harness.cases.base import EqualSpheres
from harness.model.law import CONTACTS, SOURCE, Contact, Law, NamedContact
from harness.theory.incline import INERTIA, Grain, Shape, friction_to_roll, smallest_size_ratio

Floats = NDArray[np.float64]
Route = Literal["passage", "steady"]

START_BEHIND_CREST = 10.0  # [deg] of a passage, which also ends at most as far before one
START_WITH_LITTLE_FRICTION = 1.0  # [deg] likewise: a grain rolls there with mu > 0.005
MOST_UNITS_OF_TIME = 1e30  # [sqrt(d / g)] of a motion: a number of steps is finite
ROLLS_AT_START = 0.1  # friction with which a grain rolls at START_BEHIND_CREST, 0.06 is the least


class OverRow(EqualSpheres):
    """One run of a grain over a periodic row, in SI units.

    Unless a subclass has another, the row is fixed, and the grain has its size and no friction.
    """

    # fmt: off
    angle: float = Field(10.2, ge=0.0, le=30.0, description="[deg] tilt of the row")
    spheres: int = Field(9, ge=4, le=100_000, description="[-] fixed spheres in the periodic row")
    wells: int = Field(10, ge=1, le=10_000, description="[-] wells to pass in the steady route")
    phase: float = Field(
        0.0, ge=0.0, le=1.0, description="[-] fraction of a step by which the start is shifted")
    time_limit: float = Field(
        400.0, gt=0.0, description="[-] longest motion, in units of sqrt(diameter / gravity)")
    # fmt: on

    counts_springs: ClassVar[bool] = True  # in the energy by which a run is judged

    @property
    def tilt(self) -> float:
        """Return the angle [rad]."""
        return math.radians(self.angle)

    @property
    def weight(self) -> float:
        """Return m g [N]."""
        return self.mass * self.gravity

    @property
    def unit_of_time(self) -> float:
        """Return sqrt(d / g) [s]."""
        return math.sqrt(self.diameter / self.gravity)

    @property
    def weight_energy(self) -> float:
        """Return m g d [J], the unit of energy."""
        return self.weight * self.diameter

    @property
    def static_overlap(self) -> float:
        """Return m g / (k d) [-], the overlap under the weight in diameters of the row."""
        return self.weight / (self.stiffness * self.diameter)

    @property
    def grain(self) -> float:
        """Return the diameter of the grain [m]."""
        return self.diameter

    @property
    def mass(self) -> float:
        """Return the grain's mass [kg]."""
        return self.density * math.pi / 6.0 * self.grain**3

    @property
    def arm(self) -> float:
        """Return the distance [m] of the grain's centre from a sphere that it touches."""
        return 0.5 * (self.grain + self.diameter)

    @property
    def half_angle(self) -> float:
        """Return the half angle of a well [rad], 30 deg for a grain of the row's size."""
        return math.asin(0.5 * self.diameter / self.arm)

    @property
    def rolling_inertia(self) -> float:
        """Return beta [-] of a grain that rolls, 0 of one without friction."""
        return 0.0

    @property
    def is_plain(self) -> bool:
        """Return whether the grain is as large as the row's spheres and has no friction."""
        return self.rolling_inertia == 0.0 and self.grain == self.diameter

    @property
    def start_degrees(self) -> float:
        """Return how far behind the crest [deg] a passage starts."""
        return START_BEHIND_CREST

    @property
    def ends_on_crest(self) -> bool:
        """Return whether a passage goes on to the crest, as energy may be lost up to there."""
        return False

    def rest_overlaps(self, force: float, load: float) -> Floats:
        """Return the overlaps [m] at rest of the grain's contact and of those below, (contacts,).

        The grain presses with a ``force`` [N], of which the ``load`` is normal to the row.
        """
        return np.array([force / self.stiffness])

    @property
    def stiffest_motion(self) -> tuple[float, float]:
        """Return spring and dashpot [-] of the fastest motion, over those of one contact.

        In a well they are 2 cos(phi)^2 normal to the row and 2 sin(phi)^2 along it.
        """
        factor = 2.0 * max(math.cos(self.half_angle) ** 2, math.sin(self.half_angle) ** 2)
        return factor, factor

    @property
    def fewest_steps_per_contact(self) -> float:
        """Return the bound below which velocity Verlet is unstable.

        With a spring of lambda contacts and a dashpot of mu, the velocity of the half step is
        v+ = v (1 - 2 mu zeta a) - lambda a^2 x / dt, x+ = x + dt v+, where a = omega dt = pi /
        steps per contact. Jury's criterion is lambda a^2 + 4 mu zeta a < 4.
        """
        spring, dashpot = self.stiffest_motion
        part = 2.0 * dashpot * self.contact.zeta_against_full_mass / spring
        return math.pi / (math.sqrt(part**2 + 4.0 / spring) - part)

    def check_step(self) -> None:
        """Raise ValueError for a step that is unstable."""
        if self.steps_per_contact <= (fewest := self.fewest_steps_per_contact):
            raise ValueError(
                f"steps_per_contact = {self.steps_per_contact:g} is unstable at damping ratio "
                f"{self.contact.zeta:.4g}: must be greater than {fewest:.3f}"
            )


class Incline(OverRow):
    """One run of a grain over the row; it has the row's density, and its size unless given."""

    # fmt: off
    contact: NamedContact = Field(SOURCE, description="[-] dissipation of the contact")
    steps_per_contact: float = Field(
        50.0, gt=0.0, le=1e5, description="[-] steps per contact time pi sqrt(m/k)")
    friction: float = Field(0.0, ge=0.0, le=1e9, description="[-] Coulomb's mu of the contact")
    grain_diameter: float | None = Field(
        None, gt=0.0, description="[m] diameter of the grain, that of the row unless given")
    shape: Shape = Field(
        "sphere", description="[-] sphere or disc: moment of inertia 2/5 or 1/2 m R^2")
    tangential_stiffness: float | None = Field(
        None, gt=0.0, le=10.0, description="[-] over the normal one; 2/7 unless given, disc 1/3")
    tangential_damping: float | None = Field(
        None, ge=0.0, le=10.0, description="[-] over the normal one; 2/7 unless given, disc 1/3")
    # fmt: on

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not 1e-99 < self.diameter * self.density ** (1 / 3) < 1e99:
            raise ValueError(
                f"diameter = {self.diameter:g} m with density = {self.density:g} kg/m3 gives a "
                "mass that is beyond floating point: must be from about 1e-297 to 1e297 kg"
            )
        if self.time_limit > MOST_UNITS_OF_TIME:
            raise ValueError(
                f"time_limit = {self.time_limit:g}: must be at most {MOST_UNITS_OF_TIME:g}"
            )
        self._check_size()
        if self.static_overlap > 0.01:
            raise ValueError(
                f"stiffness = {self.stiffness:g} N/m is too soft: the grain's weight would press "
                f"it {100 * self.static_overlap:.3g} % of a diameter into the row; must be at "
                f"least {100 * self.weight / self.diameter:.4g} N/m (1 %)"
            )
        self.check_step()
        return self

    def _check_size(self) -> None:
        most = self.spheres * self.diameter / 2.0
        if self.grain > most:
            raise ValueError(
                f"grain_diameter = {self.grain:g} m: must be at most {most:g} m, half of a row of "
                f"{self.spheres} spheres"
            )
        if self.grain >= self.diameter:  # the least is below 0.83 of it, and takes long to find
            return
        least = smallest_size_ratio(Grain.of(self.friction, self.shape)) * self.diameter
        if self.grain < least:
            raise ValueError(
                f"grain_diameter = {self.grain:g} m: must be at least {least * (1 + 1e-6):.6g} m "
                f"at friction {self.friction:g}, a smaller grain leaves the row below its critical "
                "angle"
            )

    @property
    def grain(self) -> float:
        """Return the diameter of the grain [m]."""
        return self.diameter if self.grain_diameter is None else self.grain_diameter

    @property
    def inertia(self) -> float:
        """Return beta [-] of the moment of inertia beta m R^2."""
        return INERTIA[self.shape]

    @property
    def rolling_inertia(self) -> float:
        """Return beta [-] of a grain that rolls, 0 of one without friction."""
        return self.inertia if self.friction else 0.0

    @property
    def start_degrees(self) -> float:
        """Return how far behind the crest [deg] a passage starts: with friction it rolls there."""
        little = 0.0 < self.friction < ROLLS_AT_START
        return START_WITH_LITTLE_FRICTION if little else START_BEHIND_CREST

    @property
    def ends_on_crest(self) -> bool:
        """Return whether friction may dissipate energy on an arc, at most at its end."""
        return 0.0 < self.friction < friction_to_roll(self.half_angle + self.tilt, self.inertia)

    @property
    def stiffest_motion(self) -> tuple[float, float]:
        """Return also with friction: 2, times the ratio of tangential and normal rates."""
        if self.friction == 0.0:
            return super().stiffest_motion
        share = self.inertia / (1.0 + self.inertia)
        factor = 2.0 * max(1.0, *(ratio / share for ratio in self.tangential_ratios))
        return factor, factor

    @property
    def tangential_ratios(self) -> tuple[float, float]:
        """Return tangential over normal stiffness and damping, beta / (1 + beta) unless given."""
        share = self.inertia / (1.0 + self.inertia)
        stiffness, damping = self.tangential_stiffness, self.tangential_damping
        return (share if stiffness is None else stiffness, share if damping is None else damping)

    @property
    def law(self) -> Law:
        """Return the law of the contact of grain and row."""
        law = self.contact.law(self.stiffness)
        if self.friction == 0.0:
            return law
        stiffness, damping = self.tangential_ratios
        return law.replace(
            tangential="linear_history",
            tangential_stiffness=stiffness * self.stiffness,
            tangential_damping=damping,
            friction=self.friction,
        )


def changed_contact(
    name: str,
    restitution: float | None = None,
    damping_ratio: float | None = None,
    clip: bool | None = None,
    half_mass: bool = False,
) -> Contact:
    """Return a contact of ``CONTACTS``, ``custom`` if changed; damping takes the place of both."""
    changes: dict[str, Any] = {}
    if restitution is not None or damping_ratio is not None:
        changes |= {"restitution": restitution, "damping_ratio": damping_ratio}
    if clip is not None:
        changes["tail"] = "clipped" if clip else "attractive"
    if half_mass:
        changes["effective_mass"] = "half"
    return CONTACTS[name].replace(**changes, name="custom") if changes else CONTACTS[name]
