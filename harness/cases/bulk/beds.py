"""Parameters that bulk cases share: grains, materials, steps; beds whose places come from a file.

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

A file of places has a row radius, x, y, z [m] for each grain, below a head of words. The published
beds in this folder are those of MercuryDPM's drivers ``Drivers/Papers/OSBenchmark``, that of the
penetration without its last line, the steel sphere (BSD-3-Clause, MercuryDPM developers team).
"""  # noqa: E501 - a table

from __future__ import annotations

import hashlib
import lzma
import math
import re
import tempfile
from abc import abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, ClassVar, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from harness.engines.base import Value
from harness.errors import RequestError
from harness.files import cache_place, make_private
from harness.model.base import Parameters

Floats = NDArray[np.float64]
Ends = tuple[tuple[float, float], ...]
PUBLISHED = "published"  # preset and file of places of the published systems
RAYLEIGH_SHARE = 0.2  # longest step over the time of a Rayleigh wave around half a sphere
STEPS_IN_IMPACT = 20.0  # fewest steps of a Hertz impact
LARGEST_OVERLAP = 0.1  # [radii] of two grains, or of a grain and a wall, at the start
NO_VALUES = frozenset({"settle_time", "duration", "turn", "cell"})  # parameters, not of scripts


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
    """Grains on a lattice that settle between walls of steel, and are then disturbed.

    A system gives its grains, their kinds (of sizes that vary the smallest), the largest speed of
    a grain at a wall [m/s], and the time for which the bed is disturbed [s].
    """

    ROWS: ClassVar[int]  # of the series, about
    FRICTIONS: ClassVar[tuple[str, ...]] = ("friction", "steel_friction")  # of all pairs
    LEAVING: ClassVar[bool] = False  # grains leave the disturbed bed
    grains: ClassVar[property]
    kinds: ClassVar[property]
    impact_speed: ClassVar[property]
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
        for wrong, reason in self._flaws():
            if wrong:
                raise ValueError(reason)
        if self.step_size > self.longest_step:
            raise ValueError(
                f"step_size = {self.step_size:g} s: must be at most {self.longest_step:.4g}, "
                f"{RAYLEIGH_SHARE:g} of the Rayleigh time and 1/{STEPS_IN_IMPACT:g} of an impact"
            )
        return self

    def _flaws(self) -> Iterable[tuple[bool, str]]:
        """Yield whether values do not go together, each with the reason."""
        yield (
            self.scatter > self.room,
            f"scatter = {self.scatter:g}: grains overlap at the start; must be at most "
            f"{self.room:.4g}",
        )

    @property
    def room(self) -> float:
        """Return the room between grains of the first lattice [diameters]."""
        return self.spacing - 1.0

    @property
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves and by the shortest impact."""
        steel, speed = self.steel_youngs_modulus, self.impact_speed
        return float(min(min(k.rayleigh_step, k.impact_step(steel, speed)) for k in self.kinds))

    @property
    def tangential_share(self) -> float:
        """Return the largest energy of a tangential spring over that of its normal one.

        Hertz: F = 2/3 k_n overlap stores 3/5 F^2/k_n, k_n = 2 E* a. Mindlin: at most
        (mu F)^2/(2 k_t), k_t = 8 G* a, and k_n/k_t = (2 - nu)/(2 (1 - nu)) (Johnson, Contact
        Mechanics, 7.2).
        """
        friction = max(getattr(self, name) for name in self.FRICTIONS)
        stiffness_ratio = (2.0 - self.poisson_ratio) / (2.0 * (1.0 - self.poisson_ratio))
        return float(5.0 / 6.0 * friction**2 * stiffness_ratio)

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
    def particle_steps(self) -> float:
        """Return the expected steps times grains; half of those that leave are gone on average."""
        return float(self.grains * (self.settle_steps + self.steps * (0.5 if self.LEAVING else 1)))

    @property
    def values(self) -> dict[str, Value]:
        """Return the values of a script; raise RequestError for a bad file of places."""
        values: dict[str, Value] = {name: v for name, v in self if name not in NO_VALUES}
        more = {"settle_steps": self.settle_steps, "steps": self.steps, "series_every": self.every}
        return {**values, **more, "damping": "coeff_restitution"}


class BedOfOneKind(Bed):
    """Grains of one kind."""

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
    def weight(self) -> float:
        """Return the weight of all grains [N]."""
        return float(self.grains * self.grain.mass * self.gravity)

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
        return float(3.0 * self.grains * self.grain.elastic_energy(load))


# ---- places from a file


class Contacts(NamedTuple):
    """Pairs of grains that touch, by their numbers, and their overlaps [m], (K,) each."""

    i: NDArray[np.int64]
    j: NDArray[np.int64]
    overlap: Floats


def find_contacts(places: Floats, radius: Floats) -> Contacts:
    """Return the pairs that touch, each once, of grains at places (N, 3) with radii (N,) [m]."""
    from scipy.spatial import KDTree  # slow to load

    i, j = KDTree(places).query_pairs(2.0 * radius.max(), output_type="ndarray").T
    overlap = radius[i] + radius[j] - np.linalg.norm(places[i] - places[j], axis=1)
    touch = overlap > 0.0
    return Contacts(i[touch], j[touch], overlap[touch])


class Box(NamedTuple):
    """A floor between four walls: ``length`` along x, ``width`` along y [m].

    ``middle`` (x, y) and ``floor`` z [m] are its place in a file; its corner is the case's origin.
    """

    length: float
    width: float
    middle: tuple[float, float] = (0.0, 0.0)
    floor: float = 0.0

    @property
    def corner(self) -> tuple[float, float, float]:
        """Return the place of the case's origin in a file [m]."""
        return self.middle[0] - self.length / 2, self.middle[1] - self.width / 2, self.floor

    def gap(self, places: Floats) -> Floats:
        """Return the distance of places (N, 3) from the nearest wall [m], (N,)."""
        x, y, z = places.T
        return np.asarray(np.min([x, self.length - x, y, self.width - y, z], axis=0))


