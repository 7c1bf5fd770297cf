"""A steel sphere falls on a bed of small spheres: depth, deceleration, energy.

The process of Dosta and others, Comput. Phys. Commun. 296, 109066 (2024), two materials and each
pair stated. Beds of other seeds part, so means over seeds are compared, not motions.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np
from pydantic import Field

from harness.cases import bulk
from harness.cases.base import Check, Quantity
from harness.cases.bulk import BulkCase, Curve, Plane, Setup, beds
from harness.cases.bulk.beds import LATTICE, PUBLISHED, BedOfOneKind, Floats, PublishedBed, Sphere
from harness.cases.bulk.comparison import Sample
from harness.engines.base import Output
from harness.engines.base import Value as ScriptValue
from harness.engines.output import Table
from harness.errors import EngineLostAtomsError, EngineOutputError

SERIES = ("time_s", "z_m", "vz_m_per_s", "kinetic_J", "potential_J")
PUBLISHED_BOX = 0.098, 0.06  # [m] along x and y, by the triangles of its walls
PUBLISHED_TOP = 0.03469588430000001  # [m] of the highest grain above the floor
BED = PublishedBed(
    "penetration-25k.txt.xz",
    sizes={"radius": 1e-3},
    counts=(25000,),
    origin=(-0.098 / 2, -0.06 / 2, -0.0902431),
)
# [m] of the sphere over the published bed from its middle, in steps of two diameters of a grain
OFFSETS = (0.0, 4e-3, -4e-3, 8e-3, -8e-3, 12e-3, -12e-3, 16e-3)
OVER = "over the kinetic energy of the sphere at its release"
TURNED = 0.04  # [s] in which the sphere turns back in the published bed, after some 30 ms
FREE = 0.5  # share of the way to the level surface of the bed over which the sphere falls freely
FINAL = 0.1  # share of the time after the release over which the final height is averaged
# bounds of physics
LATE = -2.0, 2.0, "a step is the resolution, and a scheme may write one late"
KEPT = "the sphere keeps its energy; a hundredth is what springs of the bed change, another one a "
KEPT += "bed that settles by a thousandth of its height"
IN_FLIGHT = -0.1, 0.1, KEPT


class Penetration(BedOfOneKind):
    """A bed that settles, and a steel sphere that falls on it. Walls are of steel."""

    ROWS = 600

    places: beds.Places = ""
    along: int = Field(12, ge=2, le=1000, description="[-] grains of the first lattice along x")
    across: int = Field(10, ge=2, le=1000, description="[-] the same along y")
    layers: int = Field(9, ge=1, le=1000, description="[-] the same along z")
    youngs_modulus: beds.YoungsModulus = 1e7
    steel_radius: float = Field(4e-3, gt=0.0, description="[m] of the sphere")
    steel_density: float = Field(7200.0, gt=0.0, description="[kg/m3] of the sphere")
    steel_youngs_modulus: beds.SteelModulus = 2.1e9
    start_height: float = Field(0.026, gt=0.0, description="[m] of the sphere above the floor")
    offset: float = Field(0.0, description="[m] of the sphere from the middle of the box along x")
    speed: float = Field(0.3, gt=0.0, le=100.0, description="[m/s] of the sphere, downward")
    settle_time: beds.SettleTime = 0.12
    duration: beds.Duration = 0.1
    step_size: beds.StepSize = 5e-6

    def _flaws(self) -> Iterator[str]:
        yield from super()._flaws()
        yield from BED.flaws(self, self.places)
        lowest, steel = self.bed_top + self.steel_radius, self.steel_radius
        half_length, half_width = (0.5 * size for size in self.box)
        if self.start_height < lowest:
            yield (
                f"start_height = {self.start_height:g} m: the sphere overlaps the grains at the "
                f"start; must be at least {lowest:.4g}"
            )
        if steel > (most := min(half_length, half_width)):
            words = f"must be at most {most:.4g}, half the width of the box"
            yield f"steel_radius = {steel:g} m: {words}"
        if abs(self.offset) > (most := half_length - steel):
            yield (
                f"offset = {self.offset:g} m: the sphere is in a wall; must be within {most:.4g}"
            )

    @property
    def box(self) -> tuple[float, float]:
        """Return the length of the floor along x and its width along y [m]."""
        if self.places:
            return PUBLISHED_BOX
        return self.along * self.pitch, self.across * self.pitch

    @property
    def bed_top(self) -> float:
        """Return the height of the bed at the start [m]."""
        return PUBLISHED_TOP if self.places else self.layers * self.pitch

    @property
    def grains(self) -> int:
        """Return the number of grains."""
        return BED.counts[0] if self.places else self.along * self.across * self.layers

    @property
    def steel(self) -> Sphere:
        """Return the sphere."""
        young = self.steel_youngs_modulus
        return Sphere(self.steel_radius, self.steel_density, young, self.poisson_ratio)

    @property
    def fall(self) -> float:
        """Return the height of the sphere above the floor [m]: on a wall an impact is shortest."""
        return self.start_height

    @property
    def impact_speed(self) -> float:
        """Return the speed of the sphere at the floor [m/s]."""
        return math.hypot(self.speed, super().impact_speed)

    @property
    def longest_step(self) -> float:
        """Return the longest step [s] by Rayleigh waves, also of the sphere, and by an impact."""
        return min(super().longest_step, self.steel.rayleigh_step)

    @property
    def impact_energy(self) -> float:
        """Return the kinetic energy of the sphere at its release [J]."""
        return 0.5 * self.steel.mass * self.speed**2

    @property
    def floor_area(self) -> float:
        """Return the area of the floor [m2]."""
        return math.prod(self.box)

    @property
    def values(self) -> dict[str, ScriptValue]:
        """Return the values of a script; published places are in a data file."""
        (length, width), rim = self.box, 4.0 * self.radius
        top = self.bed_top + 2.0 * (self.start_height + self.steel_radius)
        ends = (-rim, length + rim), (-rim, width + rim), (-rim, top)
        bed = BED.values(self.kinds, *ends) if self.places else LATTICE
        return {**super().values, **bed, "length": length, "width": width}


PUBLISHED_SYSTEM = Penetration(
    places=PUBLISHED, youngs_modulus=1e9, steel_radius=0.01, steel_youngs_modulus=2.1e11,
    start_height=0.06 - BED.origin[2], speed=5.0, settle_time=0.0, step_size=5e-7,
)  # fmt: skip
COMPARED = ("final_depth_m", "bed_solid_fraction", "bed_coordination")
DEPTHS = ("largest_depth_m", "slowed_time_s")  # of a sphere that has turned back
PUBLISHED_RUNS = tuple(PUBLISHED_SYSTEM.replace(offset=x) for x in OFFSETS)
TIMED = partial(Curve, x="time_s", x_label="time after the release (ms)")
SHORT_RUNS = tuple(p.replace(duration=TURNED) for p in PUBLISHED_RUNS[:4])


class PenetrationCase(BulkCase[Penetration]):
    """A steel sphere falls on a bed of small spheres: depth, deceleration, energy.

    A steel sphere is released above a bed of grains at rest: one of the three bulk processes of
    Dosta and others (2024). Softening by a hundred changes its depth: the small bed is a system
    of its own. Grains start at the same places in each code.
    """

    name = "penetration"
    parameters = Penetration
    series = SERIES
    quantities = (
        Quantity("final_height_m", "m", "of the sphere's centre above the floor, mean over the "
                 "last tenth of the time", 0.01),
        Quantity("lowest_height_m", "m", "of the sphere's centre above the floor", 0.01),
        Quantity("final_depth_m", "m", "of the sphere's lowest point below the surface of the bed, "
                 "twice the mean height of its grains", 0.01),
        Quantity("largest_depth_m", "m", "the same of the sphere at its lowest", 0.01),
        Quantity("slowed_time_s", "s", "until it falls at a tenth of its largest speed", 0.05),
        Quantity("peak_deceleration_m_per_s2", "m/s2", "largest mean between two rows", 100.0),
        Quantity("rebound_speed_m_per_s", "m/s", "largest, upward; 0: none", 0.01),
        Quantity("fall_error_steps", "steps", "largest time by which height or velocity of the "
                 "sphere are off a free fall, half way to the bed"),
        Quantity("flight_loss_ratio", "1",
                 f"loss of kinetic and potential energy until then, {OVER}", 1e-3),
        Quantity("energy_gain_ratio", "1", f"largest gain of kinetic and potential energy, {OVER}"),
        Quantity("dissipated_ratio", "1", f"loss of kinetic and potential energy, {OVER}"),
        Quantity("elastic_ratio", "1", f"elastic energy of normal springs at rest, {OVER}", 0.1),
        Quantity("end_elastic_ratio", "1", f"the same at the end, {OVER}", 0.1),
        Quantity("balance_ratio", "1", f"loss to dashpots and friction, {OVER}"),
        *bulk.BED_STATE,
        Quantity("bed_kinetic_ratio", "1", f"kinetic energy at rest, {OVER}", 1e-3),
        bulk.WALL_TIME,
    )  # fmt: skip
    presets = {"small": Penetration(), PUBLISHED: PUBLISHED_SYSTEM}  # noqa: RUF012
    sources = {  # noqa: RUF012
        "small": "Dosta and others 2024 (moduli a hundred times smaller, smaller box and sphere)",
        PUBLISHED: "Dosta and others 2024, the bed of 25,000",
    }
    setups = (
        *bulk.seed_setups(Penetration(), {"quick": 4, "default": 28, "full": 48}, COMPARED),
        Setup(f"{PUBLISHED}, 4 places, 40 ms", PUBLISHED, SHORT_RUNS, "default", DEPTHS, "full"),
        Setup(f"{PUBLISHED}, 1 place, 100 ms", f"{PUBLISHED}, its whole time", PUBLISHED_RUNS[:1],
              "default", (), "full"),
        Setup(f"{PUBLISHED}, 8 places, 100 ms", PUBLISHED, PUBLISHED_RUNS, "full", DEPTHS, "full"),
    )  # fmt: skip
    curves = (
        TIMED("heights", "Height of the sphere over time", y="height_m",
              y_label="height of its centre (mm)", scale=(1e3, 1e3)),
        TIMED("velocities", "Velocity of the sphere over time", y="velocity_m_per_s",
              y_label="upward velocity (m/s)", scale=(1e3, 1.0)),
        TIMED("decelerations", "Deceleration of the sphere over time", y="deceleration_m_per_s2",
              y_label="deceleration (m/s2)", scale=(1e3, 1.0)),
    )  # fmt: skip
    gain = "energy_gain_ratio"
    rest_scale = "the energy of the sphere"

    def _quantities(self, p: Penetration, output: Output, table: Table) -> dict[str, float]:
        output.check_numbers({"grains": p.grains})
        if output.number("outside") != 0.0:
            raise EngineLostAtomsError(
                f"{output.engine}: a particle passed a wall at step_size = {p.step_size:g} s, "
                f"youngs_modulus = {p.youngs_modulus:g} Pa"
            )
        after = table["time_s"] > 0.0  # some codes also leave a row of the release itself
        t, z, v, kinetic, potential = (table[name][after] for name in SERIES)
        lowest, fastest = int(np.argmin(z)), int(np.argmin(v))
        slow = v[fastest:] > 0.1 * v[fastest]
        if not slow.any():
            raise EngineOutputError(
                f"duration = {p.duration:g} s: the sphere still falls at a tenth of its largest "
                "speed"
            )
        energy, moving, scale = kinetic + potential, output.number("bed_kinetic_J"), p.impact_energy
        released = moving + output.number("release_potential_J") + scale
        dissipated = float((released - energy[-1]) / scale)
        final = float(z[t >= t[-1] - FINAL * (t[-1] - t[0])].mean())
        surface = 2.0 * output.number("mean_height_m")
        values = {
            "final_height_m": final,
            "lowest_height_m": float(z[lowest]),
            "final_depth_m": surface + p.steel_radius - final,
            "largest_depth_m": surface + p.steel_radius - float(z[lowest]),
            "slowed_time_s": float(t[fastest:][slow][0]),
            "peak_deceleration_m_per_s2": float((np.diff(v) / np.diff(t)).max()),
            "rebound_speed_m_per_s": float(max(0.0, v[lowest:].max())),
            "energy_gain_ratio": float(max(0.0, (energy - released).max()) / scale),
            "dissipated_ratio": dissipated,
            "bed_solid_fraction": p.grains * p.grain.volume / (p.floor_area * surface),
            "bed_coordination": output.number("coordination"),
            "bed_kinetic_ratio": moving / scale,
        }
        height = p.start_height - p.steel_radius - surface
        flies = np.logical_and.accumulate(p.start_height - z < FREE * height)
        if flies.any():
            values["fall_error_steps"] = _fall_error(p, t[flies], z[flies], v[flies])
            values["flight_loss_ratio"] = float((released - energy[flies][-1]) / scale)
        if output.has("elastic_J"):  # of the normal springs
            first, end = (output.number(name) / scale for name in ("elastic_J", "end_elastic_J"))
            values |= {"elastic_ratio": first, "end_elastic_ratio": end}
            values["balance_ratio"] = dissipated + (first - end)
        return values

    def columns(self, p: Penetration, table: Table) -> dict[str, Floats]:
        """Return height [m], velocity [m/s] and deceleration [m/s2] of the sphere over time [s].

        A deceleration is the mean over the time from the row before to the row after.
        """
        t, z, v = (table[name] for name in SERIES[:3])
        rate = np.gradient(v, t)
        return {"time_s": t, "height_m": z, "velocity_m_per_s": v, "deceleration_m_per_s2": rate}

    def _more_checks(self, setup: Setup[Penetration]) -> Iterator[Check]:
        """Yield that the sphere falls freely before it meets the bed, and keeps its energy."""
        yield self.bound_check(setup, "fall_error_steps", *LATE)
        yield self.bound_check(setup, "flight_loss_ratio", *IN_FLIGHT)

    def _plane(self, p: Penetration) -> Plane:
        (length, width), top = p.box, p.start_height + 2.0 * p.steel_radius
        return Plane(0.5 * width, [((0.0, 0.0, length, length), (top, 0.0, 0.0, top))])

    def _elastic_bound(self, p: Penetration, sample: Sample) -> float:
        return p.largest_elastic_energy / p.impact_energy


def _fall_error(p: Penetration, t: Floats, z: Floats, v: Floats) -> float:
    """Return the largest error of heights and velocities (M,) of a free fall [steps]."""
    speed = p.speed + p.gravity * t
    height = p.start_height - 0.5 * (p.speed + speed) * t
    late = np.abs(z - height) / speed, np.abs(v + speed) / p.gravity
    return float(np.max(late) / p.step_size)


CASE = PenetrationCase()
