"""Parameters that bulk cases share: grains, materials, steps; and the published beds.

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

The published beds in this folder are those of MercuryDPM's drivers ``Drivers/Papers/OSBenchmark``,
that of the penetration without its last line, the steel sphere (BSD-3-Clause, MercuryDPM developers
team): a row radius, x, y, z [m] for each grain, below a line of names.
"""  # noqa: E501 - a table

from __future__ import annotations

import hashlib
import lzma
import math
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, ClassVar, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from harness.engines.base import Value
from harness.files import cache_place, make_private, text_writer, write_files
from harness.model.base import Parameters
from harness.theory import contact

Floats = NDArray[np.float64]
PUBLISHED = "published"  # preset and places of the published systems
RAYLEIGH_SHARE = 0.2  # longest step over the time of a Rayleigh wave around half a sphere
STEPS_IN_IMPACT = 20.0  # fewest steps of a Hertz impact
SMALLEST, LARGEST = 1e-30, 1e30  # values in SI units: volumes and steps stay finite
MOST_SITES = 3000  # of a lattice between two walls, in a row: all sites of a layer are in memory
NO_VALUES = frozenset({"settle_time", "duration", "turn", "cell"})  # parameters, not of scripts
LATTICE: Mapping[str, Value] = {"bed": "lattice", "places": "none"}  # values of no published bed


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

        Their time is pi r sqrt(rho/G)/(0.1631 nu + 0.8766); the fit of the speed is right to 0.4 %.
        """
        nu = self.poisson_ratio
        wave = math.pi * self.radius * math.sqrt(2.0 * self.density * (1.0 + nu))
        return RAYLEIGH_SHARE * wave / math.sqrt(self.youngs_modulus) / (0.1631 * nu + 0.8766)

    def impact_step(self, wall_modulus: float, speed: float) -> float:
        """Return the longest step [s] by Hertz's impact on a wall of the same Poisson's ratio."""
        softness = 1.0 / self.youngs_modulus + 1.0 / wall_modulus
        modulus = 1.0 / softness / (1.0 - self.poisson_ratio**2)
        spring = contact.stiffness(modulus, self.radius)
        return contact.contact_time(self.mass, spring, speed) / STEPS_IN_IMPACT


# fields that several systems have, with defaults of their own
# fmt: off
Places = Annotated[
    str, Field(description="[-] published: those of the grains of Dosta and others; empty: a "
               "lattice that settles")]
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
# fmt: on


class Bed(Parameters):
    """Grains on a lattice that settle between walls of steel, and are then disturbed.

    A system gives its grains, their kinds (of sizes that vary the smallest), the height through
    which one can fall [m], and the time for which the bed is disturbed [s].
    """

    ROWS: ClassVar[int]  # of the series, about
    FRICTIONS: ClassVar[tuple[str, ...]] = ("friction", "steel_friction")  # of all pairs
    LEAVING: ClassVar[bool] = False  # grains leave the disturbed bed
    grains: ClassVar[property]
    kinds: ClassVar[property]
    fall: ClassVar[property]
    time: ClassVar[property]

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
        for name, value in self:
            if isinstance(value, float) and value and not SMALLEST <= abs(value) <= LARGEST:
                raise ValueError(f"{name} = {value!r}: must be {SMALLEST:g} to {LARGEST:g} in size")
        if flaw := next(self._flaws(), None):
            raise ValueError(flaw)
        if self.step_size > self.longest_step:
            raise ValueError(
                f"step_size = {self.step_size:g} s: must be at most {self.longest_step:.4g}, "
                f"{RAYLEIGH_SHARE:g} of the Rayleigh time and 1/{STEPS_IN_IMPACT:g} of an impact"
            )
        return self

    def _flaws(self) -> Iterator[str]:
        """Yield the reasons why values do not go together."""
        if self.scatter > self._room:
            yield (
                f"scatter = {self.scatter:g}: grains overlap at the start; must be at most "
                f"{self._room:.4g}"
            )

    @property
    def _room(self) -> float:
        """Return the room between grains of the first lattice [diameters]."""
        return self.spacing - 1.0

    @property
    def impact_speed(self) -> float:
        """Return the largest speed of a grain at a wall [m/s]."""
        return math.sqrt(2.0 * self.gravity * float(self.fall))

    @property
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves and by the shortest impact."""
        steel, speed = self.steel_youngs_modulus, self.impact_speed
        return float(min(min(k.rayleigh_step, k.impact_step(steel, speed)) for k in self.kinds))

    @property
    def tangential_share(self) -> float:
        """Return the largest energy of a tangential spring over that of its normal one.

        Hertz: F = 2/3 k_n overlap stores 3/5 F^2/k_n, k_n = 2 E* a. Mindlin: at most
        (mu F)^2/(2 k_t), k_t = 8 G* a (Johnson, Contact Mechanics, 7.2).
        """
        friction = max(getattr(self, name) for name in self.FRICTIONS)
        return float(5.0 / 6.0 * friction**2 / contact.stiffness_ratio(self.poisson_ratio))

    @property
    def every(self) -> int:
        """Return the steps between two rows of the series."""
        return max(1, math.ceil(float(self.time) / self.step_size / self.ROWS))

    @property
    def settle_steps(self) -> int:
        """Return the steps before the bed is disturbed, a multiple of :attr:`every`."""
        return self._multiple(self.settle_time)

    @property
    def steps(self) -> int:
        """Return the steps after that, a multiple of :attr:`every`."""
        return self._multiple(self.time)

    def _multiple(self, time: float) -> int:
        return int(self.every * math.ceil(time / self.step_size / self.every - 1e-9))

    @property
    def values(self) -> dict[str, Value]:
        """Return the values of a script."""
        values: dict[str, Value] = {name: v for name, v in self if name not in NO_VALUES}
        more = {"settle_steps": self.settle_steps, "steps": self.steps, "series_every": self.every}
        return {**values, **more, "damping": "coeff_restitution"}