class Cylinder(NamedTuple):
    """A drum about the y axis, closed at both ends, its middle the origin of a file [m]."""

    radius: float
    length: float
    corner: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def gap(self, places: Floats) -> Floats:
        """Return the distance of places (N, 3) from the nearest wall [m], (N,)."""
        x, y, z = places.T
        return np.asarray(np.minimum(self.radius - np.hypot(x, z), self.length / 2 - np.abs(y)))


PUBLISHED_BOX = Box(0.098, 0.06, (0.0, 0.0), -0.0902431)  # by the triangles of its walls
FILES = {Box: "penetration-25k.txt.xz", Cylinder: "drum-38k.txt.xz"}


class Places(NamedTuple):
    """A file of places between walls, and the kinds of its grains by the names of their radii."""

    source: str  # path of a text file, perhaps packed as .xz, or "published"
    walls: Box | Cylinder
    kinds: tuple[tuple[str, Sphere], ...]

    def error(self, message: str) -> RequestError:
        """Return an error that names the file."""
        return RequestError(f"places {self.source}: {message}")


@lru_cache(maxsize=4)
def read_places(file: Places) -> tuple[Floats, ...]:
    """Return the places of the grains of each kind (N, 3) [m], from the origin of the case.

    Raise RequestError, naming file and row, for a file that cannot be read, another radius, a
    kind without grains, a grain beyond a wall, and overlaps of more than a tenth of a radius.
    """
    rows = _rows(file)
    allowed = np.array([kind.radius for _, kind in file.kinds])
    same = np.isclose(rows[:, :1], allowed, rtol=1e-9, atol=0.0)
    if len(wrong := np.flatnonzero(~same.any(axis=1))):
        must = " or ".join(f"{name} = {kind.radius:g} m" for name, kind in file.kinds)
        radius = rows[wrong[0], 0]
        raise file.error(f"grain {wrong[0] + 1} has the radius {radius:g} m: must be {must}")
    for (name, kind), is_kind in zip(file.kinds, same.T, strict=True):
        if not is_kind.any():
            raise file.error(f"no grain of {name} = {kind.radius:g} m")
    radii, places = allowed[same.argmax(axis=1)], rows[:, 1:] - np.array(file.walls.corner)
    _check_gaps(file, places, radii)
    _check_overlaps(file, places, radii)
    places.flags.writeable = False
    return tuple(places[is_kind] for is_kind in same.T)


