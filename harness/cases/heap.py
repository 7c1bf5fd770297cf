"""The angle of repose of a heap, as a case: slopes that remain in a box whose ends are taken away.

The shear box of calibrations (Roessler, Richter, Katterfeld and Will, Powder Technol. 343, 803
(2019)), with both of its ends open: grains run off, and a ridge with two slopes stays in a trough
of glued grains. The sides have no friction unless it is set, so that they bear nothing.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from harness.cases.bulk.energy import judge_gain, tangential_share
from harness.cases.bulk.materials import (
    BedOfOneKind,
    Duration,
    Friction,
    Layers,
    RollingFriction,
    Scatter,
    SettleTime,
    Spacing,
    SteelFriction,
    SteelModulus,
    StepSize,
    YoungsModulus,
    values_of,
)
from harness.cases.bulk.rules import ALLOWED, NEUTRAL, Law, law_of
from harness.cases.bulk.seeds import BulkCase, Curve, Runs, System
from harness.cases.bulk.series import check_grains, largest_gain
from harness.comparison.verdicts import Check, Kind, Tolerance, judge
from harness.engines.contract import Job, Output, Template
from harness.engines.traits import Traits
from harness.errors import EngineUndecidedError
from harness.parameters.allowed import allowed_in

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from harness.cases.bulk.film import Cut
    from harness.cases.contract import LevelName
    from harness.engines.output import Table

    Floats = NDArray[np.float64]

NAME = "heap"
COLUMNS = ("time_s", "remaining", "astray", "kinetic_J", "potential_J", "count", "height_m")

LATE, FEW = 0.1, 0.005
"""Of a heap that has come to rest, in so much of the time at its end at most so many grains of
those that remain run off: the heap's mass is proportional to the slope, which changes by as much,
a tenth of the margin between codes."""


class Heap(BedOfOneKind):
    """Grains on a glued layer in a box of steel, both ends of which are taken away."""

    ROWS = 100

    length: int = Field(18, ge=8, le=1000, description="[-] of the trough, in diameters")
    width: int = Field(6, ge=2, le=1000, description="[-] of the trough, in diameters")
    sill: int = Field(2, ge=0, le=1000, description="[-] glued grains at its ends, one on another")
    layers: Layers = 24
    spacing: Spacing = 1.25
    scatter: Scatter = 0.09
    dispersity: float = Field(
        0.3, ge=0.0, le=1.0, description="[-] range of the diameters over their mean"
    )
    radius: float = Field(2e-3, gt=0.0, description="[m] of a grain: the mean")
    youngs_modulus: YoungsModulus = 4e5
    friction: Friction = 0.5
    rolling_friction: RollingFriction = 0.1
    steel_youngs_modulus: SteelModulus = 8.4e7
    steel_friction: SteelFriction = 0.0
    settle_time: SettleTime = 0.3
    duration: Duration = 1.8
    step_size: StepSize = 5e-5

    def _check_system(self) -> None:
        if self.grains == 0:
            raise ValueError(
                f"width = {self.width}: no grain finds room between the sides at spacing = "
                f"{self.spacing:g} diameters"
            )

    def _room(self) -> tuple[str, float]:
        """Return the room between two of the largest grains."""
        return "spacing - 1 - dispersity/2", self.spacing - 1.0 - 0.5 * self.dispersity

    @property
    def span(self) -> float:
        """Return the distance of the ends [m]."""
        return 2.0 * self.radius * self.length

    @property
    def reach(self) -> float:
        """Return the distance of an end from the middle [m]."""
        return 0.5 * self.span

    @property
    def grains(self) -> int:
        """Return how many grains there are, without those that are glued."""
        return self.layers * self._sites(1.0, self.length) * self._sites(0.0, self.width)

    def _sites(self, glued: float, size: float) -> int:
        """Return how many sites (i + 1/2) pitches have room in a row.

        ``size`` is its length in diameters, of which so many at both ends are ``glued``.
        """
        room = glued + 0.5 * (1.0 + self.scatter + 0.5 * self.dispersity)
        site = self.spacing * (np.arange(math.ceil(size / self.spacing)) + 0.5)
        return int(((site >= room) & (site <= size - room)).sum())

    @property
    def weight(self) -> float:
        """Return the weight of all grains [N]; the cube of an even range is 1 + dispersity^2/4."""
        mass = self.grain.mass * (1.0 + 0.25 * self.dispersity**2)
        return self.grains * mass * self.gravity

    @property
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves and by the impact of the highest grain."""
        speed = math.sqrt(2.0 * self.gravity * self.layers * self.pitch)
        smallest = replace(self.grain, radius=self.radius * (1.0 - 0.5 * self.dispersity))
        impact = smallest.impact_step(self.steel_youngs_modulus, speed)
        return min(smallest.rayleigh_step, impact)


