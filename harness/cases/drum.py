"""Grains of two sizes in a rotating drum, as a case: mixing, angle of the surface.

The process of Dosta and others, Comput. Phys. Commun. 296, 109066 (2024), smaller and softer, at
the same Froude number and nearly the same filling. Places are read of all codes alike, and
evaluated here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq

from harness.cases.bulk.energy import ELASTIC, judge_gain, tangential_share
from harness.cases.bulk.materials import (
    Bed,
    RollingFriction,
    Sphere,
    SteelModulus,
    StepSize,
)
from harness.cases.bulk.materials import values_of as bed_values
from harness.cases.bulk.mixing import Contacts, cells_of, lacey_index, surface_angle, touching
from harness.cases.bulk.places import PUBLISHED, Cylinder, read_grains, write_grains
from harness.cases.bulk.rules import ALLOWED, NEUTRAL, Law, law_of
from harness.cases.bulk.seeds import BulkCase, Curve, Runs, System
from harness.cases.bulk.series import check_rows
from harness.cases.contract import LevelName
from harness.comparison.verdicts import Check, Kind, Tolerance, judge
from harness.engines.contract import Job, Output, Template, Value
from harness.engines.traits import Traits
from harness.errors import EngineLostAtomsError, RequestError
from harness.parameters.allowed import allowed_in

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from harness.cases.bulk.film import Cut
    from harness.engines.output import Table

    Floats = NDArray[np.float64]

NAME = "drum"
COLUMNS = ("step", "x_m", "y_m", "z_m")

STEADY = 1.0 / 3.0
"""Share of the turn after which the surface is that of a drum that turns."""

LAST = 1.0 / 6.0
"""Share of the turn over which the mixing index is averaged, up to the end."""


class Drum(Bed):
    """A drum of steel about the y axis: large grains below small ones, then it turns."""

    ROWS = 100
    DERIVED = frozenset({"settle_time", "turn", "cell"})

    places: str = Field(
        "",
        description="[-] file of the grains' places, lines of radius x y z [m] from the middle of "
        "the axis; published: that of Dosta and others; empty: lattices that settle",
    )
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
    rolling_friction: RollingFriction = 0.0
    steel_youngs_modulus: SteelModulus = 5.25e7
    drum_radius: float = Field(0.024, gt=0.0, le=10.0, description="[m] of the drum")
    drum_length: float = Field(0.02, gt=0.0, le=10.0, description="[m] of the drum")
    speed: float = Field(4.08, gt=0.0, le=1e3, description="[rad/s] of the drum")
    turn: float = Field(180.0, gt=0.0, le=1e6, description="[deg] by which the drum turns")
    cell: float = Field(8e-3, gt=0.0, description="[m] edge of the cells of the mixing index")
    step_size: StepSize = 3.5e-5

    def _check_system(self) -> None:
        for kind in ("large", "small") if not self.places else ():
            if getattr(self, f"{kind}_grains") == 0:
                raise ValueError(
                    f"{kind}_layers = {getattr(self, f'{kind}_layers')}: no {kind} grain finds "
                    "room in the drum"
                )

    @property
    def large(self) -> Sphere:
        """Return a large grain."""
        young = self.large_youngs_modulus
        return Sphere(self.large_radius, self.large_density, young, self.poisson_ratio)

    @property
    def small(self) -> Sphere:
        """Return a small grain."""
        young = self.small_youngs_modulus
        return Sphere(self.small_radius, self.small_density, young, self.poisson_ratio)

    @property
    def split(self) -> float:
        """Return the height at which small grains begin [m]."""
        return 2.0 * self.large_layers * self.large_radius * self.spacing

    @property
    def large_grains(self) -> int:
        """Return how many large grains there are: in the drum, below the split."""
        if self.places:
            return len(self.bed[0])
        low, high = -self.drum_radius, self.split - self.large_radius * (1.0 + self.scatter)
        return self._sites(self.large_radius, low, high)

    @property
    def small_grains(self) -> int:
        """Return how many small grains there are: so many layers above the split."""
        if self.places:
            return len(self.bed[1])
        low = self.split + self.small_radius * (1.0 + self.scatter)
        high = low + 2.0 * self.small_layers * self.small_radius * self.spacing
        return self._sites(self.small_radius, low, high)

    @property
    def bed(self) -> tuple[Floats, Floats]:
        """Return the places of large and of small grains of a file, (N, 3) [m] each.

        Raise RequestError for a bad file, or one without a kind.
        """
        radii = (("large_radius", self.large_radius), ("small_radius", self.small_radius))
        rows = read_grains(self.places, radii, Cylinder(self.drum_radius, self.drum_length))
        large = rows[:, 0] == self.large_radius
        for (name, radius), number in zip(radii, (large.sum(), (~large).sum()), strict=True):
            if number == 0:
                raise RequestError(f"places {self.places}: no grain of {name} = {radius:g} m")
        return rows[large, 1:], rows[~large, 1:]

    def _sites(self, radius: float, low: float, high: float) -> int:
        """Return how many sites (i + 1/2) pitches have room in the drum between two heights."""
        pitch = 2.0 * radius * self.spacing
        reach = self.drum_radius - radius * (1.0 + math.sqrt(2.0) * self.scatter)
        along = 0.5 * self.drum_length - radius * (1.0 + self.scatter)
        most = max(1, math.ceil(max(reach, along) / pitch) + 1)
        site = pitch * (np.arange(-most, most) + 0.5)
        z = site[(site >= low) & (site <= high)]
        across = (site[:, None] ** 2 + z**2 <= reach**2).sum() if reach > 0.0 else 0
        return int(across * (np.abs(site) <= along).sum())

    @property
    def grains(self) -> int:
        """Return how many grains there are."""
        return self.large_grains + self.small_grains

    @property
    def radii(self) -> Floats:
        """Return the radius of each grain [m], large ones first, (N,)."""
        return self.of_each(self.large_radius, self.small_radius)

    @property
    def masses(self) -> Floats:
        """Return the mass of each grain [kg], large ones first, (N,)."""
        return self.of_each(self.large.mass, self.small.mass)

    def of_each(self, large: float, small: float) -> Floats:
        """Return the value of each grain, of large ones first, (N,)."""
        return np.repeat([large, small], [self.large_grains, self.small_grains])

    @property
    def solid_volume(self) -> float:
        """Return the volume of the grains [m3]."""
        return self.large_grains * self.large.volume + self.small_grains * self.small.volume

    @property
    def fill(self) -> float:
        """Return the share of the drum that the grains fill, 0.6 of what they take up solid."""
        return self.solid_volume / 0.6 / (math.pi * self.drum_radius**2 * self.drum_length)

    def solid_fraction(self, mean_height: float) -> float:
        """Return the solid fraction of a level bed whose volume has a mean height [m].

        A bed up to cos(a) = -h/R fills R^2 (a - sin a cos a) of the drum's section, whose centre is
        2/3 R sin^3(a)/(a - sin a cos a) below the axis.
        """

        def section(angle: float) -> float:
            return angle - math.sin(angle) * math.cos(angle)

        def off(angle: float) -> float:
            centre = 2.0 / 3.0 * self.drum_radius * math.sin(angle) ** 3 / section(angle)
            return mean_height + centre

        filled = section(float(brentq(off, 1e-2, math.pi)))
        return self.solid_volume / (filled * self.drum_radius**2 * self.drum_length)

    @property
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves and by impacts after a fall in the drum."""
        speed = math.sqrt(2.0 * self.gravity * 2.0 * self.drum_radius)
        steel = self.steel_youngs_modulus
        return min(
            *(kind.rayleigh_step for kind in (self.large, self.small)),
            *(kind.impact_step(steel, speed) for kind in (self.large, self.small)),
        )

    @property
    def time(self) -> float:
        """Return how long the drum turns [s]."""
        return math.radians(self.turn) / self.speed

    @property
    def every(self) -> int:
        """Return the steps between two rows of the series."""
        return max(1, round(self.time / self.step_size / self.ROWS))


