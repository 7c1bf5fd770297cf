"""A steel sphere falls on a bed of small spheres, as a case: depth, deceleration, energy.

The process of Dosta and others, Comput. Phys. Commun. 296, 109066 (2024), two materials and each
pair stated. Beds of other seeds part, so means over seeds are compared, not motions.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field, model_validator

from harness.cases.bulk.equivalence import FEWEST, Sample, equivalence, interval
from harness.cases.bulk.places import PUBLISHED, PUBLISHED_BOX, Box, data_file, read_places
from harness.cases.contract import Case, LevelName, Study, Words
from harness.comparison.plan import Planned
from harness.comparison.verdicts import Check, Kind, Tolerance, failed_run, judge, not_tested
from harness.comparison.verification import Findings
from harness.engines.border import engine_seconds
from harness.engines.contract import Engine, Job, Output, Template, Value
from harness.engines.traits import Traits
from harness.errors import (
    CombinationError,
    EngineError,
    EngineLostAtomsError,
    EngineOutputError,
)
from harness.parameters.allowed import allowed_in
from harness.parameters.base import Parameters
from harness.report.sections import Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from harness.engines.output import Table

NAME = "penetration"
COLUMNS = ("time_s", "z_m", "vz_m_per_s", "kinetic_J", "potential_J")

SAMPLES = 600
"""Rows of the series."""

FINAL = 0.1
"""Share of the time after the release over which the final height is averaged."""

RAYLEIGH = 0.2
"""Of the time in which a Rayleigh wave goes round half a sphere, the longest step."""

STEPS_IN_IMPACT = 20.0
"""Fewest steps of a Hertz impact."""

PACKED = 4.0
"""Cost of a particle and step in a bed with friction, by that of a grain on a row: LAMMPS took
0.4 us."""


class Penetration(Parameters):
    """A bed that settles, and a steel sphere that falls on it. Walls are of steel."""

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
    spacing: float = Field(
        1.2, gt=1.0, le=3.0, description="[-] of the lattice, in diameters; the box is as wide"
    )
    scatter: float = Field(
        0.19, ge=0.0, le=1.0, description="[-] range of the first places, in diameters"
    )
    seed: int = Field(1, ge=1, le=10000, description="[-] of the first places")
    radius: float = Field(1e-3, gt=0.0, description="[m] of a grain")
    density: float = Field(2500.0, gt=0.0, description="[kg/m3] of the grains")
    youngs_modulus: float = Field(1e7, gt=0.0, description="[Pa] of the grains")
    poisson_ratio: float = Field(0.2, ge=0.0, lt=0.5, description="[-] of grains and steel")
    restitution: float = Field(0.5, gt=0.05, le=1.0, description="[-] between grains")
    friction: float = Field(0.3, ge=0.0, le=2.0, description="[-] between grains")
    steel_radius: float = Field(4e-3, gt=0.0, description="[m] of the sphere")
    steel_density: float = Field(7200.0, gt=0.0, description="[kg/m3] of the sphere")
    steel_youngs_modulus: float = Field(2.1e9, gt=0.0, description="[Pa] of sphere and walls")
    steel_restitution: float = Field(0.4, gt=0.05, le=1.0, description="[-] on steel")
    steel_friction: float = Field(0.2, ge=0.0, le=2.0, description="[-] on steel")
    start_height: float = Field(0.026, gt=0.0, description="[m] of the sphere above the floor")
    offset: float = Field(0.0, description="[m] of the sphere from the middle of the box along x")
    speed: float = Field(0.3, gt=0.0, le=100.0, description="[m/s] of the sphere, downward")
    gravity: float = Field(9.81, gt=0.0, description="[m/s2] downward")
    settle_time: float = Field(0.12, ge=0.0, description="[s] before the release")
    duration: float = Field(0.1, gt=0.0, description="[s] after the release")
    step_size: float = Field(5e-6, gt=0.0, description="[s] time step")

    @model_validator(mode="after")
    def _holds(self) -> Penetration:
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
        if self.scatter > self.spacing - 1.0:
            raise ValueError(
                f"scatter = {self.scatter:g}: grains overlap at the start; must be at most "
                f"spacing - 1 = {self.spacing - 1.0:.4g}"
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
        if self.step_size > self.longest_step:
            raise ValueError(
                f"step_size = {self.step_size:g} s: must be at most {self.longest_step:.4g}, "
                f"{RAYLEIGH:g} of the Rayleigh time and 1/{STEPS_IN_IMPACT:g} of an impact"
            )
        return self

    @property
    def pitch(self) -> float:
        """Return the distance of the lattice's sites [m]."""
        return 2.0 * self.radius * self.spacing

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
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves and by the shortest impact.

        Impact of a grain on a fixed wall of its modulus with steel at the sphere's speed:
        2.8683 (m^2/(R E*^2 v))^(1/5) (Hertz; Johnson, Contact Mechanics, 11.24); between grains
        it is longer.
        """
        shortest = math.inf
        nu = self.poisson_ratio
        for r, rho, young in (
            (self.radius, self.density, self.youngs_modulus),
            (self.steel_radius, self.steel_density, self.steel_youngs_modulus),
        ):
            wave = math.pi * r * math.sqrt(2.0 * rho * (1.0 + nu) / young)
            shortest = min(shortest, RAYLEIGH * wave / (0.1631 * nu + 0.8766))
        both = self.youngs_modulus + self.steel_youngs_modulus
        modulus = self.youngs_modulus * self.steel_youngs_modulus / both / (1.0 - nu**2)
        speed = math.hypot(self.speed, math.sqrt(2.0 * self.gravity * self.start_height))
        impact = (self.mass**2 / (self.radius * modulus**2 * speed)) ** 0.2
        return float(min(shortest, 2.8683 * impact / STEPS_IN_IMPACT))

    @property
    def mass(self) -> float:
        """Return the mass of a grain [kg]."""
        return self.density * 4.0 / 3.0 * math.pi * self.radius**3

    @property
    def steel_mass(self) -> float:
        """Return the mass of the sphere [kg]."""
        return self.steel_density * 4.0 / 3.0 * math.pi * self.steel_radius**3

    @property
    def impact_energy(self) -> float:
        """Return the kinetic energy of the sphere at its release [J]."""
        return 0.5 * self.steel_mass * self.speed**2

    @property
    def every(self) -> int:
        """Return the steps between two rows of the series."""
        return max(1, math.ceil(self.duration / self.step_size / SAMPLES))

    @property
    def settle_steps(self) -> int:
        """Return the steps before the release, a multiple of :attr:`every`."""
        return self.every * math.ceil(self.settle_time / self.step_size / self.every - 1e-9)

    @property
    def steps(self) -> int:
        """Return the steps after the release, a multiple of :attr:`every`."""
        return self.every * math.ceil(self.duration / self.step_size / self.every - 1e-9)

    @property
    def solid_volume(self) -> float:
        """Return the volume of all grains [m3]."""
        return self.grains * 4.0 / 3.0 * math.pi * self.radius**3

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
    derived = {"settle_time", "duration"}
    values: dict[str, Value] = {n: v for n, v in dict(p).items() if n not in derived}
    more = {"settle_steps": p.settle_steps, "steps": p.steps, "series_every": p.every}
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
    return {**values, **more, **box, "damping": "coeff_restitution"}


TEMPLATE = Template(NAME, {"": values_of(Penetration())}, allowed=allowed_in(Penetration))


def largest_elastic_energy(p: Penetration) -> float:
    """Return a bound of the elastic energy of the bed at rest [J].

    Each of six contacts of a grain, counted half, bears the weight of a whole column, as only the
    lowest do. F = 4/3 E* sqrt(R*) overlap^(3/2), E* = E/(2 (1 -
    nu^2)), R* = r/2; a contact holds 2/5 F overlap.
    """
    column = p.grains * (2.0 * p.radius) ** 2 / p.floor_area if p.places else p.layers
    weight = column * p.mass * p.gravity
    stiffness = 2.0 / 3.0 * p.youngs_modulus / (1.0 - p.poisson_ratio**2) * math.sqrt(p.radius / 2)
    overlap = (weight / stiffness) ** (2.0 / 3.0)
    return float(3.0 * p.grains * 0.4 * weight * overlap)


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


SEEDS: Mapping[LevelName, int] = {"quick": 5, "default": 24, "full": 48}
"""Beds of a level."""

EQUIVALENT = ("final_depth_m", "bed_solid_fraction", "bed_coordination")
"""Quantities that codes are held against one another in; the others are shown."""

MARGIN = Tolerance(
    "",
    0.0,
    0.05,
    "stated before any run: codes are equivalent where the 90 % interval of the ratio of their "
    "means is within 5 % of 1, two one-sided tests of 5 %",
)

AT_REST = Tolerance(
    "", 0.01, 0.0, "a bed that moves gives the sphere 1 % of its own energy at most"
)


def no_gain(p: Penetration) -> Tolerance:
    """Return what kinetic and potential energy may gain: what the bed at rest holds in springs."""
    bound = largest_elastic_energy(p) / p.impact_energy
    return Tolerance("", bound, 0.0, "a bound of the elastic energy of the bed under its weight")


JUDGED = ("no energy is gained", "the bed is at rest at the release")


@dataclass(frozen=True)
class Impacts:
    """The impacts of an engine: quantities of each seed, and times [s] and heights [m]."""

    engine: str
    rows: tuple[Mapping[str, float], ...]
    heights: tuple[tuple[NDArray[np.float64], NDArray[np.float64]], ...]

    def sample(self, quantity: str) -> Sample:
        """Return the values of a quantity over the seeds."""
        return Sample(self.engine, tuple(row[quantity] for row in self.rows))


class PenetrationCase(Case[Penetration]):
    """A steel sphere falls on a bed of small spheres: depth, deceleration, energy."""

    name = NAME
    group = "bulk"
    template = TEMPLATE

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
        found = height_quantities(p, output.table(COLUMNS), released)
        mean_height = output.number("mean_height_m")
        surface = 2.0 * mean_height
        work = p.grains * (p.settle_steps + p.steps)
        return {
            **found,
            "final_depth_m": surface + p.steel_radius - found["final_height_m"],
            "bed_solid_fraction": p.solid_volume / (p.floor_area * surface),
            "bed_coordination": output.number("coordination"),
            "bed_kinetic_ratio": output.number("bed_kinetic_J") / impact,
            "microseconds_per_particle_step": 1e6 * output.seconds / work,
        }

    def seconds(self, parameters: Penetration, rules: Traits | None, solver: str = "") -> float:
        """Return what an impact is expected to take [s], good to a factor of three."""
        if rules is None:
            return 0.0
        steps = parameters.settle_steps + parameters.steps
        return PACKED * engine_seconds(steps, parameters.grains, rules)

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return the checks of an engine; the comparison of engines names its own."""
        return [Planned(f"{NAME}: {engine.name}: {check}") for check in JUDGED]

    def verify(self, engine: Engine, study: Study) -> Findings:
        """Run the beds of a level and judge the energy; the worst seed decides."""
        findings = Findings(self.name, engine.name)
        beds = [Penetration(seed=seed) for seed in range(1, SEEDS[study.level] + 1)]
        names = [f"{NAME}: {engine.name}: {check}" for check in JUDGED]
        if reason := engine.refuses(self.job(beds[0])):
            findings.checks += [not_tested(name, Kind.ANALYTIC, reason) for name in names]
            return findings
        rows, heights = [], []
        for bed, output in zip(beds, engine.run([self.job(bed) for bed in beds]), strict=True):
            try:
                if isinstance(output, EngineError):
                    raise output
                rows.append(self.measured(bed, output, engine.traits).values)
                table = output.table(COLUMNS)
                heights.append((table["time_s"], table["z_m"]))
            except EngineError as error:
                name = f"{NAME}: {engine.name}: seed {bed.seed}"
                findings.checks.append(failed_run(name, Kind.ANALYTIC, error))
        if not rows:
            return findings
        findings.evidence = Impacts(engine.title, tuple(rows), tuple(heights))
        findings.checks += judged(names, findings.evidence, beds[0])
        return findings

    def across(self, beside: Mapping[str, Findings]) -> Sequence[Check]:
        """Hold every two engines against one another by their means over the seeds."""
        return list(compared([f.evidence for f in beside.values() if f.evidence is not None]))

    def sections(
        self, main: Findings | None, own: Findings, beside: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the heights over time and the means over the seeds."""
        every = [f.evidence for f in (main, *beside.values()) if f is not None and f.evidence]
        found = list({one.engine: one for one in every}.values())
        if not found:
            return ()
        words = Words(__file__)
        table = words.table("Impacts", list(_means(found)))
        table = replace(table, head=("quantity", *(one.engine for one in found)))
        seeds = len(found[0].rows)
        drawing = words.drawing("penetration-heights", lambda: drawn(found), seeds=seeds)
        return (words.section("penetration", tables=(table,), drawings=(drawing,)),)


def judged(names: Sequence[str], impacts: Impacts, p: Penetration) -> list[Check]:
    """Return the rows of an engine: energy gained and bed at rest, of the worst seed."""
    gain, moves = (
        max(impacts.sample(name).values) for name in ("energy_gain_ratio", "bed_kinetic_ratio")
    )
    return [
        judge(names[0], Kind.ANALYTIC, gain, 0.0, no_gain(p)),
        judge(names[1], Kind.ANALYTIC, moves, 0.0, AT_REST),
    ]


def compared(engines: Sequence[Impacts]) -> Iterator[Check]:
    """Yield the rows that hold every two engines against one another."""
    for one, other in combinations(engines, 2):
        for quantity in EQUIVALENT:
            name = f"{NAME}: {one.engine} against {other.engine}: {quantity}"
            first, second = one.sample(quantity), other.sample(quantity)
            if min(len(first.values), len(second.values)) < FEWEST:
                yield not_tested(name, Kind.CROSS_CODE, f"fewer than {FEWEST} seeds gave a value")
            else:
                yield equivalence(name, first, second, MARGIN)


def _means(engines: Sequence[Impacts]) -> Iterator[tuple[str, ...]]:
    """Yield the rows of the table: a quantity, its mean and interval in each engine."""
    for quantity in PenetrationCase.quantities:
        cells = []
        for one in engines:
            sample = one.sample(quantity.name)
            text = f"{sample.mean:.4g}"
            if len(sample.values) >= FEWEST:
                low, high = interval(sample.values, confidence=0.95)
                text += f" ({low:.4g} to {high:.4g})"
            cells.append(text)
        unit = quantity.unit if quantity.unit != "1" else "-"
        yield f"{quantity.name} ({unit})", *cells


def drawn(engines: Sequence[Impacts]) -> Figure:
    """Draw the sphere's height over time: every seed, a colour for each engine."""
    from matplotlib.figure import Figure

    from harness.report.style import COLOURS

    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    axes = figure.subplots()
    for number, one in enumerate(engines):
        for seed, (t, z) in enumerate(one.heights):
            label = one.engine if seed == 0 else None
            axes.plot(1e3 * t, 1e3 * z, color=COLOURS[number], lw=0.9, alpha=0.7, label=label)
    axes.set(xlabel="time after the release (ms)", ylabel="height of the sphere's centre (mm)")
    axes.legend(title="code; a line for each bed")
    return figure


CASE = PenetrationCase()