TEMPLATE = Template(
    NAME, {"": values_of(Heap())}, allowed=allowed_in(Heap) | ALLOWED, neutral=NEUTRAL
)


def largest_elastic_energy(p: Heap) -> float:
    """Return a bound of the elastic energy of the bed at rest [J]."""
    return p.elastic_bound(p.layers * p.grain.mass * p.gravity)


def over_sill(p: Heap, columns: int) -> int:
    """Return how many columns at an end have their middle over the sill, at least the outermost."""
    return max(1, math.ceil(columns / p.length - 0.5))


def slope_angles(p: Heap, height: Floats) -> tuple[float, float]:
    """Return the angles of the slopes to the left and right end [deg], positive toward the ends.

    ``height`` (N,) is the mean height of the grains in columns between the ends [m]. A column that
    is filled evenly is twice as high as the mean of its grains. A straight line goes through a half
    without the columns over the sill and that at the ridge, where the surface is rounded.
    """
    half, width, first = len(height) // 2, p.span / len(height), over_sill(p, len(height))
    x = width * np.arange(first, half - 1)
    sides = height[first : half - 1], height[::-1][first : half - 1]
    left, right = (math.degrees(math.atan(2.0 * np.polyfit(x, side, 1)[0])) for side in sides)
    return left, right


def angles(p: Heap, table: Table) -> Floats:
    """Return the mean angle of both slopes [deg] over time, (M,)."""
    return np.array([np.mean(slope_angles(p, row)) for row in table["height_m"]])


def check_decided(p: Heap, ridge: float, table: Table) -> None:
    """Raise EngineUndecidedError for a heap that still moves, or whose top has not been reached.

    ``ridge`` is the mean height of the grains before the ends are taken away [m].
    """
    late = table["time_s"] >= (1.0 - LATE) * table["time_s"][-1]
    running = table["remaining"][late][0] - table["remaining"][-1]
    if running > FEW * table["remaining"][-1]:
        raise EngineUndecidedError(
            f"undecided: the heap still moves: {running:.0f} grains ran off in the last "
            f"{LATE:.0%} of the time; duration = {p.duration:g} s is too short",
            {},
        )
    middle = len(table["height_m"][-1]) // 2
    if table["height_m"][-1, middle - 1 : middle + 1].mean() > 0.95 * ridge:
        raise EngineUndecidedError(
            "undecided: no ridge: the heap is as high in the middle as the filling was; "
            f"layers = {p.layers} are too few for length = {p.length}",
            {},
        )


BED_AT_REST = Tolerance(
    "", 0.01, 0.0, "a bed that moves adds 1 % to the energy of grains that fall by a diameter"
)
AT_REST = Tolerance(
    "",
    1e-3,
    0.0,
    "less than half a grain in five hundred that has the energy of a fall by its diameter",
)