def elastic_energy(p: Drum, places: Floats, contacts: Contacts) -> float:
    """Return what the normal springs of grains at ``places`` (N, 3) [m] hold, walls included [J].

    ``contacts`` are the pairs that touch there. 8/15 E* sqrt(R*) overlap^(5/2) (Hertz); walls are
    taken as plane.
    """
    radii, young = p.radii, p.of_each(p.large_youngs_modulus, p.small_youngs_modulus)

    def held(overlap: Floats, moduli: tuple[Floats, Floats | float], radius: Floats) -> float:
        compliance = (1.0 - p.poisson_ratio**2) * (1.0 / moduli[0] + 1.0 / moduli[1])
        return float((np.sqrt(radius) * np.maximum(overlap, 0.0) ** 2.5 / compliance).sum())

    i, j, overlap = contacts
    total = held(overlap, (young[i], young[j]), 1.0 / (1.0 / radii[i] + 1.0 / radii[j]))
    x, y, z = places.T
    for reach in (p.drum_radius - np.hypot(x, z), 0.5 * p.drum_length - np.abs(y)):
        total += held(radii - reach, (young, p.steel_youngs_modulus), radii)
    return 8.0 / 15.0 * total


def drum_energy(p: Drum, table: Table) -> tuple[Floats, Floats]:
    """Return kinetic and potential energy, and the work of the drum, over time (M,) [J].

    In any code, from places alone. The drum does its speed times its torque on the grains, which
    changes their angular momentum L about the axis and bears their weight: work = speed (L -
    integral of g sum m x dt). Velocities are differences of places between rows, spins are left
    out.
    """
    t = p.step_size * (table["step"] - p.settle_steps)
    x, y, z = (table[name] for name in COLUMNS[1:])
    vx, vy, vz = (np.gradient(axis, t, axis=0) for axis in (x, y, z))
    masses = p.masses
    momentum = (z * vx - x * vz) @ masses
    kinetic = 0.5 * (vx**2 + vy**2 + vz**2) @ masses
    momentum[0] = kinetic[0] = 0.0  # at rest
    torque: Floats = p.gravity * x @ masses
    weight = cumulative_trapezoid(torque, t, initial=0)
    return kinetic + p.gravity * z @ masses, p.speed * (momentum - weight)