class BedOfOneKind(Bed):
    """Grains of one kind, on a floor of an area [m2]."""

    floor_area: ClassVar[property]

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
    def kinds(self) -> Sequence[Sphere]:
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
    def weight(self) -> float:
        """Return the weight of all grains [N]."""
        return float(self.grains * self.grain.mass * self.gravity)

    @property
    def largest_elastic_energy(self) -> float:
        """Return a bound of the elastic energy of the bed at rest [J].

        Each of six contacts of a grain, counted half, bears the weight F of a whole column of
        grains, as only the lowest do: 2/5 F overlap, by Hertz with E* = E/(2 (1 - nu^2)), R* = r/2.
        """
        column = self.grains * (2.0 * self.radius) ** 2 / self.floor_area
        load = column * self.grain.mass * self.gravity
        modulus = self.youngs_modulus / (2.0 * (1.0 - self.poisson_ratio**2))
        overlap = (load / contact.stiffness(modulus, self.radius / 2.0)) ** (2.0 / 3.0)
        return float(3.0 * self.grains * 0.4 * load * overlap)


# ---- grains between walls


def lattice_sites(pitch: float, low: float, high: float) -> Floats:
    """Return the sites (i + 1/2) pitches of a lattice between two places, (sites,).

    Raise ValueError for more than :data:`MOST_SITES`.
    """
    if (high - low) / pitch > MOST_SITES:
        raise ValueError(
            f"{(high - low) / pitch:.3g} grains find room in a row between walls: at most "
            f"{MOST_SITES} are allowed; must have a larger radius, or spacing"
        )
    first, last = (math.floor(end / pitch) for end in (low, high))
    site = pitch * (np.arange(first - 1, last + 2) + 0.5)
    return np.asarray(site[(site >= low) & (site <= high)])