class HeapCase(BulkCase[Heap]):
    """Grains run off at both ends of a box: the angle of repose of the heap that remains."""

    name = NAME
    template = TEMPLATE
    empties = True
    seeds = {"quick": 4, "default": 24, "full": 48}  # noqa: RUF012
    judged = ("no energy is gained", "the bed is at rest", "the heap is at rest at the end")
    equivalent = ("angle_deg", "remaining_ratio")
    drawn = (
        Curve(
            "{system}-profile",
            "distance from the middle (mm)",
            "height of the heap (mm)",
            ("distance_m", "height_m"),
            scale=(1e3, 1e3),
        ),
        Curve(
            "{system}-angle",
            "time after the ends are taken away (s)",
            "angle (deg)",
            ("time_s", "angle_deg"),
        ),
    )

    def source_of(self, preset: str) -> str:
        """Return where the process was published."""
        return "shear box of Roessler and others 2019, with both ends open"

    @property
    def presets(self) -> Mapping[str, Heap]:
        """Return twelve hundred soft grains, with and without rolling resistance."""
        return {"small": Heap(), "sliding": Heap(rolling_friction=0.0)}

    def job(self, parameters: Heap) -> Job:
        """Return the job of one heap."""
        return Job(TEMPLATE, values_of(parameters), sampled=True)

    def read(self, parameters: Heap, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return the angle, what remains, energies.

        Raise EngineLostAtomsError where a grain passed a side or the glued layer,
        EngineUndecidedError for a heap that still moves.
        """
        p = parameters
        output.check_numbers({"steps": p.settle_steps + p.steps})
        table = output.table(COLUMNS)
        sides = "beyond a side or fell through the glued layer", "the ends were taken away"
        check_grains(p, output, table, *sides)
        mean_height = output.number("mean_height_m")
        check_decided(p, mean_height, table)
        left, right = slope_angles(p, table["height_m"][-1])
        over_time = angles(p, table)
        energy = np.concatenate(
            [[output.number("released_J")], table["kinetic_J"] + table["potential_J"]]
        )
        fall = 2.0 * p.radius * p.grain.mass * p.gravity
        remaining = table["remaining"][-1]
        work = p.grains * p.settle_steps + p.every * table["remaining"].sum()
        return {
            "angle_deg": 0.5 * (left + right),
            "left_angle_deg": left,
            "right_angle_deg": right,
            "angle_change_deg": over_time[-1] - over_time[3 * len(over_time) // 4],
            "remaining_ratio": remaining / p.grains,
            "heap_energy_rise_ratio": largest_gain(energy) / (p.weight * mean_height),
            "filling_kinetic_ratio": output.number("bed_kinetic_J") / (p.grains * fall),
            "heap_kinetic_ratio": table["kinetic_J"][-1] / (max(remaining, 1.0) * fall),
            "microseconds_per_particle_step": 1e6 * output.seconds / work,
        }

    def cut(self, p: Heap) -> Cut:
        """Return the trough along its middle."""
        from harness.cases.bulk.film import Cut  # slow to load

        size = 2.0 * p.radius
        wall = ([0.0, p.span], [0.0, 0.0])
        return Cut(0.5 * p.width * size, [wall], -6.0 * size, p.layers * p.pitch)

    def systems(self, level: LevelName) -> Sequence[System]:
        """Return heaps with resistance to rolling, and, but at level quick, without."""
        sliding = System(f"{self.name}: sliding alone", self.presets["sliding"])
        return super().systems(level) if level == "quick" else (*super().systems(level), sliding)

    def law(self, traits: Traits, parameters: Heap) -> Law:
        """Return by which rules an engine follows the law, those of rolling included."""
        return law_of(traits, parameters.rolling_friction)

    def curves(self, p: Heap, output: Output) -> Sequence[tuple[Floats, Floats]]:
        """Return the profile at the end [m], and the angle [deg] over time [s].

        Without the columns at the ends, whose lower part is the sill.
        """
        table = output.table(COLUMNS)
        height = 2.0 * table["height_m"][-1]
        columns = len(height)
        x = p.span * ((np.arange(columns) + 0.5) / columns - 0.5)
        over = over_sill(p, columns)
        return (x[over:-over], height[over:-over]), (table["time_s"], angles(p, table))

    def judge(self, names: Sequence[str], runs: Runs, p: Heap) -> list[Check]:
        """Return energy gained and bed at rest, of the worst seed, and the heap of the median seed.

        A grain that still rolls in a heap is no fault of a code, most heaps that do not rest are.
        """
        above = p.weight * 0.5 * p.layers * p.pitch
        share = tangential_share(max(p.friction, p.steel_friction), p.poisson_ratio)
        bound = largest_elastic_energy(p) / above
        at_end = float(np.median(runs.sample("heap_kinetic_ratio").values))
        bed = runs.worst("filling_kinetic_ratio")
        return [
            judge_gain(names[0], runs, "heap_energy_rise_ratio", share, bound),
            judge(names[1], Kind.ANALYTIC, bed, 0.0, BED_AT_REST),
            judge(names[2], Kind.ANALYTIC, at_end, 0.0, AT_REST),
        ]


CASE = HeapCase()
