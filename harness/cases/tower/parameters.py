"""Parameters of the tower: a grain that runs into a row of particles at rest."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from harness.errors import RequestError
from harness.model.base import Parameters
from harness.theory.chain import LAWS as LAWS
from harness.theory.chain import Law as Law

Property = Literal["mass", "stiffness", "diameter"]
PROPERTIES: dict[Property, str] = {"mass": "kg", "stiffness": "N_per_m", "diameter": "m"}
MOST_CONTACTS = 10_000_000  # kernels take some 160 bytes a particle
MOST_COMPRESSION = 0.25  # [diameters] of the lowest contact at rest: two neighbours, twice that
SEARCH = 3.0  # [t0] within which the largest compression is looked for, the source's bound

Positive = Annotated[float, Field(gt=0)]
PerParticle = Positive | tuple[Positive, ...]
Height = Annotated[
    int,
    Field(
        ge=1, le=MOST_CONTACTS, strict=True, description="[contacts] of the tower, particles - 1"
    ),
]


class Tower(Parameters):
    """A grain with a speed and ``height`` particles at rest in its way.

    Particle 1 is the grain; the last one is the base. Mass, stiffness and diameter are one number,
    or one for each of the ``height + 1`` particles, grain first. A stiffness belongs to a particle:
    force over the shortening of its diameter when it is pressed from one side. Two particles alone
    in contact are then springs in series, 2 k1 k2 / (k1 + k2), under either law, which is k for
    equal ones. The defaults are the source's (Harper, Dufek and Breard, methods section).
    """

    height: Height = 1
    stiffness: PerParticle = Field(1e6, description="[N/m] normal stiffness")
    mass: PerParticle = Field(1.0, description="[kg] mass")
    diameter: PerParticle = Field(1.0, description="[m] diameter")
    speed: float = Field(2.0, ge=0, description="[m/s] speed of the grain at the start")
    gravity: float = Field(9.81, ge=0, description="[m/s2] gravity along the motion")
    law: Law = Field("deformable", description="[-] contact law")
    base: Literal["fixed", "free"] = Field(
        "fixed", description="[-] whether the last particle moves"
    )
    start: Literal["touching", "preloaded", "gapped"] = Field(
        "touching",
        description="[-] at rest and just touching, under their own weight, or with gaps",
    )
    gap: float = Field(0.0, ge=0, description="[m] gap at every contact, gapped start")

    @model_validator(mode="after")
    def _check(self) -> Self:
        for name in PROPERTIES:
            values = self.each(name)
            if len(values) != self.particles:
                raise ValueError(
                    f"{name}: {len(values)} values, must be 1 or height + 1 = {self.particles}"
                )
            if not 1e-30 <= min(values) <= max(values) <= 1e30:
                raise ValueError(f"{name} = {getattr(self, name)}: must be from 1e-30 to 1e30")
        for motion, value in (("speed", self.speed), ("gravity", self.gravity)):
            if value > 1e30:  # their squares stay in double precision
                raise ValueError(f"{motion} = {value!r}: must be from 0 to 1e30")
        if self.start == "gapped" and self.gap == 0:
            raise ValueError("gap = 0.0 m: must be greater than 0 for a gapped start")
        if self.start != "gapped" and self.gap > 0:
            raise ValueError(f"gap = {self.gap} m: must be 0 for a {self.start} start")
        if self.start == "preloaded":
            self._check_preload()
        return self

    def _check_preload(self) -> None:
        """Raise ValueError where nothing bears the weight, or it compresses the lowest contact.

        Its partial compression is the weight above over k; the deformable law adds that of the
        contact before.
        """
        if self.base == "free" and self.gravity > 0:
            raise ValueError("start = 'preloaded': needs base = 'fixed' (nothing rests on air)")
        weight = self.gravity * math.fsum(self.each("mass")[:-1])
        compression = weight / min(self.each("stiffness")) / min(self.each("diameter"))
        if compression > MOST_COMPRESSION:
            raise ValueError(
                f"start = 'preloaded': the tower's weight compresses its lowest contact by "
                f"{100 * compression:.3g} % of a diameter: must be at most "
                f"{100 * MOST_COMPRESSION:g} % (stiffer, lighter or lower)"
            )

    @property
    def particles(self) -> int:
        """Return the number of particles, the grain and the base among them."""
        return self.height + 1

    def each(self, name: Property) -> tuple[float, ...]:
        """Return a property of every particle, grain first."""
        value: float | tuple[float, ...] = getattr(self, name)
        return value if isinstance(value, tuple) else (value,) * self.particles

    @property
    def omega(self) -> float:
        """Return sqrt(k/m) of the grain, k that of its contact with the next particle [rad/s]."""
        first, second = self.each("stiffness")[:2]
        return math.sqrt(2 / (1 / first + 1 / second) / self.each("mass")[0])

    @property
    def contact_time(self) -> float:
        """Return t0 [s], the contact of the grain with one fixed particle.

        ``t0 = (2/omega) (pi - atan(v0 omega / g))``, the unit of time of the source's figures.
        Raise RequestError if neither speed nor gravity acts.
        """
        if self.speed == 0 and self.gravity == 0:
            raise RequestError("speed = 0.0 m/s: must be greater than 0 where gravity is 0")
        return 2 / self.omega * (math.pi - math.atan2(self.speed * self.omega, self.gravity))

    @property
    def contact_period(self) -> float:
        """Return pi sqrt(m/k) [s] of the lightest particle at the largest stiffness.

        Steps per contact count in it.
        """
        return math.pi * math.sqrt(min(self.each("mass")) / max(self.each("stiffness")))

    @property
    def gamma(self) -> float:
        """Return Gamma = m g / (v0 sqrt(k m)) [-], the one parameter of equal towers."""
        if self.speed == 0:
            return math.inf if self.gravity else math.nan
        return self.gravity / (self.speed * self.omega)


class TowerParameters(Tower):
    """A tower, how long it runs and with which step.

    The defaults are those of the scripts: three particles under the overlap law, which every code
    has.
    """

    height: Height = 2
    law: Law = Field("overlap", description="[-] contact law")
    duration: float = Field(
        SEARCH,
        ge=SEARCH,
        description="[t0] from the start to the final velocity, in contact times of grain and one "
        "fixed particle",
    )
    steps_per_contact: float | None = Field(
        None,
        gt=0,
        description="[-] steps in pi sqrt(m/k); 1000 in engines and 4000 in RK4 if not given",
    )