def values_of(p: Drum) -> dict[str, Value]:
    """Return the values of a script; places are in a file that is named by its content."""
    more: dict[str, Value] = {"bed": "lattice", "places": "none"}
    if p.places:
        rim = p.drum_radius + 4.0 * p.large_radius
        half = 0.5 * p.drum_length + 4.0 * p.large_radius
        kinds = zip(p.bed, (p.large, p.small), strict=True)
        grains = [(places, kind.radius, kind.density) for places, kind in kinds]
        path = write_grains(grains, ((-rim, rim), (-half, half), (-rim, rim)))
        more = {"bed": "file", "places": str(path)}
    return {**bed_values(p), **more}


TEMPLATE = Template(
    NAME, {"": values_of(Drum())}, allowed=allowed_in(Drum) | ALLOWED, neutral=NEUTRAL
)


def check_walls(p: Drum, table: Table, who: str) -> None:
    """Raise EngineLostAtomsError for a grain whose centre is beyond a wall.

    Curved walls may be a polygon of the circle's area, whose corners are farther out.
    """
    x, y, z = (table[name] for name in COLUMNS[1:])
    beyond = (np.hypot(x, z) > 1.01 * p.drum_radius) | (np.abs(y) > 0.5 * p.drum_length)
    if beyond.any():
        frame = int(np.flatnonzero(beyond.any(axis=1))[0])
        raise EngineLostAtomsError(
            f"{who}: a grain is beyond the walls after {turned(p, table)[frame]:.4g} deg: they "
            f"leave a hole, or step_size = {p.step_size:g} s is too long"
        )


def turned(p: Drum, table: Table) -> Floats:
    """Return by how much the drum has turned [deg], (M,)."""
    steps = table["step"] - p.settle_steps
    return np.asarray(np.degrees(p.speed * p.step_size * steps))


def mixing(p: Drum, table: Table) -> Floats:
    """Return the mixing index by number of small grains over time, (M,)."""
    small = p.radii < 0.5 * (p.large_radius + p.small_radius)
    frames = zip(table["x_m"], table["z_m"], strict=True)
    return np.array([lacey_index(cells_of(x, z, p.cell), small) for x, z in frames])


