"""A silo with a hopper runs empty, as a case: discharge rate, loads at rest, energy.

The process of Dosta and others, Comput. Phys. Commun. 296, 109066 (2024), smaller and softer. Its
rate is held against Beverloo's law, the load of the bed at rest against Janssen's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field
from scipy.optimize import brentq
from scipy.stats import binomtest

from harness.cases.bulk.energy import ELASTIC, judge_gain, tangential_share
from harness.cases.bulk.materials import (
    BedOfOneKind,
    Radius,
    SteelModulus,
    StepSize,
    YoungsModulus,
    values_of,
)
from harness.cases.bulk.places import PUBLISHED
from harness.cases.bulk.rules import ALLOWED
from harness.cases.bulk.seeds import BulkCase, Curve, Runs, System
from harness.cases.bulk.series import check_grains, check_rows, largest_gain
from harness.cases.contract import LevelName
from harness.comparison.verdicts import Check, Kind, Tolerance, finding, judge
from harness.engines.contract import Job, Output, Template
from harness.engines.traits import Traits
from harness.errors import EngineUndecidedError
from harness.parameters.allowed import allowed_in
from harness.theory.bulk import (
    BEVERLOO_FACTOR,
    BEVERLOO_MARGIN,
    beverloo_scale,
    janssen_share,
)

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from harness.cases.bulk.film import Cut
    from harness.engines.output import Table

    Floats = NDArray[np.float64]

NAME = "silo"
COLUMNS = ("time_s", "remaining", "astray", "kinetic_J", "potential_J")

STEADY = 0.1, 0.6
"""Shares of the grains that have left between which the discharge is steady: after its beginning,
and while the bed is higher than the cone."""

STRESS_RATIO = 0.5
"""K of Janssen's formula; 0.3 to 1 is usual. It is 1 - sin phi (Jaky) for an angle of 30 deg."""


