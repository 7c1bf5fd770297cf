"""Parameters that bulk cases share: grains, materials, steps, and how long a step may be.

The materials are those of Dosta and others, Comput. Phys. Commun. 296, 109066 (2024); presets soften
them. Each pair is stated, as LAMMPS mixes the tangential stiffness wrongly: for one Poisson's ratio
E12 = 2 E1 E2/(E1 + E2) gives E* and G* of the pair, as 1/E* = (1 - nu^2)(1/E1 + 1/E2).

======================  =====  =====  ======    ============  =====  =====  =====  ========  ========
of one                  M1     M2     steel     of a pair     M1-M1  M1-M2  M2-M2  M1-steel  M2-steel
======================  =====  =====  ======    ============  =====  =====  =====  ========  ========
Young's modulus (GPa)   1      0.5    210       restitution   0.5    0.45   0.4    0.4       0.4
Poisson's ratio         0.2    0.2    0.2       friction      0.3    0.2    0.4    0.2       0.2
density (kg/m3)         2500   2000   7200
======================  =====  =====  ======    ============  =====  =====  =====  ========  ========
"""  # noqa: E501 - a table

from __future__ import annotations

import math
import os
from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated, ClassVar, Self

from pydantic import Field, model_validator

from harness.engines.base import Value
from harness.errors import RequestError
from harness.model.base import Parameters

PUBLISHED = "published"  # preset and file of places of the published systems
RAYLEIGH_SHARE = 0.2  # longest step over the time of a Rayleigh wave around half a sphere
STEPS_IN_IMPACT = 20.0  # fewest steps of a Hertz impact
GRAIN_BYTES = 2000  # least memory of a grain with its contacts, as LAMMPS takes it


