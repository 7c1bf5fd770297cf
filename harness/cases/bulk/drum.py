"""Grains of two sizes in a rotating drum: mixing, angle of the surface.

The process of Dosta and others, Comput. Phys. Commun. 296, 109066 (2024), smaller and softer, at
the same Froude number and nearly the same filling. Scripts leave places, of all codes alike, and
everything else is computed here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from harness.cases import bulk
from harness.cases.base import Check, Quantity
from harness.cases.bulk import BulkCase, Curve, Plane, Setup, beds
from harness.cases.bulk.beds import (
    LATTICE,
    PUBLISHED,
    Bed,
    Floats,
    PublishedBed,
    Sphere,
    lattice_sites,
    level_bed,
)
from harness.engines.base import Output
from harness.engines.base import Value as ScriptValue
from harness.engines.output import Table
from harness.errors import EngineLostAtomsError

PLACES = ("x_m", "y_m", "z_m")
STEADY = 1.0 / 3.0  # share of the turn after which the surface is that of a turning drum
FLOWING = 30.0  # [deg] of the turn after which no bed is carried as it lay
LAST = 1.0 / 6.0  # share of the turn, up to its end, over which the mixing index is averaged
SOFTENED = "Dosta and others 2024 (moduli four thousand times smaller, a quarter of the size)"
BED = PublishedBed(
    "drum-38k.txt.xz",
    sizes={"large_radius": 2e-3, "small_radius": 1e-3, "drum_radius": 0.1, "drum_length": 0.06},
    counts=(8000, 30000),
    origin=(0.0, 0.0, 0.0),
)


class Drum(Bed):
    """A drum of steel about the y axis: large grains below small ones, then it turns."""

    ROWS = 100
    FRICTIONS = ("large_friction", "small_friction", "mixed_friction", "steel_friction")

    places: beds.Places = ""
    large_layers: int = Field(
        1, ge=-1000, le=1000, description="[-] layers of large grains above the axis"
    )
    small_layers: int = Field(4, ge=1, le=1000, description="[-] layers of small grains above them")
    large_radius: float = Field(2e-3, gt=0.0, description="[m] of a large grain")
    large_density: float = Field(2000.0, gt=0.0, description="[kg/m3] of large grains")
    large_youngs_modulus: float = Field(1.25e5, gt=0.0, description="[Pa] of large grains")
    large_restitution: float = Field(0.4, gt=0.05, le=1.0, description="[-] between large grains")
    large_friction: float = Field(0.4, ge=0.0, le=2.0, description="[-] between large grains")
    small_radius: float = Field(1e-3, gt=0.0, description="[m] of a small grain")
    small_density: float = Field(2500.0, gt=0.0, description="[kg/m3] of small grains")
    small_youngs_modulus: float = Field(2.5e5, gt=0.0, description="[Pa] of small grains")
    small_restitution: float = Field(0.5, gt=0.05, le=1.0, description="[-] between small grains")
    small_friction: float = Field(0.3, ge=0.0, le=2.0, description="[-] between small grains")
    mixed_restitution: float = Field(0.45, gt=0.05, le=1.0, description="[-] of large on small")
    mixed_friction: float = Field(0.2, ge=0.0, le=2.0, description="[-] of large on small")
    rolling_friction: beds.RollingFriction = 0.0
    steel_youngs_modulus: beds.SteelModulus = 5.25e7
    drum_radius: float = Field(0.024, gt=0.0, le=10.0, description="[m] of the drum")
    drum_length: float = Field(0.02, gt=0.0, le=10.0, description="[m] of the drum")
    speed: float = Field(4.08, gt=0.0, le=1e3, description="[rad/s] of the drum")
    turn: float = Field(180.0, gt=0.0, le=1e6, description="[deg] by which the drum turns")
    cell: float = Field(8e-3, gt=0.0, description="[m] edge of the cells of the mixing index")
    step_size: beds.StepSize = 3.5e-5

    def _flaws(self) -> Iterator[str]:
        yield from super()._flaws()
        yield from BED.flaws(self, self.places)
        for kind, count in zip(("large", "small"), self.counts, strict=True):
            if count == 0:
                layers = getattr(self, f"{kind}_layers")
                yield f"{kind}_layers = {layers}: no {kind} grain finds room in the drum"

    @property
    def kinds(self) -> tuple[Sphere, Sphere]:
        """Return a large and a small grain."""
        nu = self.poisson_ratio
        return (
            Sphere(self.large_radius, self.large_density, self.large_youngs_modulus, nu),
            Sphere(self.small_radius, self.small_density, self.small_youngs_modulus, nu),
        )

    @property
    def counts(self) -> tuple[int, ...]:
        """Return the numbers of large and small grains.

        Of a lattice large ones are in the drum below the split, small ones in layers above it.
        """
        if self.places:
            return BED.counts
        split = 2.0 * self.large_layers * self.large_radius * self.spacing
        top = split - self.large_radius * (1.0 + self.scatter)
        low = split + self.small_radius * (1.0 + self.scatter)
        high = low + 2.0 * self.small_layers * self.small_radius * self.spacing
        large = self._sites(self.large_radius, -self.drum_radius, top)
        return large, self._sites(self.small_radius, low, high)

    def _sites(self, radius: float, low: float, high: float) -> int:
        """Return the number of sites with room in the drum between two heights."""
        pitch = 2.0 * radius * self.spacing
        reach = self.drum_radius - radius * (1.0 + math.sqrt(2.0) * self.scatter)
        along = 0.5 * self.drum_length - radius * (1.0 + self.scatter)
        x, z = lattice_sites(pitch, -reach, reach), lattice_sites(pitch, low, high)
        across = int((x[:, None] ** 2 + z**2 <= reach**2).sum())
        return across * len(lattice_sites(pitch, -along, along))

    @property
    def grains(self) -> int:
        """Return the number of grains."""
        return sum(self.counts)

    def of_each(self, name: str) -> Floats:
        """Return a quantity of :class:`Sphere` of each grain, large ones first, (N,)."""
        return np.repeat([getattr(kind, name) for kind in self.kinds], self.counts)

    def section(self, height: float) -> float:
        """Return the area [m2] between the walls at a height above the axis [m]."""
        half_width = math.sqrt(max(self.drum_radius**2 - height**2, 0.0))
        return 2.0 * half_width * self.drum_length

    @property
    def fall(self) -> float:
        """Return the width of the drum [m]."""
        return 2.0 * self.drum_radius

    @property
    def time(self) -> float:
        """Return the time for which the drum turns [s]."""
        return math.radians(self.turn) / self.speed

    @property
    def every(self) -> int:
        """Return the steps between two rows of the series."""
        return max(1, round(self.time / self.step_size / self.ROWS))

    @property
    def values(self) -> dict[str, ScriptValue]:
        """Return the values of a script; published places are in a data file."""
        rim, half = (size + 4.0 * self.large_radius for size in
                     (self.drum_radius, 0.5 * self.drum_length))  # fmt: skip
        ends = (-rim, rim), (-half, half), (-rim, rim)
        return {**super().values, **(BED.values(self.kinds, *ends) if self.places else LATTICE)}


# ---- measures of places


def lacey_index(cells: Floats, chosen: NDArray[np.bool_]) -> float:
    """Return Lacey's mixing index [-]: 0 for unmixed kinds, 1 for a random mixture.

    ``cells`` (N, 2) are column and row of the cell of each grain, ``chosen`` (N,) whether it is of
    one kind. With n_i grains in a cell, p_i of them chosen, and p of all, the variance is
    S = sum n_i (p_i - p)^2 / N: p (1 - p) for unmixed kinds, and p (1 - p) (K - 1)/(N - 1)
    in K cells of a random mixture. The index is the share of the way from the one to the other:
    Lacey, J. Appl. Chem. 4, 257 (1954), for cells of any content. NaN where all grains are of one
    kind, or each is in a cell of its own.
    """
    column, row = cells.T
    number = column * (1.0 + np.ptp(row)) + row  # of its cell; rows of an array take ten times
    _, place = np.unique(number, return_inverse=True)
    content = np.bincount(place).astype(np.float64)
    share = np.bincount(place, weights=chosen) / content
    total, p = len(cells), float(np.mean(chosen))
    unmixed = p * (1.0 - p)
    at_random = unmixed * (len(content) - 1) / (total - 1)
    if unmixed == 0.0 or len(content) == total:
        return math.nan
    variance = float((content * (share - p) ** 2).sum() / total)
    return (unmixed - variance) / (unmixed - at_random)


def surface_angle(x: Floats, z: Floats, radius: Floats, half_width: float, step: float) -> float:
    """Return the angle of the surface [deg], positive where it falls along +x.

    By a straight line through the highest points of the grains (N,) in columns of width ``step``
    between -``half_width`` and ``half_width`` [m]. NaN where fewer than three columns have grains.
    """
    number = round(2.0 * half_width / step)
    edges = np.linspace(-half_width, half_width, number + 1)
    column = np.digitize(x, edges) - 1
    inside = (column >= 0) & (column < number)
    top = np.full(number, -np.inf)
    np.maximum.at(top, column[inside], (z + radius)[inside])
    filled = np.isfinite(top)
    if filled.sum() < 3:
        return math.nan
    middle = 0.5 * (edges[1:] + edges[:-1])
    return -math.degrees(math.atan(np.polyfit(middle[filled], top[filled], 1)[0]))


Contacts = tuple[NDArray[np.int64], NDArray[np.int64], Floats]


def find_contacts(places: Floats, radius: Floats) -> Contacts:
    """Return numbers (K,) and (K,) of grains that touch, each pair once, and overlaps (K,) [m].

    The grains are at ``places`` (N, 3) and have a ``radius`` (N,) [m].
    """
    from scipy.spatial import KDTree  # slow to load

    i, j = KDTree(places).query_pairs(2.0 * radius.max(), output_type="ndarray").T
    overlap = radius[i] + radius[j] - np.linalg.norm(places[i] - places[j], axis=1)
    touch = overlap > 0.0
    return i[touch], j[touch], overlap[touch]


def elastic_energy(p: Drum, places: Floats, contacts: Contacts) -> float:
    """Return the energy of the normal springs of grains at ``places`` (N, 3) [m], with walls [J].

    ``contacts`` are the pairs that touch. 8/15 E* sqrt(R*) overlap^(5/2) (Hertz); walls are taken
    as plane.
    """
    radii, young = p.of_each("radius"), p.of_each("youngs_modulus")
    (i, j, overlap), (x, y, z) = contacts, places.T
    pairs = overlap, 1.0 / young[i] + 1.0 / young[j], 1.0 / (1.0 / radii[i] + 1.0 / radii[j])
    softness = 1.0 / young + 1.0 / p.steel_youngs_modulus
    gaps = p.drum_radius - np.hypot(x, z), 0.5 * p.drum_length - np.abs(y)
    energies = [
        np.sqrt(radius) * np.maximum(depth, 0.0) ** 2.5 / ((1.0 - p.poisson_ratio**2) * soft)
        for depth, soft, radius in (pairs, *((radii - gap, softness, radii) for gap in gaps))
    ]
    return 8.0 / 15.0 * float(sum(energy.sum() for energy in energies))


def energy_and_work(p: Drum, table: Table) -> tuple[Floats, Floats]:
    """Return kinetic and potential energy, and the work of the drum, over time (M,) [J].

    The power of the drum is its speed times its torque on the grains, which changes their angular
    momentum L about the axis and bears their weight: work = speed (L - integral of g sum m x dt).
    Velocities are differences of places between rows; without spins.
    """
    from scipy.integrate import cumulative_trapezoid

    t = p.step_size * (table["step"] - p.settle_steps)
    x, y, z = (table[name] for name in PLACES)
    vx, vy, vz = (np.gradient(axis, t, axis=0) for axis in (x, y, z))
    masses = p.of_each("mass")
    momentum = (z * vx - x * vz) @ masses
    kinetic = 0.5 * (vx**2 + vy**2 + vz**2) @ masses
    momentum[0] = kinetic[0] = 0.0  # at rest
    torque: Floats = p.gravity * x @ masses
    weight = cumulative_trapezoid(torque, t, initial=0)
    return kinetic + p.gravity * z @ masses, p.speed * (momentum - weight)


def _check_walls(p: Drum, table: Table, turned: Floats, engine: str) -> None:
    x, y, z = (table[name] for name in PLACES)
    # curved walls may be a polygon of the circle's area, whose corners are farther out
    beyond = (np.hypot(x, z) > 1.01 * p.drum_radius) | (np.abs(y) > 0.5 * p.drum_length)
    if beyond.any():
        frame = int(np.flatnonzero(beyond.any(axis=1))[0])
        raise EngineLostAtomsError(
            f"{engine}: a grain is beyond the walls after {turned[frame]:.4g} deg: they "
            f"leave a hole, or step_size = {p.step_size:g} s is too long"
        )


PUBLISHED_DRUM = Drum(
    places=PUBLISHED, large_youngs_modulus=5e8, small_youngs_modulus=1e9,
    steel_youngs_modulus=2.1e11, drum_radius=0.1, drum_length=0.06, speed=2.0,
    turn=math.degrees(10.0), settle_time=0.0, step_size=8e-7,
)  # fmt: skip
# the friction of the heap's grains in every pair, and their resistance to rolling: the angle of
# repose, after a third of the turn
SLOW_DRUM = Drum(speed=1.0, turn=120.0, settle_time=0.4, rolling_friction=0.1,
                 **dict.fromkeys(Drum.FRICTIONS, 0.5))  # fmt: skip
RESTS = (0.0, 0.05, 0.1, 0.15)  # [s] of given places before the turn, which let motions part
COMPARED = ("mixing_index", "surface_angle_deg", "bed_solid_fraction", "bed_coordination")


class DrumCase(BulkCase[Drum]):
    """Grains of two sizes in a rotating drum: mixing, angle of the surface.

    Large grains settle below small ones in a drum of steel, which then turns: one of the three
    bulk processes of Dosta and others (2024), at its Froude number and nearly its filling.
    Grains start at the same places in each code. Small grains gather below the surface, so that
    an index of one is not to be expected.
    """

    name = "drum"
    parameters = Drum
    series = ("step", *PLACES)
    quantities = (
        Quantity("mixing_index", "1", "of Lacey, by number of small grains in square cells: 0 "
                 "unmixed, 1 at random; mean over the last sixth of the turn"),
        Quantity("first_mixing_index", "1", "the same before the drum turns", 0.3),
        Quantity("surface_angle_deg", "deg", "dynamic angle of repose: of a line through the "
                 "highest grains in the middle half, mean after a third of the turn", 30.0),
        *bulk.BED_STATE,
        Quantity("work_ratio", "1", "work of the drum, by weight and angular momentum of the "
                 "grains, over their weight times its radius"),
        Quantity("elastic_ratio", "1", "elastic energy of normal springs at rest, over that work",
                 0.01),
        Quantity("loss_ratio", "1", "share of that work lost to dashpots and friction"),
        Quantity("drum_energy_gain_ratio", "1", "largest gain of kinetic and potential energy "
                 "beyond the work of the drum, over that work at the end", 1e-3),
        Quantity("bed_kinetic_ratio", "1", "kinetic energy at rest, over that at the drum's speed",
                 1e-3),
        bulk.WALL_TIME,
    )  # fmt: skip
    presets = {  # noqa: RUF012
        "small": Drum(),
        PUBLISHED: PUBLISHED_DRUM,
        "slow": SLOW_DRUM,
        "slow-sliding": SLOW_DRUM.replace(rolling_friction=0.0),
    }
    sources = {  # noqa: RUF012
        "small": SOFTENED,
        PUBLISHED: "Dosta and others 2024, the bed of 38,000",
        **dict.fromkeys(("slow", "slow-sliding"), f"{SOFTENED}; friction of the heap"),
    }
    curves = (
        Curve("mixing", "Mixing index over the turn", "turned_deg", "turned (deg)",
              "mixing_index", "mixing index of Lacey"),
        Curve("angle", "Angle of the surface over the turn", "turned_deg", "turned (deg)",
              "surface_angle_deg", "angle of the surface (deg)"),
    )  # fmt: skip
    setups = (
        *bulk.seed_setups(Drum(), {"quick": 4, "default": 16, "full": 24}, COMPARED),
        Setup(f"{PUBLISHED}, 4 rests", PUBLISHED,
              tuple(PUBLISHED_DRUM.replace(settle_time=time) for time in RESTS), "full", COMPARED),
    )  # fmt: skip
    gain = "drum_energy_gain_ratio"
    rest_scale = "the energy of a bed that turns with the drum"

    def _quantities(self, p: Drum, output: Output, table: Table) -> dict[str, float]:
        output.check_numbers(dict(zip(("large", "small"), p.counts, strict=True)))
        turned, mixing, angle = self.columns(p, table).values()
        _check_walls(p, table, turned, output.engine)
        radii, mass = p.of_each("radius"), p.of_each("mass").sum()
        first, end = (np.column_stack([table[n][row] for n in PLACES]) for row in (0, -1))
        contacts = find_contacts(first, radii)
        elastic = elastic_energy(p, first, contacts)
        stored = elastic_energy(p, end, find_contacts(end, radii)) - elastic
        energy, done = energy_and_work(p, table)
        lost = done - (energy - energy[0])
        size = abs(done[-1])  # the work is negative of grains that rise against the drum
        height = float(np.average(first[:, 2], weights=radii**3))
        _, volume = level_bed(p.section, -p.drum_radius, p.drum_radius, height)
        at_drum_speed = 0.5 * mass * (p.speed * p.drum_radius) ** 2
        return {
            "mixing_index": float(mixing[turned >= (1.0 - LAST) * p.turn].mean()),
            "first_mixing_index": float(mixing[0]),
            "surface_angle_deg": float(angle[turned >= STEADY * p.turn].mean()),
            "bed_solid_fraction": p.of_each("volume").sum() / volume,
            "bed_coordination": 2.0 * len(contacts[0]) / p.grains,
            "work_ratio": done[-1] / (mass * p.gravity * p.drum_radius),
            "elastic_ratio": elastic / size,
            "loss_ratio": (lost[-1] - stored) / size,
            "drum_energy_gain_ratio": max(0.0, -lost.min()) / size,
            "bed_kinetic_ratio": output.number("bed_kinetic_J") / at_drum_speed,
        }

    def columns(self, p: Drum, table: Table) -> dict[str, Floats]:
        """Return the angle of the turn [deg], mixing index and angle of the surface [deg], (M,).

        The index is by number of small grains; the surface is in the middle half of the drum.
        """
        radii, half = p.of_each("radius"), 0.5 * p.drum_radius
        x, z = table["x_m"], table["z_m"]
        small = radii < 0.5 * (p.large_radius + p.small_radius)
        cells = np.floor(np.stack([x, z], axis=-1) / p.cell)
        angles = [
            surface_angle(*pair, radii, half, 2.0 * p.large_radius)
            for pair in zip(x, z, strict=True)
        ]
        return {
            "turned_deg": np.degrees(p.speed * p.step_size * (table["step"] - p.settle_steps)),
            "mixing_index": np.array([lacey_index(frame, small) for frame in cells]),
            "surface_angle_deg": np.array(angles),
        }

    def _more_checks(self, setup: Setup[Drum]) -> Iterator[Check]:
        """Yield that the surface is inclined as that of grains with friction, where it flows."""
        if STEADY * setup.runs[0].turn >= FLOWING:
            yield self.bound_check(setup, "surface_angle_deg", *bulk.REPOSE)

    def _plane(self, p: Drum) -> Plane:
        angle = np.linspace(0.0, math.tau, 181)
        rim = p.drum_radius * np.cos(angle), p.drum_radius * np.sin(angle)
        return Plane(0.0, [rim], p.of_each("radius"))


CASE = DrumCase()
