"""Parameters that bulk cases share: grains, materials, pairs, steps, and how long a step may be.

The materials are those of Dosta and others (2024).

Each pair is stated, as LAMMPS mixes the tangential stiffness wrongly: for one Poisson's ratio
E12 = 2 E1 E2/(E1 + E2) gives E* and G* of the pair, as 1/E* = (1 - nu^2)(1/E1 + 1/E2).

======================  =====  =====  ======
of one                  M1     M2     steel
======================  =====  =====  ======
Young's modulus (GPa)   1      0.5    210
Poisson's ratio         0.2    0.2    0.2
density (kg/m3)         2500   2000   7200
======================  =====  =====  ======

============  =====  =====  =====  ========  ========
of a pair     M1-M1  M1-M2  M2-M2  M1-steel  M2-steel
============  =====  =====  =====  ========  ========
restitution   0.5    0.45   0.4    0.4       0.4
friction      0.3    0.2    0.4    0.2       0.2
============  =====  =====  =====  ========  ========
"""

from __future__ import annotations

import math
import os
from abc import abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field, model_validator

from harness.errors import RequestError
from harness.parameters.base import Parameters

if TYPE_CHECKING:
    from harness.engines.contract import Value

RAYLEIGH = 0.2
"""Of the time in which a Rayleigh wave goes round half a sphere, the longest step."""

STEPS_IN_IMPACT = 20.0
"""Fewest steps of a Hertz impact."""

PACKED = 4.0
"""Cost of a particle and step in a bed with friction, by that of a grain on a row: LAMMPS took
0.4 us."""


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
        """Return :data:`RAYLEIGH` of the time of a Rayleigh wave [s].

        pi r sqrt(rho/G)/(0.1631 nu + 0.8766) is that time; the fit is Rayleigh's speed to 0.4 %.
        """
        nu = self.poisson_ratio
        wave = math.pi * self.radius * math.sqrt(2.0 * self.density * (1.0 + nu))
        return RAYLEIGH * wave / math.sqrt(self.youngs_modulus) / (0.1631 * nu + 0.8766)

    def impact_step(self, wall_modulus: float, speed: float) -> float:
        """Return a part of the time of an impact on a wall of the same Poisson's ratio [s].

        2.8683 (m^2/(R E*^2 v))^(1/5) is that time (Hertz; Johnson, Contact Mechanics, 11.24).
        """
        both = self.youngs_modulus + wall_modulus
        modulus = self.youngs_modulus * wall_modulus / both / (1.0 - self.poisson_ratio**2)
        impact = (self.mass**2 / (self.radius * modulus**2 * speed)) ** 0.2
        return float(2.8683 * impact / STEPS_IN_IMPACT)

    def elastic_energy(self, load: float) -> float:
        """Return what the contact of two such spheres holds under a load [N], in J.

        F = 4/3 E* sqrt(R*) overlap^(3/2), E* = E/(2 (1 - nu^2)), R* = r/2; it holds 2/5 F overlap.
        """
        stiffness = 2.0 / 3.0 * self.youngs_modulus / (1.0 - self.poisson_ratio**2)
        overlap = (load / (stiffness * math.sqrt(self.radius / 2.0))) ** (2.0 / 3.0)
        return float(0.4 * load * overlap)


def check_step(step_size: float, longest: float) -> None:
    """Raise ValueError for a step [s] that is longer than the longest."""
    if step_size > longest:
        raise ValueError(
            f"step_size = {step_size:g} s: must be at most {longest:.4g}, "
            f"{RAYLEIGH:g} of the Rayleigh time and 1/{STEPS_IN_IMPACT:g} of an impact"
        )


Layers = Annotated[
    int, Field(ge=1, le=10000, description="[-] grains of the first lattice along z")
]
Spacing = Annotated[float, Field(gt=1.0, le=3.0, description="[-] of a lattice, in diameters")]
Scatter = Annotated[
    float, Field(ge=0.0, le=1.0, description="[-] range of the first places, in diameters")
]
Friction = Annotated[float, Field(ge=0.0, le=2.0, description="[-] between grains")]
RollingFriction = Annotated[
    float,
    Field(ge=0.0, le=2.0, description="[-] between grains: the torque is at most mu_r F_n R*"),
]
SteelFriction = Annotated[float, Field(ge=0.0, le=2.0, description="[-] on steel")]
Radius = Annotated[float, Field(gt=0.0, description="[m] of a grain")]
YoungsModulus = Annotated[float, Field(gt=0.0, description="[Pa] of the grains")]
SteelModulus = Annotated[float, Field(gt=0.0, description="[Pa] of all that is of steel")]
SettleTime = Annotated[float, Field(ge=0.0, description="[s] before the bed is disturbed")]
Duration = Annotated[float, Field(gt=0.0, description="[s] after that")]
StepSize = Annotated[float, Field(gt=0.0, description="[s] time step")]