def level_bed(
    section: Callable[[float], float], lowest: float, highest: float, mean_height: float
) -> tuple[float, float]:
    """Return height [m] and volume [m3] of a level bed whose volume has a mean height [m].

    ``section`` is the area [m2] between the walls by height, from the ``lowest`` one on; the bed is
    below the ``highest`` one.
    """
    from scipy.integrate import quad
    from scipy.optimize import brentq

    size = section(mean_height) * (mean_height - lowest) ** 2

    def moment(height: float) -> float:
        """Return the moment [m4] about the mean height: zero at the height of the bed."""
        weighted = lambda z: section(z) * (z - mean_height)  # noqa: E731
        return float(quad(weighted, lowest, height, epsabs=1e-12 * size, epsrel=1e-12)[0])

    start = lowest + 1e-3 * (mean_height - lowest)
    height = float(brentq(moment, start, highest, xtol=1e-15))
    return height, float(quad(section, lowest, height, epsabs=0.0, epsrel=1e-12)[0])


# ---- published beds


@dataclass(frozen=True, eq=False)
class PublishedBed:
    """A published bed: a file in this folder, and the parameters of which it is the bed.

    ``sizes`` [m] are by the names of parameters, ``counts`` the numbers of each kind of grains;
    ``origin`` (x, y, z) [m] is the place of the case's origin in the file.
    """

    file: str
    sizes: Mapping[str, float]
    counts: tuple[int, ...]
    origin: tuple[float, float, float]

    def flaws(self, p: Bed, places: str) -> Iterator[str]:
        """Yield why ``places`` name another bed, or parameters do not fit this one."""
        if places not in ("", PUBLISHED):
            yield f"places = {places!r}: must be {PUBLISHED!r} or empty"
        for name, size in self.sizes.items() if places else ():
            if (value := getattr(p, name)) != size:
                yield f"{name} = {value:g} m: must be {size:g} with places = {PUBLISHED!r}"

    def rows(self) -> Floats:
        """Return radius and place of each grain from the case's origin [m], (N, 4)."""
        with lzma.open(Path(__file__).with_name(self.file), "rt", encoding="utf-8") as lines:
            rows: Floats = np.loadtxt(lines, skiprows=1) - np.array([0.0, *self.origin])
        return rows

    def values(self, kinds: Sequence[Sphere], *ends: tuple[float, float]) -> dict[str, Value]:
        """Return the values of a script: the path of a data file of ``atom_style sphere``.

        Grains of the first kind are type 1, there are three types; ``ends`` of the box along x, y,
        z [m]. It lies in the cache, named after its content, which a job has by its name.
        """
        text = _data_text(self, tuple(kinds), ends)
        folder = cache_place().path / "beds"
        if len(str(folder).split()) > 1:  # a script's words end at spaces
            folder = Path(tempfile.gettempdir())
        path = (folder / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.data").absolute()
        if not path.exists():
            make_private(folder)
            write_files({("places", path): text_writer(text)})
        return {"bed": "file", "places": str(path)}


@lru_cache(maxsize=4)  # a setup needs it for each run
def _data_text(
    bed: PublishedBed, kinds: Sequence[Sphere], ends: Sequence[tuple[float, float]]
) -> str:
    rows = bed.rows()
    grains = [
        f"{number} {2.0 * kind.radius:.17g} {kind.density:.17g} {x:.17g} {y:.17g} {z:.17g}"
        for number, kind in enumerate(kinds, 1)
        for _, x, y, z in rows[rows[:, 0] == kind.radius].tolist()
    ]
    head = [f"{len(grains)} grains", "", f"{len(grains)} atoms", "3 atom types", ""]
    head += [f"{a:.17g} {b:.17g} {n}lo {n}hi" for n, (a, b) in zip("xyz", ends, strict=True)]
    lines = [f"{number} {grain}" for number, grain in enumerate(grains, 1)]
    # without the comment "# sphere": LIGGGHTS takes it for a part of the section's name
    return "\n".join([*head, "", "Atoms", "", *lines, ""])
