"""A steel sphere falls on a bed of small spheres, as a case: depth, deceleration, energy.

The process of Dosta and others, Comput. Phys. Commun. 296, 109066 (2024), two materials and each
pair stated. Beds of other seeds part, so means over seeds are compared, not motions.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from harness.cases.bulk.energy import ELASTIC, judge_gain, tangential_share
from harness.cases.bulk.materials import (
    BedOfOneKind,
    Duration,
    SettleTime,
    Sphere,
    SteelModulus,
    StepSize,
    YoungsModulus,
)
from harness.cases.bulk.materials import values_of as bed_values
from harness.cases.bulk.places import PUBLISHED, PUBLISHED_BOX, Box, data_file, read_places
from harness.cases.bulk.rules import ALLOWED
from harness.cases.bulk.seeds import BulkCase, Curve, Runs, System
from harness.cases.bulk.series import check_rows
from harness.cases.contract import LevelName
from harness.comparison.verdicts import Check, Kind, Tolerance, finding, judge, not_tested
from harness.engines.contract import Job, Output, Template, Value
from harness.engines.traits import Traits
from harness.errors import CombinationError, EngineLostAtomsError, EngineOutputError
from harness.parameters.allowed import allowed_in
from harness.theory.bulk import GLASS_BEADS, friction_by_depth

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from harness.cases.bulk.film import Cut
    from harness.engines.output import Table

NAME = "penetration"
COLUMNS = ("time_s", "z_m", "vz_m_per_s", "kinetic_J", "potential_J")

PLACES: Mapping[LevelName, tuple[float, ...]] = {
    "quick": (),
    "default": (0.0, 4e-3, -4e-3, 8e-3),
    "full": (0.0, 4e-3, -4e-3, 8e-3, -8e-3, 12e-3, -12e-3, 16e-3),
}
"""[m] of the sphere over the published bed from its middle: two diameters of a grain apart."""

TURNED = 0.04
"""[s] in which the sphere turns back in the published bed, after some 30 ms."""

FINAL = 0.1
"""Share of the time after the release over which the final height is averaged."""


class Penetration(BedOfOneKind):
    """A bed that settles, and a steel sphere that falls on it. Walls are of steel."""

    ROWS = 600

    places: str = Field(
        "",
        description="[-] file of the grains' places, lines of radius x y z [m] from the middle of "
        "the floor; published: that of Dosta and others; empty: a lattice that settles",
    )
    length: float = Field(
        0.0, ge=0.0, le=10.0, description="[m] of the box along x; 0: that of the lattice"
    )
    width: float = Field(0.0, ge=0.0, le=10.0, description="[m] along y, likewise")
    along: int = Field(12, ge=2, le=1000, description="[-] grains of the first lattice along x")
    across: int = Field(10, ge=2, le=1000, description="[-] the same along y")
    layers: int = Field(9, ge=1, le=1000, description="[-] the same along z")
    youngs_modulus: YoungsModulus = 1e7
    steel_radius: float = Field(4e-3, gt=0.0, description="[m] of the sphere")
    steel_density: float = Field(7200.0, gt=0.0, description="[kg/m3] of the sphere")
    steel_youngs_modulus: SteelModulus = 2.1e9
    start_height: float = Field(0.026, gt=0.0, description="[m] of the sphere above the floor")
    offset: float = Field(0.0, description="[m] of the sphere from the middle of the box along x")
    speed: float = Field(0.3, gt=0.0, le=100.0, description="[m/s] of the sphere, downward")
    settle_time: SettleTime = 0.12
    duration: Duration = 0.1
    step_size: StepSize = 5e-6

    def _check_system(self) -> None:
        if self.places and not (self.length and self.width):
            raise ValueError(
                f"length = {self.length:g} m, width = {self.width:g} m: must be those of the box "
                "of places"
            )
        if not self.places and (self.length or self.width):
            raise ValueError(
                f"length = {self.length:g} m, width = {self.width:g} m: must be 0 without places, "
                "the box is as wide as the lattice"
            )
        if not self.places:
            check_start(self)
        narrow = min(self.box.length, self.box.width)
        if self.steel_radius > 0.5 * narrow:
            raise ValueError(
                f"steel_radius = {self.steel_radius:g} m: must be at most {0.5 * narrow:.4g}, half "
                "the width of the box"
            )
        if abs(self.offset) > 0.5 * self.box.length - self.steel_radius:
            raise ValueError(
                f"offset = {self.offset:g} m: the sphere is in a wall; must be within "
                f"{0.5 * self.box.length - self.steel_radius:.4g}"
            )

    @property
    def box(self) -> Box:
        """Return floor and walls."""
        if self.places == PUBLISHED:
            return Box(self.length, self.width, PUBLISHED_BOX.middle, PUBLISHED_BOX.floor)
        if self.places:
            return Box(self.length, self.width, (0.0, 0.0), 0.0)
        size = self.along * self.pitch, self.across * self.pitch
        return Box(*size, (0.5 * size[0], 0.5 * size[1]), 0.0)

    @property
    def bed(self) -> NDArray[np.float64]:
        """Return the places of a file (N, 3) [m]; raise RequestError for a bad one."""
        return read_places(self.places, self.radius, self.box)

    @property
    def bed_top(self) -> float:
        """Return the height of the bed at the start [m]."""
        if self.places:
            return float(self.bed[:, 2].max()) + self.radius
        return self.layers * self.pitch

    @property
    def grains(self) -> int:
        """Return how many grains there are."""
        return len(self.bed) if self.places else self.along * self.across * self.layers

    @property
    def steel(self) -> Sphere:
        """Return the sphere."""
        young = self.steel_youngs_modulus
        return Sphere(self.steel_radius, self.steel_density, young, self.poisson_ratio)

    @property
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves and by the shortest impact.

        That of a grain on a fixed wall of steel at the sphere's speed: between grains it is longer.
        """
        speed = math.hypot(self.speed, math.sqrt(2.0 * self.gravity * self.start_height))
        impact = self.grain.impact_step(self.steel_youngs_modulus, speed)
        return min(self.grain.rayleigh_step, self.steel.rayleigh_step, impact)

    @property
    def mass(self) -> float:
        """Return the mass of a grain [kg]."""
        return self.grain.mass

    @property
    def steel_mass(self) -> float:
        """Return the mass of the sphere [kg]."""
        return self.steel.mass

    @property
    def impact_energy(self) -> float:
        """Return the kinetic energy of the sphere at its release [J]."""
        return 0.5 * self.steel_mass * self.speed**2

    @property
    def solid_volume(self) -> float:
        """Return the volume of all grains [m3]."""
        return self.grains * self.grain.volume

    @property
    def floor_area(self) -> float:
        """Return the area of the floor [m2]."""
        return self.box.length * self.box.width