@dataclass(frozen=True)
class Sphere:
    """Spheres of one kind; ``radius`` [m], ``density`` [kg/m3], ``youngs_modulus`` [Pa]."""

    radius: float
    density: float
    youngs_modulus: float
    poisson_ratio: float

    @property
    def volume(self) -> float:
        """Return the volume [m3]."""
        return 4.0 / 3.0 * math.pi * self.radius**3

    @property
    def mass(self) -> float:
        """Return the mass [kg]."""
        return self.density * self.volume

    @property
    def rayleigh_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves.

        Their time is pi r sqrt(rho/G)/(0.1631 nu + 0.8766); the fit of the speed holds to 0.4 %.
        """
        nu = self.poisson_ratio
        wave = math.pi * self.radius * math.sqrt(2.0 * self.density * (1.0 + nu))
        return RAYLEIGH_SHARE * wave / math.sqrt(self.youngs_modulus) / (0.1631 * nu + 0.8766)

    def impact_step(self, wall_modulus: float, speed: float) -> float:
        """Return the longest step [s] by an impact on a wall of the same Poisson's ratio.

        An impact takes 2.8683 (m^2/(R E*^2 v))^(1/5) (Hertz; Johnson, Contact Mechanics, 11.24).
        """
        both = self.youngs_modulus + wall_modulus
        modulus = self.youngs_modulus * wall_modulus / both / (1.0 - self.poisson_ratio**2)
        impact = (self.mass**2 / (self.radius * modulus**2 * speed)) ** 0.2
        return float(2.8683 * impact / STEPS_IN_IMPACT)

    def elastic_energy(self, load: float) -> float:
        """Return the elastic energy [J] of the contact of two such spheres under a load [N].

        F = 4/3 E* sqrt(R*) overlap^(3/2), E* = E/(2 (1 - nu^2)), R* = r/2; the energy is
        2/5 F overlap.
        """
        stiffness = 2.0 / 3.0 * self.youngs_modulus / (1.0 - self.poisson_ratio**2)
        overlap = (load / (stiffness * math.sqrt(self.radius / 2.0))) ** (2.0 / 3.0)
        return float(0.4 * load * overlap)


# fmt: off
Layers = Annotated[
    int, Field(ge=1, le=10000, description="[-] grains of the first lattice along z")]
Spacing = Annotated[float, Field(gt=1.0, le=3.0, description="[-] of a lattice, in diameters")]
Scatter = Annotated[
    float, Field(ge=0.0, le=1.0, description="[-] range of the first places, in diameters")]
Friction = Annotated[float, Field(ge=0.0, le=2.0, description="[-] between grains")]
RollingFriction = Annotated[
    float, Field(ge=0.0, le=2.0,
                 description="[-] between grains: the torque is at most mu_r F_n R*")]
SteelFriction = Annotated[float, Field(ge=0.0, le=2.0, description="[-] on steel")]
Radius = Annotated[float, Field(gt=0.0, description="[m] of a grain")]
YoungsModulus = Annotated[float, Field(gt=0.0, description="[Pa] of the grains")]
SteelModulus = Annotated[float, Field(gt=0.0, description="[Pa] of all that is of steel")]
SettleTime = Annotated[float, Field(ge=0.0, description="[s] before the bed is disturbed")]
Duration = Annotated[float, Field(gt=0.0, description="[s] after that")]
StepSize = Annotated[float, Field(gt=0.0, description="[s] time step")]
Restitution = Annotated[float, Field(gt=0.05, le=1.0, description="[-] between grains")]
# fmt: on


class Bed(Parameters):
    """Grains on a lattice that settle between walls of steel, and are then disturbed."""

    ROWS: ClassVar[int]  # of the series, about
    DERIVED: ClassVar[frozenset[str]]  # parameters that are no value of the scripts
    FRICTIONS: ClassVar[tuple[str, ...]] = ("friction", "steel_friction")  # of all pairs
    LEAVING: ClassVar[bool] = False  # grains leave the disturbed bed

    spacing: Spacing = 1.2
    scatter: Scatter = 0.19
    seed: int = Field(1, ge=1, le=10000, description="[-] of the first places")
    poisson_ratio: float = Field(0.2, ge=0.0, lt=0.5, description="[-] of all")
    steel_youngs_modulus: SteelModulus = 2.1e11
    steel_restitution: float = Field(0.4, gt=0.05, le=1.0, description="[-] on steel")
    steel_friction: SteelFriction = 0.2
    gravity: float = Field(9.81, gt=0.0, description="[m/s2] downward")
    settle_time: SettleTime = 0.2
    step_size: StepSize = 1e-6

    @model_validator(mode="after")
    def _check(self) -> Self:
        words, most = self._room()
        if self.scatter > most:
            raise ValueError(
                f"scatter = {self.scatter:g}: grains overlap at the start; must be at most "
                f"{words} = {most:.4g}"
            )
        self._check_system()
        if self.step_size > self.longest_step:
            raise ValueError(
                f"step_size = {self.step_size:g} s: must be at most {self.longest_step:.4g}, "
                f"{RAYLEIGH_SHARE:g} of the Rayleigh time and 1/{STEPS_IN_IMPACT:g} of an impact"
            )
        return self

    def _check_system(self) -> None:
        """Raise ValueError for walls and grains that do not go together."""

    def _room(self) -> tuple[str, float]:
        """Return the room between grains of the first lattice, in words and in diameters."""
        return "spacing - 1", self.spacing - 1.0

    @property
    @abstractmethod
    def grains(self) -> int:
        """Return the number of grains."""

    @property
    @abstractmethod
    def kinds(self) -> tuple[Sphere, ...]:
        """Return the kinds of grains; of sizes that vary, the smallest."""

    @property
    @abstractmethod
    def impact_speed(self) -> float:
        """Return the largest speed of a grain at a wall [m/s]."""

    @property
    @abstractmethod
    def time(self) -> float:
        """Return the time for which the bed is disturbed [s]."""

    @property
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves and by the shortest impact."""
        steel, speed = self.steel_youngs_modulus, self.impact_speed
        return min(min(k.rayleigh_step, k.impact_step(steel, speed)) for k in self.kinds)

    @property
    def tangential_share(self) -> float:
        """Return the largest energy of a tangential spring over that of its normal one.

        Hertz: F = 2/3 k_n overlap holds 3/5 F^2/k_n, k_n = 2 E* a. Mindlin: at most
        (mu F)^2/(2 k_t), k_t = 8 G* a, and k_n/k_t = (2 - nu)/(2 (1 - nu)) (Johnson, Contact
        Mechanics, 7.2).
        """
        friction = max(getattr(self, name) for name in self.FRICTIONS)
        stiffness_ratio = (2.0 - self.poisson_ratio) / (2.0 * (1.0 - self.poisson_ratio))
        return float(5.0 / 6.0 * friction**2 * stiffness_ratio)

    @property
    def every(self) -> int:
        """Return the steps between two rows of the series."""
        return max(1, math.ceil(self.time / self.step_size / self.ROWS))

    @property
    def settle_steps(self) -> int:
        """Return the steps before the bed is disturbed, a multiple of :attr:`every`."""
        return self._whole(self.settle_time)

    @property
    def steps(self) -> int:
        """Return the steps after that, a multiple of :attr:`every`."""
        return self._whole(self.time)

    def _whole(self, time: float) -> int:
        return self.every * math.ceil(time / self.step_size / self.every - 1e-9)

    @property
    def particle_steps(self) -> float:
        """Return the expected steps times grains; half of those that leave are gone on average."""
        return self.grains * (self.settle_steps + self.steps * (0.5 if self.LEAVING else 1.0))

    @property
    def values(self) -> dict[str, Value]:
        """Return the values of a script; raise RequestError for more grains than memory holds."""
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
        if self.grains * GRAIN_BYTES > memory:
            raise RequestError(
                f"{self.grains} grains: would take {self.grains * GRAIN_BYTES / 1e9:.3g} GB of "
                f"memory; must be at most {memory // GRAIN_BYTES} on this machine"
            )
        values: dict[str, Value] = {name: v for name, v in self if name not in self.DERIVED}
        more = {"settle_steps": self.settle_steps, "steps": self.steps, "series_every": self.every}
        return {**values, **more, "damping": "coeff_restitution"}


class BedOfOneKind(Bed):
    """Grains of one kind."""

    DERIVED = frozenset({"settle_time", "duration"})

    layers: Layers = 20
    radius: Radius = 1e-3
    density: float = Field(2500.0, gt=0.0, description="[kg/m3] of the grains")
    youngs_modulus: YoungsModulus = 1e9
    restitution: Restitution = 0.5
    friction: Friction = 0.3
    duration: Duration = 1.0

    @property
    def grain(self) -> Sphere:
        """Return a grain."""
        return Sphere(self.radius, self.density, self.youngs_modulus, self.poisson_ratio)

    @property
    def kinds(self) -> tuple[Sphere, ...]:
        """Return the kinds of grains."""
        return (self.grain,)

    @property
    def pitch(self) -> float:
        """Return the distance of the lattice's sites [m]."""
        return 2.0 * self.radius * self.spacing

    @property
    def time(self) -> float:
        """Return the time for which the bed is disturbed [s]."""
        return self.duration

    @property
    @abstractmethod
    def column(self) -> float:
        """Return the largest number of grains above one another."""

    @property
    def largest_elastic_energy(self) -> float:
        """Return a bound of the elastic energy of the bed at rest [J].

        Each of six contacts of a grain, counted half, bears the weight of a whole column of grains,
        as only the lowest do.
        """
        load = self.column * self.grain.mass * self.gravity
        return 3.0 * self.grains * self.grain.elastic_energy(load)