def angles(p: Drum, table: Table) -> Floats:
    """Return the angle of the surface [deg] over time, (M,): in the middle half of the drum."""
    frames = zip(table["x_m"], table["z_m"], strict=True)
    half, step = 0.5 * p.drum_radius, 2.0 * p.large_radius
    return np.array([surface_angle(x, z, p.radii, half, step) for x, z in frames])


def quadrant_shares(p: Drum, table: Table) -> dict[str, Floats]:
    """Return the share of each kind in two opposite quadrants over time, (M,).

    Where grains rise, x < 0 < z, and where they arrive, z < 0 < x.
    """
    x, z = table["x_m"], table["z_m"]
    large = np.arange(p.grains) < p.large_grains
    places = {"rising": (x < 0.0) & (z > 0.0), "falling": (x > 0.0) & (z < 0.0)}
    return {
        f"{kind}_{name}_ratio": place[:, which].mean(axis=1)
        for name, place in places.items()
        for kind, which in (("large", large), ("small", ~large))
    }


AT_REST = Tolerance(
    "", 0.01, 0.0, "a bed that moves adds 1 % to the energy of one that turns with the drum at most"
)


def over_turn(figure: str, label: str, column: str) -> Curve:
    """Return a curve over the turn."""
    return Curve(f"{{system}}-{figure}", "turned (deg)", label, ("turned_deg", column))