def check_start(p: Penetration) -> None:
    """Raise CombinationError where the sphere starts within the bed; reads the file of places."""
    lowest = p.bed_top + p.steel_radius
    if p.start_height < lowest:
        raise CombinationError(
            f"start_height = {p.start_height:g} m: the sphere overlaps the grains at the "
            f"start; must be at least {lowest:.4g}"
        )


def values_of(p: Penetration) -> dict[str, Value]:
    """Return the values of a script; places are in a file that is named by its content."""
    box: dict[str, Value] = {
        "bed": "lattice",
        "places": "none",
        "length": p.box.length,
        "width": p.box.width,
    }
    if p.places:
        check_start(p)
        top = p.bed_top + 2.0 * (p.start_height + p.steel_radius)
        path = data_file(p.bed, p.radius, p.density, p.box, top)
        box |= {"bed": "file", "places": str(path)}
    return {**bed_values(p), **box}


TEMPLATE = Template(NAME, {"": values_of(Penetration())}, allowed=allowed_in(Penetration) | ALLOWED)


def largest_elastic_energy(p: Penetration) -> float:
    """Return a bound of the elastic energy of the bed at rest [J]."""
    column = p.grains * (2.0 * p.radius) ** 2 / p.floor_area if p.places else p.layers
    return p.elastic_bound(column * p.mass * p.gravity)


