"""The angle of repose of a heap: slopes that remain in a box whose ends are taken away.

The shear box of calibrations (Roessler, Richter, Katterfeld and Will, Powder Technol. 343, 803
(2019)), with both of its ends open: grains run off, and a ridge with two slopes stays in a trough
of glued grains. The sides have no friction unless it is set, so that they bear nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from pydantic import Field

from harness.cases import bulk
from harness.cases.base import Check, Quantity
from harness.cases.bulk import BulkCase, Curve, Plane, Setup, beds
from harness.cases.bulk.beds import BedOfOneKind, Floats, Sphere, lattice_sites
from harness.cases.bulk.comparison import Sample
from harness.engines.base import Output
from harness.engines.output import Table
from harness.errors import EngineUndecidedError
from harness.results.rows import Tolerance

FALL = "over that of the grains after a fall by a diameter"
# a heap at rest: in the last tenth of the time at most 0.5 % of its grains run off. Its mass is
# proportional to the slope, which changes by as much, a tenth of the margin between codes
LATE, FEW = 0.1, 0.005
AT_REST = Tolerance(
    1e-3, reason="less than half a grain in five hundred has the energy of a fall by its diameter"
)


class Heap(BedOfOneKind):
    """Grains on a glued layer in a box of steel, both ends of which are taken away."""

    ROWS = 100
    LEAVING = True

    length: int = Field(18, ge=8, le=1000, description="[-] of the trough, in diameters")
    width: int = Field(6, ge=2, le=1000, description="[-] of the trough, in diameters")
    sill: int = Field(2, ge=0, le=1000, description="[-] glued grains at its ends, one on another")
    layers: beds.Layers = 24
    spacing: beds.Spacing = 1.25
    scatter: beds.Scatter = 0.09
    dispersity: float = Field(
        0.3, ge=0.0, le=1.0, description="[-] range of the diameters over their mean"
    )
    radius: float = Field(2e-3, gt=0.0, description="[m] of a grain: the mean")
    youngs_modulus: beds.YoungsModulus = 4e5
    friction: beds.Friction = 0.5
    rolling_friction: beds.RollingFriction = 0.1
    steel_youngs_modulus: beds.SteelModulus = 8.4e7
    steel_friction: beds.SteelFriction = 0.0
    settle_time: beds.SettleTime = 0.3
    duration: beds.Duration = 1.8
    step_size: beds.StepSize = 5e-5

    def _flaws(self) -> Iterator[str]:
        yield from super()._flaws()
        if self.grains == 0:
            yield (
                f"width = {self.width}: no grain finds room between the sides at spacing = "
                f"{self.spacing:g} diameters"
            )

    @property
    def _room(self) -> float:
        return self.spacing - 1.0 - 0.5 * self.dispersity

    @property
    def span(self) -> float:
        """Return the distance of the ends [m]."""
        return 2.0 * self.radius * self.length

    @property
    def grains(self) -> int:
        """Return the number of grains, without those that are glued."""
        return self.layers * self._sites(1.0, self.length) * self._sites(0.0, self.width)

    def _sites(self, glued: float, size: float) -> int:
        """Return the number of sites with room in a row.

        ``size`` is its length in diameters, of which so many at both ends are ``glued``.
        """
        room = glued + 0.5 * (1.0 + self.scatter + 0.5 * self.dispersity)
        return len(lattice_sites(self.spacing, room, size - room))

    @property
    def weight(self) -> float:
        """Return the weight of all grains [N]; the cube of an even range is 1 + dispersity^2/4."""
        return super().weight * (1.0 + 0.25 * self.dispersity**2)

    @property
    def kinds(self) -> Sequence[Sphere]:
        """Return the smallest grain."""
        return [replace(self.grain, radius=self.radius * (1.0 - 0.5 * self.dispersity))]

    @property
    def fall(self) -> float:
        """Return the height of the filling at first [m]."""
        return self.layers * self.pitch

    @property
    def floor_area(self) -> float:
        """Return the area of the trough [m2]."""
        return self.span * 2.0 * self.radius * self.width


SLIDING = Heap(rolling_friction=0.0)
COMPARED = ("angle_deg", "remaining_ratio")


def _columns_over_sill(p: Heap, columns: int) -> int:
    """Return the columns at an end with their middle over the sill, at least the outermost."""
    return max(1, math.ceil(columns / p.length - 0.5))


def slope_angles(p: Heap, height: Floats) -> tuple[float, float]:
    """Return the angles of the slopes to both ends [deg], positive toward the ends.

    ``height`` (N,) is the mean height of the grains in columns between the ends [m]. A column that
    is filled evenly is twice as high as the mean of its grains. A straight line goes through a half
    without the columns over the sill and that at the ridge, where the surface is rounded.
    """
    half, width = len(height) // 2, p.span / len(height)
    first = _columns_over_sill(p, len(height))
    x = width * np.arange(first, half - 1)
    angles = [
        math.degrees(math.atan(2.0 * np.polyfit(x, side[first : half - 1], 1)[0]))
        for side in (height, height[::-1])
    ]
    return angles[0], angles[1]


def _check_decided(p: Heap, filling: float, table: Table) -> None:
    """Raise EngineUndecidedError for a heap that still moves, or with the top of the filling.

    ``filling`` is the mean height of the grains before the ends are taken away [m].
    """
    late = table["time_s"] >= (1.0 - LATE) * table["time_s"][-1]
    running = table["remaining"][late][0] - table["remaining"][-1]
    last = table["height_m"][-1]
    if running > FEW * table["remaining"][-1]:
        why = (
            f"the heap still moves: {running:.0f} grains ran off in the last {LATE:.0%} of the "
            f"time; duration = {p.duration:g} s is too short"
        )
    elif last[len(last) // 2 - 1 :][:2].mean() > 0.95 * filling:
        why = (
            "no ridge: the heap is as high in the middle as the filling was; "
            f"layers = {p.layers} are too few for length = {p.length}"
        )
    else:
        return
    raise EngineUndecidedError(f"undecided: {why}", {})


class HeapCase(BulkCase[Heap]):
    """Grains run off at both ends of a box: the angle of repose of the heap that remains.

    Grains settle in a trough of glued grains; both ends are taken away, grains run off, and the
    angle of the slopes that remain is measured. Grains start at the same places in each code.
    With resistance to rolling, LAMMPS and LIGGGHTS have different springs of rolling under one
    limit; sliding alone is one law in both.
    """

    name = "heap"
    parameters = Heap
    series = ("time_s", "remaining", "astray", "kinetic_J", "potential_J", "count", "height_m")
    quantities = (
        Quantity("angle_deg", "deg", "angle of repose: mean of both slopes, each of a line through "
                 "twice the mean height of the grains in eight columns", 30.0),
        Quantity("left_angle_deg", "deg", "of the slope toward x = 0", 30.0),
        Quantity("right_angle_deg", "deg", "of the slope toward the other end", 30.0),
        Quantity("angle_change_deg", "deg", "over the last quarter of the time: creep", 0.1),
        Quantity("remaining_ratio", "1", "share of the grains that remain on the glued layer"),
        Quantity("heap_energy_rise_ratio", "1", "largest rise of kinetic and potential energy, "
                 "over the potential energy of the bed above the glued layer", 1e-6),
        Quantity("filling_kinetic_ratio", "1", f"kinetic energy at rest, {FALL}", 1e-3),
        Quantity("heap_kinetic_ratio", "1", f"kinetic energy at the end, {FALL}", 1e-4),
        bulk.WALL_TIME,
    )  # fmt: skip
    presets = {"small": Heap(), "sliding": SLIDING}  # noqa: RUF012
    sources = dict.fromkeys(presets, "shear box of Roessler and others 2019, with both ends open")
    setups = (
        *bulk.seed_setups(Heap(), {"quick": 4, "default": 24, "full": 48}, COMPARED),
        *bulk.seed_setups(SLIDING, {"default": 24, "full": 48}, COMPARED, "sliding alone"),
    )
    curves = (
        Curve("profile", "Height of the heap", "distance_m", "distance from the middle (mm)",
              "height_m", "height of the heap (mm)", (1e3, 1e3)),
        Curve("angle", "Angle of the slopes over time", "time_s",
              "time after the ends are taken away (s)", "angle_deg", "angle (deg)"),
    )  # fmt: skip
    gain, rest = "heap_energy_rise_ratio", "filling_kinetic_ratio"
    rest_scale = "the energy of grains that fall by a diameter"

    def _quantities(self, p: Heap, output: Output, table: Table) -> dict[str, float]:
        bulk.check_grains(p, output, table, "beyond a side or fell through the glued layer")
        mean_height = output.number("mean_height_m")
        _check_decided(p, mean_height, table)
        slopes = slope_angles(p, table["height_m"][-1])
        angle, remaining = self.columns(p, table)["angle_deg"], table["remaining"][-1]
        fall = 2.0 * p.radius * p.grain.mass * p.gravity
        return {
            "angle_deg": 0.5 * sum(slopes),
            "left_angle_deg": slopes[0],
            "right_angle_deg": slopes[1],
            "angle_change_deg": angle[-1] - angle[3 * len(angle) // 4],
            "remaining_ratio": remaining / p.grains,
            "heap_energy_rise_ratio": bulk.energy_rise(output, table) / (p.weight * mean_height),
            "filling_kinetic_ratio": output.number("bed_kinetic_J") / (p.grains * fall),
            "heap_kinetic_ratio": table["kinetic_J"][-1] / (max(remaining, 1.0) * fall),
        }

    def columns(self, p: Heap, table: Table) -> dict[str, Floats]:
        """Return the profile at the end [m], and the mean angle of both slopes [deg] over time [s].

        The profile is without the columns at the ends, whose lower part is the sill.
        """
        heights = table["height_m"]
        columns = heights.shape[1]
        over = _columns_over_sill(p, columns)
        x = p.span * ((np.arange(columns) + 0.5) / columns - 0.5)
        return {
            "distance_m": x[over:-over],
            "height_m": 2.0 * heights[-1, over:-over],
            "time_s": table["time_s"],
            "angle_deg": np.array([np.mean(slope_angles(p, row)) for row in heights]),
        }

    def _plane(self, p: Heap) -> Plane:
        return Plane(p.width * p.radius, [((0.0, p.span), (0.0, 0.0))])

    def _elastic_bound(self, p: Heap, sample: Sample) -> float:
        return p.largest_elastic_energy / (p.weight * 0.5 * p.fall)

    def _more_checks(self, setup: Setup[Heap]) -> Iterator[Check]:
        """Yield bounds of the angle, and whether the heap of the median seed is at rest.

        A grain that still rolls in a heap is no fault of a code, most heaps that do not rest are.
        """
        yield self.bound_check(setup, "angle_deg", *bulk.REPOSE)
        name = "heap_kinetic_ratio"
        yield self.check(setup, name, lambda s: float(np.median(s.values(name))), tolerance=AT_REST)


CASE = HeapCase()