class DrumCase(BulkCase[Drum]):
    """Grains of two sizes in a rotating drum: mixing, angle of the surface."""

    name = NAME
    template = TEMPLATE
    seeds = {"quick": 4, "default": 16, "full": 24}  # noqa: RUF012
    judged = ("no energy is gained", "the bed is at rest before the drum turns")
    equivalent = ("mixing_index", "surface_angle_deg", "bed_solid_fraction", "bed_coordination")
    drawn = (
        over_turn("mixing", "mixing index of Lacey", "mixing_index"),
        over_turn("angle", "angle of the surface (deg)", "surface_angle_deg"),
        over_turn("quadrants", "share of the large grains at x < 0 < z", "large_rising_ratio"),
        over_turn("small-rising", "share of the small grains at x < 0 < z", "small_rising_ratio"),
        over_turn("large-falling", "share of the large grains at z < 0 < x", "large_falling_ratio"),
        over_turn("small-falling", "share of the small grains at z < 0 < x", "small_falling_ratio"),
    )

    def source_of(self, preset: str) -> str:
        """Return where materials and process were published."""
        if preset == PUBLISHED:
            return "Dosta and others 2024, the bed of 38,000"
        source = "Dosta and others 2024 (moduli four thousand times smaller, a quarter of the size)"
        return f"{source}; friction of the heap" if preset.startswith("slow") else source

    @property
    def presets(self) -> Mapping[str, Drum]:
        """Return seven hundred soft grains, the drum of 38,000 as published, and a slow one.

        The slow drum has the friction of the heap's grains in every pair, with and without their
        resistance to rolling: the angle of repose, after a third of its turn.
        """
        published = Drum(
            places=PUBLISHED,
            large_youngs_modulus=5e8,
            small_youngs_modulus=1e9,
            steel_youngs_modulus=2.1e11,
            drum_radius=0.1,
            drum_length=0.06,
            speed=2.0,
            turn=math.degrees(10.0),
            settle_time=0.0,
            step_size=8e-7,
        )
        frictions = ("large_friction", "small_friction", "mixed_friction", "steel_friction")
        sliding = Drum(speed=1.0, turn=120.0, settle_time=0.4, **dict.fromkeys(frictions, 0.5))
        rolling = sliding.replace(rolling_friction=0.1)
        return {"small": Drum(), PUBLISHED: published, "slow": rolling, "slow-sliding": sliding}

    def systems(self, level: LevelName) -> Sequence[System]:
        """Return the small drum, and at level full the published one from four beginnings.

        Its places are given: it turns at once, or after a rest that lets motions part.
        """
        if level != "full":
            return super().systems(level)
        p = self.presets[PUBLISHED]
        trials = {f"rest {t:g} s": p.replace(settle_time=t) for t in (0.0, 0.05, 0.1, 0.15)}
        published = System(f"{self.name}: {PUBLISHED}", p, trials, from_level="full")
        return (*super().systems(level), published)

    def law(self, traits: Traits, parameters: Drum) -> Law:
        """Return by which rules an engine follows the law, those of rolling included."""
        return law_of(traits, parameters.rolling_friction)

    def job(self, parameters: Drum) -> Job:
        """Return the job of one drum."""
        return Job(TEMPLATE, values_of(parameters), sampled=True)

    def read(self, parameters: Drum, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return mixing, angle of the surface, state of the bed.

        Raise EngineLostAtomsError where a grain passed a wall.
        """
        p = parameters
        known = {"large": p.large_grains, "small": p.small_grains}
        output.check_numbers({**known, "steps": p.settle_steps + p.steps})
        table = output.table(COLUMNS)
        check_rows(table["step"] - p.settle_steps, p.steps, output.who)
        check_walls(p, table, output.who)
        angle = turned(p, table)
        late, last = (angle >= share * p.turn for share in (STEADY, 1.0 - LAST))
        index = mixing(p, table)
        work = p.grains * (p.settle_steps + p.steps)
        radii, mass = p.radii, p.masses.sum()
        first, end = (np.column_stack([table[n][row] for n in COLUMNS[1:]]) for row in (0, -1))
        height = float(np.average(first[:, 2], weights=radii**3))
        contacts, contacts_at_end = (touching(places, radii) for places in (first, end))
        elastic = elastic_energy(p, first, contacts)
        stored = elastic_energy(p, end, contacts_at_end) - elastic
        energy, done = drum_energy(p, table)
        lost = done - (energy - energy[0])
        size = abs(done[-1])  # the work is negative of grains that rise against the drum
        return {
            "mixing_index": float(index[last].mean()),
            "first_mixing_index": float(index[0]),
            "surface_angle_deg": float(angles(p, table)[late].mean()),
            **{name: float(share[-1]) for name, share in quadrant_shares(p, table).items()},
            "bed_solid_fraction": p.solid_fraction(height),
            "bed_coordination": 2.0 * len(contacts[0]) / p.grains,
            "work_ratio": done[-1] / (mass * p.gravity * p.drum_radius),
            ELASTIC: elastic / size,
            "loss_ratio": (lost[-1] - stored) / size,
            "drum_energy_gain_ratio": max(0.0, -lost.min()) / size,
            "bed_kinetic_ratio": output.number("bed_kinetic_J")
            / (0.5 * mass * (p.speed * p.drum_radius) ** 2),
            "microseconds_per_particle_step": 1e6 * output.seconds / work,
        }

    def radii(self, p: Drum) -> Floats:
        """Return the radius of each grain, large ones first."""
        return p.radii

    def cut(self, p: Drum) -> Cut:
        """Return the drum halfway along its axis."""
        from harness.cases.bulk.film import Cut, circle  # slow to load

        reach = 1.05 * p.drum_radius
        return Cut(0.0, [circle(p.drum_radius)], -reach, reach)

    def curves(self, p: Drum, output: Output) -> Sequence[tuple[Floats, Floats]]:
        """Return mixing index, angle [deg], shares in quadrants over the turn [deg]."""
        table = output.table(COLUMNS)
        shares = quadrant_shares(p, table)
        over = {"mixing_index": mixing(p, table), "surface_angle_deg": angles(p, table), **shares}
        return [(turned(p, table), over[curve.columns[1]]) for curve in self.drawn]

    def judge(self, names: Sequence[str], runs: Runs, p: Drum) -> list[Check]:
        """Return energy gained and bed at rest, of the worst seed."""
        moves = runs.worst("bed_kinetic_ratio")
        friction = max(p.large_friction, p.small_friction, p.mixed_friction, p.steel_friction)
        share = tangential_share(friction, p.poisson_ratio)
        return [
            judge_gain(names[0], runs, "drum_energy_gain_ratio", share, math.nan),
            judge(names[1], Kind.ANALYTIC, moves, 0.0, AT_REST),
        ]


CASE = DrumCase()