class Silo(BedOfOneKind):
    """A cylinder on a cone, of steel, filled with grains; its orifice is opened."""

    ROWS = 500

    radius: Radius = 2e-3
    youngs_modulus: YoungsModulus = 1e6
    steel_youngs_modulus: SteelModulus = 2.1e8
    silo_radius: float = Field(0.024, gt=0.0, le=10.0, description="[m] of the cylinder")
    orifice_radius: float = Field(0.012, gt=0.0, le=10.0, description="[m] of the orifice")
    cone_height: float = Field(0.012, gt=0.0, le=10.0, description="[m] from orifice to cylinder")
    step_size: StepSize = 4e-5

    def _check_system(self) -> None:
        if self.orifice_radius >= self.silo_radius:
            raise ValueError(
                f"orifice_radius = {self.orifice_radius:g} m: must be less than silo_radius = "
                f"{self.silo_radius:g} m"
            )
        if self.in_layer == 0:
            raise ValueError(
                f"silo_radius = {self.silo_radius:g} m: no grain of radius = {self.radius:g} m "
                "finds room; must be some diameters"
            )

    @property
    def in_layer(self) -> int:
        """Return the sites of a layer: (i + 1/2, j + 1/2) pitches, wherever a grain finds room."""
        reach = self.silo_radius - self.radius * (1.0 + math.sqrt(2.0) * self.scatter)
        most = max(0, math.ceil(reach / self.pitch))
        x = self.pitch * (np.arange(-most, most) + 0.5)
        return int((x[:, None] ** 2 + x**2 <= reach**2).sum()) if reach > 0.0 else 0

    @property
    def grains(self) -> int:
        """Return how many grains there are."""
        return self.layers * self.in_layer

    @property
    def weight(self) -> float:
        """Return the weight of all grains [N]."""
        return self.grains * self.grain.mass * self.gravity

    @property
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves and by the impact of the highest grain."""
        fall = self.layers * self.pitch + self.cone_height
        speed = math.sqrt(2.0 * self.gravity * fall)
        impact = self.grain.impact_step(self.steel_youngs_modulus, speed)
        return min(self.grain.rayleigh_step, impact)

    def volume(self, height: float) -> float:
        """Return the volume within the walls up to a height over the orifice [m3]."""
        return self._moment(height, 0)

    def surface(self, mean_height: float) -> float:
        """Return the height of a level bed over the orifice [m] whose grains have a mean height."""

        def off(height: float) -> float:
            return self._moment(height, 1) / self._moment(height, 0) - mean_height

        return float(brentq(off, 1e-3 * mean_height, 10.0 * mean_height + self.cone_height))

    def _moment(self, height: float, power: int) -> float:
        """Return the integral of z^power over the volume within the walls up to a height."""
        low = min(height, self.cone_height)
        slope = (self.silo_radius - self.orifice_radius) / self.cone_height
        radius = np.polynomial.Polynomial([self.orifice_radius, slope])
        z = np.polynomial.Polynomial([0.0, 1.0]) ** power
        cone = (radius**2 * z).integ()(low)
        shaft = z.integ()(height) - z.integ()(low)
        return math.pi * float(cone + self.silo_radius**2 * shaft)


TEMPLATE = Template(NAME, {"": values_of(Silo())}, allowed=allowed_in(Silo) | ALLOWED)


def largest_elastic_energy(p: Silo) -> float:
    """Return a bound of the elastic energy of the bed at rest [J]."""
    column = p.weight * (2.0 * p.radius) ** 2 / (math.pi * p.silo_radius**2)
    return p.elastic_bound(column)


def discharge(p: Silo, table: Table) -> dict[str, float]:
    """Return rate and times of a series.

    The rate is the slope of a straight line through the number that remains, while the share that
    has left is between the two of :data:`STEADY`. Raise EngineUndecidedError where grains stay.
    """
    after = table["time_s"] > 0.0
    t, remaining = (table[name][after] for name in ("time_s", "remaining"))
    gone = 1.0 - remaining / p.grains
    first, last = STEADY
    if gone[-1] < last:
        stopped = t[remaining == remaining[-1]][0]
        if t[-1] - stopped < 0.1 * p.duration:
            raise EngineUndecidedError(
                f"undecided: {remaining[-1]:.0f} grains of {p.grains} remain and still run out at "
                f"the end; duration = {p.duration:g} s is too short",
                {},
            )
        raise EngineUndecidedError(
            f"undecided: arching: {remaining[-1]:.0f} grains of {p.grains} remain, none has left "
            f"since {stopped:.3g} s; orifice_radius = {p.orifice_radius:g} m is "
            f"{p.orifice_radius / p.radius:.3g} radii of a grain",
            {},
        )
    steady = (gone >= first) & (gone <= last)
    slope = np.polyfit(t[steady], remaining[steady], 1)[0]
    return {
        "discharge_rate_per_s": float(-slope),
        "discharge_rate_kg_per_s": float(-slope) * p.grain.mass,
        "half_time_s": float(t[gone >= 0.5][0]),
        "passed_ratio": float(gone[-1]),
    }


AT_REST = Tolerance("", 0.01, 0.0, "a bed that moves adds 1 % to the energy of the flow at most")


class SiloCase(BulkCase[Silo]):
    """A silo with a hopper runs empty: discharge rate, loads at rest, energy."""

    name = NAME
    template = TEMPLATE
    empties = True
    seeds = {"quick": 4, "default": 16, "full": 24}  # noqa: RUF012
    judged = (
        *("no energy is gained", "the bed is at rest at the opening", "arching"),
        *("Beverloo", "Janssen"),
    )
    equivalent = ("discharge_rate_per_s", "bed_solid_fraction", "bed_coordination")
    drawn = (
        Curve(
            "{system}-discharge",
            "time after the opening (s)",
            "grains that remain",
            ("time_s", "remaining"),
        ),
    )

    def source_of(self, preset: str) -> str:
        """Return where materials and process were published."""
        if preset != "small":
            return "Dosta and others 2024, filled from a lattice: their places are not public"
        return "Dosta and others 2024 (moduli a thousand times smaller, a quarter of the size)"

    @property
    def presets(self) -> Mapping[str, Silo]:
        """Return twelve hundred soft grains, and both silos of 100,000 as published."""
        published = Silo(
            layers=78,
            youngs_modulus=1e9,
            steel_youngs_modulus=2.1e11,
            silo_radius=0.1,
            orifice_radius=0.02,
            cone_height=0.08,
            settle_time=0.5,
            duration=5.0,
            step_size=1.5e-6,
        )
        wide = published.replace(orifice_radius=0.03, cone_height=0.07)
        return {"small": Silo(), PUBLISHED: published, f"{PUBLISHED}-wide": wide}

    def systems(self, level: LevelName) -> Sequence[System]:
        """Return the small silo, and at level full both published ones from four seeds each."""
        if level != "full":
            return super().systems(level)
        published = [
            System(
                f"{self.name}: {name}",
                p,
                {f"seed {seed}": p.replace(seed=seed) for seed in range(1, 5)},
                from_level="full",
            )
            for name, p in self.presets.items()
            if name.startswith(PUBLISHED)
        ]
        return (*super().systems(level), *published)

    def job(self, parameters: Silo) -> Job:
        """Return the job of one discharge."""
        return Job(TEMPLATE, values_of(parameters), sampled=True)

    def read(self, parameters: Silo, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return rate, energies, state and loads of the bed.

        Raise EngineLostAtomsError where a grain passed a wall, EngineUndecidedError for an arch.
        """
        p = parameters
        output.check_numbers({"steps": p.settle_steps + p.steps})
        table = output.table(COLUMNS)
        check_rows(table["time_s"], p.steps * p.step_size, output.who)
        walls = "beyond the walls", "the opening", "they leave a hole, or "
        check_grains(p, output, table, *walls)
        surface = p.surface(output.number("mean_height_m"))
        solid = p.grains * p.grain.volume / p.volume(surface)
        flow = discharge(p, table)
        scale = beverloo_scale(2.0 * p.orifice_radius, 2.0 * p.radius, p.density * solid, p.gravity)
        energy = np.concatenate(
            [[output.number("released_J")], table["kinetic_J"] + table["potential_J"]]
        )
        above = p.weight * output.number("mean_height_m")
        elastic = {ELASTIC: output.number("elastic_J") / above} if output.has("elastic_J") else {}
        steady = slice(*np.searchsorted(-table["remaining"], [-(1 - s) * p.grains for s in STEADY]))
        flowing = table["kinetic_J"][steady].mean()
        loads = [output.number(f"{wall}_N") / p.weight for wall in ("shaft", "cone", "floor")]
        height = max(surface - p.cone_height, 0.0)
        work = p.grains * p.settle_steps + p.every * table["remaining"].sum()
        return {
            **flow,
            "beverloo_factor": flow["discharge_rate_kg_per_s"] / scale if scale else math.nan,
            "energy_rise_ratio": largest_gain(energy) / above,
            **elastic,
            "bed_kinetic_ratio": output.number("bed_kinetic_J") / flowing,
            "bed_height_m": surface,
            "bed_solid_fraction": solid,
            "bed_coordination": output.number("coordination"),
            "shaft_load_ratio": loads[0],
            "walls_load_ratio": sum(loads),
            "janssen_load_ratio": janssen_share(
                height, p.silo_radius, p.steel_friction, STRESS_RATIO
            )
            * (1.0 - p.volume(p.cone_height) / p.volume(surface) if height else 0.0),
            "microseconds_per_particle_step": 1e6 * output.seconds / work,
        }

    def cut(self, p: Silo) -> Cut:
        """Return the silo from the axis, down to two heights of the cone below the orifice."""
        from harness.cases.bulk.film import Cut  # slow to load

        top, bottom = p.layers * p.pitch, -p.cone_height
        radii, heights = (p.silo_radius, p.silo_radius, p.orifice_radius), (top, 0.0, bottom)
        walls = [([side * radius for radius in radii], heights) for side in (-1.0, 1.0)]
        return Cut(0.0, walls, 3.0 * bottom - 2.0 * p.orifice_radius, top)

    def curves(self, p: Silo, output: Output) -> Sequence[tuple[Floats, Floats]]:
        """Return time [s] and the number that remains."""
        table = output.table(COLUMNS)
        return ((table["time_s"], table["remaining"]),)

    def judge(self, names: Sequence[str], runs: Runs, p: Silo) -> list[Check]:
        """Return energy gained and bed at rest, of the worst seed; the others are findings."""
        moves = runs.worst("bed_kinetic_ratio")
        above = p.weight * 0.5 * runs.sample("bed_height_m").mean
        share = tangential_share(max(p.friction, p.steel_friction), p.poisson_ratio)
        bound = largest_elastic_energy(p) / above
        return [
            judge_gain(names[0], runs, "energy_rise_ratio", share, bound),
            judge(names[1], Kind.ANALYTIC, moves, 0.0, AT_REST),
            arching(names[2], runs.undecided, runs.undecided + len(runs.rows)),
            finding(
                names[3],
                runs.sample("beverloo_factor").mean,
                BEVERLOO_FACTOR,
                "",
                f"C of Beverloo's law with k = {BEVERLOO_MARGIN:g}; 0.55 to 0.65 was measured in "
                "silos much wider than their orifice, this one is "
                f"{p.silo_radius / p.orifice_radius:.3g} times as wide",
            ),
            finding(
                names[4],
                runs.sample("shaft_load_ratio").mean,
                runs.sample("janssen_load_ratio").mean,
                "",
                "share of the weight that the cylinder's wall bears before the opening; by Janssen "
                f"with K = {STRESS_RATIO:g} and its friction fully mobilised, which is the most. "
                f"All walls bear {runs.sample('walls_load_ratio').mean:.4g} of the weight",
            ),
        ]


def arching(name: str, arched: int, runs: int) -> Check:
    """Return the share of runs that did not run empty, with its 95 % interval (Wilson)."""
    share = binomtest(arched, runs).proportion_ci(0.95, method="wilson")
    note = f"{arched} of {runs} seeds; 95 % interval {share.low:.3f} to {share.high:.3f}"
    ratio = arched / runs
    half = max(share.high - ratio, ratio - share.low)
    return finding(name, ratio, 0.0, "", note, uncertainty=float(half))


CASE = SiloCase()