def height_quantities(p: Penetration, table: Table, released: float) -> dict[str, float]:
    """Return the quantities of a series; ``released`` is kinetic and potential energy [J] at first.

    Decelerations are means over the time between two rows of the series.
    """
    after = table["time_s"] > 0.0  # some codes also leave a row of the release itself
    t, z, v, kinetic, potential = (table[name][after] for name in COLUMNS)
    energy = kinetic + potential
    impact = p.impact_energy
    lowest = int(np.argmin(z))
    fastest = int(np.argmin(v))
    slow = v[fastest:] > 0.1 * v[fastest]
    if not slow.any():
        raise EngineOutputError(
            f"duration = {p.duration:g} s: the sphere still falls at a tenth of its largest speed"
        )
    last = t >= t[-1] - FINAL * (t[-1] - t[0])
    return {
        "final_height_m": float(z[last].mean()),
        "lowest_height_m": float(z[lowest]),
        "slowed_time_s": float(t[fastest:][slow][0]),
        "peak_deceleration_m_per_s2": float((np.diff(v) / np.diff(t)).max()),
        "rebound_speed_m_per_s": float(max(0.0, v[lowest:].max())),
        "energy_gain_ratio": float(max(0.0, (energy - released).max()) / impact),
        "dissipated_ratio": float((released - energy[-1]) / impact),
    }


AT_REST = Tolerance(
    "", 0.01, 0.0, "a bed that moves gives the sphere 1 % of its own energy at most"
)