class Bed(Parameters):
    """Grains on a lattice that settle between walls of steel, and are then disturbed."""

    ROWS: ClassVar[int]
    """Of the series, about."""
    DERIVED: ClassVar[frozenset[str]]
    """Parameters that scripts are not told."""

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
    def _can_begin(self) -> Bed:
        words, most = self._room()
        if self.scatter > most:
            raise ValueError(
                f"scatter = {self.scatter:g}: grains overlap at the start; must be at most "
                f"{words} = {most:.4g}"
            )
        self._check_system()
        check_step(self.step_size, self.longest_step)
        return self

    def _check_system(self) -> None:
        """Raise ValueError for what the grains are within and does not go together."""

    def _room(self) -> tuple[str, float]:
        """Return the room between grains of the first lattice, in words and in diameters."""
        return "spacing - 1", self.spacing - 1.0

    @property
    @abstractmethod
    def grains(self) -> int:
        """Return how many grains there are."""

    @property
    @abstractmethod
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves and by the shortest impact."""

    @property
    @abstractmethod
    def time(self) -> float:
        """Return how long the bed is disturbed [s]."""

    @property
    def every(self) -> int:
        """Return the steps between two rows of the series."""
        return max(1, math.ceil(self.time / self.step_size / self.ROWS))

    @property
    def settle_steps(self) -> int:
        """Return the steps before the bed is disturbed, a multiple of :attr:`every`."""
        return self.every * math.ceil(self.settle_time / self.step_size / self.every - 1e-9)

    @property
    def steps(self) -> int:
        """Return the steps after that, a multiple of :attr:`every`."""
        return self.every * math.ceil(self.time / self.step_size / self.every - 1e-9)


def values_of(p: Bed) -> dict[str, Value]:
    """Return the values of a script; raise RequestError for more grains than memory holds."""
    check_memory(p.grains)
    values: dict[str, Value] = {n: v for n, v in dict(p).items() if n not in p.DERIVED}
    more = {"settle_steps": p.settle_steps, "steps": p.steps, "series_every": p.every}
    return {**values, **more, "damping": "coeff_restitution"}


class BedOfOneKind(Bed):
    """Grains of one kind."""

    DERIVED = frozenset({"settle_time", "duration"})

    layers: Layers = 20
    radius: Radius = 1e-3
    density: float = Field(2500.0, gt=0.0, description="[kg/m3] of the grains")
    youngs_modulus: YoungsModulus = 1e9
    restitution: float = Field(0.5, gt=0.05, le=1.0, description="[-] between grains")
    friction: Friction = 0.3
    duration: Duration = 1.0

    @property
    def grain(self) -> Sphere:
        """Return a grain."""
        return Sphere(self.radius, self.density, self.youngs_modulus, self.poisson_ratio)

    @property
    def pitch(self) -> float:
        """Return the distance of the lattice's sites [m]."""
        return 2.0 * self.radius * self.spacing

    @property
    def time(self) -> float:
        """Return how long the bed is disturbed [s]."""
        return self.duration

    def elastic_bound(self, column: float) -> float:
        """Return a bound of the elastic energy of the bed at rest [J].

        Each of six contacts of a grain, counted half, bears the weight [N] of a whole column of
        grains, as only the lowest do.
        """
        return 3.0 * self.grains * self.grain.elastic_energy(column)


GRAIN_BYTES = 2000
"""Memory of a grain with its contacts, at least: LAMMPS took as much."""


def check_memory(grains: int) -> None:
    """Raise RequestError for more grains than the memory of this machine holds."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if grains * GRAIN_BYTES > memory:
        raise RequestError(
            f"{grains} grains: would take {grains * GRAIN_BYTES / 1e9:.3g} GB of memory; must be "
            f"at most {memory // GRAIN_BYTES} on this machine"
        )