def _rows(file: Places) -> Floats:
    """Return the rows below a head of words and a count, (N, 4)."""
    path = Path(file.source).expanduser()
    if file.source == PUBLISHED:
        path = Path(__file__).with_name(FILES[type(file.walls)])
    try:
        packed = path.read_bytes()
        text = (lzma.decompress(packed) if path.suffix == ".xz" else packed).decode("utf-8")
        lines = text.splitlines()
        while lines and (len(lines[0].split()) < 2 or re.search("[a-df-z]", lines[0].lower())):
            lines = lines[1:]
        rows = np.loadtxt(lines, ndmin=2) if lines else np.zeros((0, 0))
        if rows.shape[1] != 4 or not np.isfinite(rows).all():
            raise ValueError(f"rows of {rows.shape[1]} numbers: must be four finite ones")
    except (OSError, ValueError, lzma.LZMAError) as error:
        raise file.error(f"cannot be read: {error}") from None
    return rows


def _check_gaps(file: Places, places: Floats, radii: Floats) -> None:
    least = (1.0 - LARGEST_OVERLAP) * radii
    beyond = np.flatnonzero(file.walls.gap(places) < least)
    if len(beyond):
        place = ", ".join(f"{x:g}" for x in places[beyond[0]])
        raise file.error(
            f"grain {beyond[0] + 1} at ({place}) m: must be {least[beyond[0]]:g} m from the walls"
        )


def _check_overlaps(file: Places, places: Floats, radii: Floats) -> None:
    i, j, overlap = find_contacts(places, radii)
    excess = overlap - LARGEST_OVERLAP * np.minimum(radii[i], radii[j])
    if excess.max(initial=0.0) > 0.0:
        worst = int(excess.argmax())
        distance = radii[i[worst]] + radii[j[worst]] - overlap[worst]
        raise file.error(
            f"grains {i[worst] + 1} and {j[worst] + 1} are {distance:g} m apart: must be "
            f"{distance + excess[worst]:g} m, an overlap of {LARGEST_OVERLAP:g} radius"
        )


def write_places(file: Places, ends: Ends) -> str:
    """Write the grains of a file as a data file of ``atom_style sphere``; return its path.

    Grains of the first kind are type 1, there are three types; ``ends`` of the box along x, y, z
    [m]. It lies in the cache, named after its content, which a job has by its name.
    """
    text = _data_text(file, ends)
    folder = cache_place().path / "beds"
    if len(str(folder).split()) > 1:  # a script's words end at spaces
        folder = Path(tempfile.gettempdir())
    path = folder / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.data"
    if not path.exists():
        make_private(folder)
        with tempfile.NamedTemporaryFile("w", dir=folder, delete=False, encoding="utf-8") as part:
            part.write(text)
        Path(part.name).replace(path)
    return str(path.absolute())


@lru_cache(maxsize=4)  # a setup needs it for each run
def _data_text(file: Places, ends: Ends) -> str:
    # without the comment "# sphere": LIGGGHTS takes it for a part of the section's name
    grains = [
        f"{number} {2.0 * kind.radius:.17g} {kind.density:.17g} {x:.17g} {y:.17g} {z:.17g}"
        for number, (_, kind) in enumerate(file.kinds, 1)
        for x, y, z in read_places(file)[number - 1].tolist()
    ]
    head = [f"{len(grains)} grains", "", f"{len(grains)} atoms", "3 atom types", ""]
    head += [f"{a:.17g} {b:.17g} {n}lo {n}hi" for n, (a, b) in zip("xyz", ends, strict=True)]
    lines = [f"{number} {grain}" for number, grain in enumerate(grains, 1)]
    return "\n".join([*head, "", "Atoms", "", *lines, ""])