class PenetrationCase(BulkCase[Penetration]):
    """A steel sphere falls on a bed of small spheres: depth, deceleration, energy."""

    name = NAME
    template = TEMPLATE
    seeds = {"quick": 4, "default": 28, "full": 48}  # noqa: RUF012
    judged = ("no energy is gained", "the bed is at rest at the release", "friction by depth")
    equivalent = ("final_depth_m", "bed_solid_fraction", "bed_coordination")
    drawn = (
        Curve(
            "{system}-heights",
            "time after the release (ms)",
            "height of the sphere's centre (mm)",
            ("time_s", "height_m"),
            scale=(1e3, 1e3),
        ),
        Curve(
            "{system}-velocities",
            "time after the release (ms)",
            "velocity of the sphere, upward (m/s)",
            ("time_s", "velocity_m_per_s"),
            scale=(1e3, 1.0),
        ),
        Curve(
            "{system}-decelerations",
            "time after the release (ms)",
            "deceleration of the sphere (m/s2)",
            ("time_s", "deceleration_m_per_s2"),
            scale=(1e3, 1.0),
        ),
    )

    def source_of(self, preset: str) -> str:
        """Return where the materials were published."""
        if preset == PUBLISHED:
            return "Dosta and others 2024, the bed of 25,000"
        return "Dosta and others 2024 (moduli a hundred times smaller, smaller box and sphere)"

    @property
    def presets(self) -> Mapping[str, Penetration]:
        """Return a thousand soft grains, and the bed of 25,000 as published."""
        published = Penetration(
            places=PUBLISHED,
            length=PUBLISHED_BOX.length,
            width=PUBLISHED_BOX.width,
            youngs_modulus=1e9,
            steel_radius=0.01,
            steel_youngs_modulus=2.1e11,
            start_height=0.06 - PUBLISHED_BOX.floor,
            speed=5.0,
            settle_time=0.0,
            step_size=5e-7,
        )
        return {"small": Penetration(), PUBLISHED: published}

    def systems(self, level: LevelName) -> Sequence[System]:
        """Return the soft bed over seeds, and, but at level quick, the published one over places.

        At level default that until the sphere has turned back, and one place as long as published;
        at full all places so long.
        """
        if not PLACES[level]:
            return super().systems(level)
        name, published = f"{self.name}: {PUBLISHED}", self.presets[PUBLISHED]
        whole = System(
            f"{name}, its whole time", published, {"offset 0 m": published}, (), from_level="full"
        )
        p = published if level == "full" else published.replace(duration=TURNED)
        trials = {f"offset {x:g} m": p.replace(offset=x) for x in PLACES[level]}
        equivalent = ("largest_depth_m", "slowed_time_s")
        places = System(name, p, trials, equivalent, from_level="full")
        both = (*super().systems(level), places)
        return both if level == "full" else (*both, whole)

    def job(self, parameters: Penetration) -> Job:
        """Return the job of one impact."""
        return Job(TEMPLATE, values_of(parameters), sampled=True)

    def read(self, parameters: Penetration, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return depth, deceleration, energies, state of the bed.

        Raise EngineLostAtomsError where a particle passed a wall.
        """
        p = parameters
        output.check_numbers({"grains": p.grains, "steps": p.settle_steps + p.steps})
        if output.number("outside") != 0.0:
            raise EngineLostAtomsError(
                f"{output.who}: a particle passed a wall at step_size = {p.step_size:g} s, "
                f"youngs_modulus = {p.youngs_modulus:g} Pa"
            )
        impact = p.impact_energy
        released = output.number("bed_kinetic_J") + output.number("release_potential_J") + impact
        table = output.table(COLUMNS)
        check_rows(table["time_s"], p.steps * p.step_size, output.who)
        heights = height_quantities(p, table, released)
        elastic = {
            f"{name[:-2]}_ratio": output.number(name) / impact
            for name in ("elastic_J", "end_elastic_J")
            if output.has(name)
        }
        if len(elastic) == 2:
            change = elastic[ELASTIC] - elastic["end_elastic_ratio"]
            elastic["balance_ratio"] = heights["dissipated_ratio"] + change
        mean_height = output.number("mean_height_m")
        surface = 2.0 * mean_height
        solid = p.solid_volume / (p.floor_area * surface)
        depth = surface + p.steel_radius - heights["final_height_m"]
        fall = p.start_height - p.steel_radius - surface + 0.5 * p.speed**2 / p.gravity
        ratio = p.steel_density / (p.density * solid)
        work = p.grains * (p.settle_steps + p.steps)
        return {
            **heights,
            **elastic,
            "final_depth_m": depth,
            "largest_depth_m": surface + p.steel_radius - heights["lowest_height_m"],
            "friction_by_depth": friction_by_depth(depth, fall, 2.0 * p.steel_radius, ratio)
            if depth > 0.0
            else math.nan,
            "bed_solid_fraction": solid,
            "bed_coordination": output.number("coordination"),
            "bed_kinetic_ratio": output.number("bed_kinetic_J") / impact,
            "microseconds_per_particle_step": 1e6 * output.seconds / work,
        }

    def cut(self, p: Penetration) -> Cut:
        """Return the box through the sphere."""
        from harness.cases.bulk.film import Cut  # slow to load

        top = p.start_height + 2.0 * p.steel_radius
        walls = [([0.0, 0.0, p.box.length, p.box.length], [top, 0.0, 0.0, top])]
        return Cut(0.5 * p.box.width, walls, -p.radius, top)

    def curves(
        self, p: Penetration, output: Output
    ) -> Sequence[tuple[NDArray[np.float64], NDArray[np.float64]]]:
        """Return height [m], velocity [m/s] and deceleration [m/s2] of the sphere over time [s].

        A deceleration is the mean over the time from the row before to the row after.
        """
        table = output.table(COLUMNS)
        t, z, v = (table[name] for name in COLUMNS[:3])
        return (t, z), (t, v), (t, np.gradient(v, t))

    def judge(self, names: Sequence[str], runs: Runs, p: Penetration) -> list[Check]:
        """Return energy gained and bed at rest, of the worst seed; the known depth as seen."""
        moves = runs.worst("bed_kinetic_ratio")
        share = tangential_share(max(p.friction, p.steel_friction), p.poisson_ratio)
        bound = largest_elastic_energy(p) / p.impact_energy
        return [
            judge_gain(names[0], runs, "energy_gain_ratio", share, bound),
            judge(names[1], Kind.ANALYTIC, moves, 0.0, AT_REST),
            judge_depth(names[2], runs, p),
        ]


def judge_depth(name: str, runs: Runs, p: Penetration) -> Check:
    """Return the known depth as a finding; not tested where the floor ends the fall of a run."""
    above_floor = runs.sample("lowest_height_m").mean - p.steel_radius
    if above_floor < 2.0 * p.radius:
        why = (
            f"the floor ends the fall: the sphere stops {1e3 * above_floor:.2g} mm above it, less "
            f"than a grain's diameter of {2e3 * p.radius:g} mm"
        )
        return not_tested(name, Kind.ANALYTIC, why)
    return finding(
        name,
        runs.sample("friction_by_depth").mean,
        GLASS_BEADS,
        "",
        "tangent of the angle of repose by the depth, 0.14/mu (rho_s/rho_b)^(1/2) D^(2/3) H^(1/3) "
        "(Uehara and others 2003); 0.45 is that of glass beads",
    )


CASE = PenetrationCase()
