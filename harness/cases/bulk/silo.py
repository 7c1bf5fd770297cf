"""A silo with a hopper runs empty: discharge rate, loads at rest, energy.

The process of Dosta and others, Comput. Phys. Commun. 296, 109066 (2024), smaller and softer. Its
rate is compared with Beverloo's law, the load of the bed at rest with Janssen's.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial

import numpy as np
from pydantic import Field

from harness.cases import bulk
from harness.cases.base import Check, Quantity, Value
from harness.cases.bulk import BulkCase, Curve, Plane, Setup, beds
from harness.cases.bulk.beds import PUBLISHED, BedOfOneKind, Floats, lattice_sites, level_bed
from harness.cases.bulk.comparison import Sample
from harness.engines.base import Output
from harness.engines.output import Table
from harness.errors import EngineUndecidedError
from harness.results.rows import Kind

# shares of the grains that have left between which the discharge is steady: after its beginning,
# and while the bed is higher than the cone
STEADY = 0.1, 0.6
ABOVE = "over the potential energy of the bed above the orifice"
BEVERLOO_FACTOR = 0.58  # C of Beverloo's law; 0.55 to 0.65 was measured
BEVERLOO_MARGIN = 1.5  # [diameters] k of the law: what an orifice loses; 1.2 to 3 was measured
STRESS_RATIO = 0.5  # K of Janssen's formula; 1 - sin phi (Jaky) for an angle of 30 deg


class Silo(BedOfOneKind):
    """A cylinder on a cone, of steel, filled with grains; its orifice is opened."""

    ROWS = 500
    LEAVING = True

    radius: beds.Radius = 2e-3
    youngs_modulus: beds.YoungsModulus = 1e6
    steel_youngs_modulus: beds.SteelModulus = 2.1e8
    silo_radius: float = Field(0.024, gt=0.0, le=10.0, description="[m] of the cylinder")
    orifice_radius: float = Field(0.012, gt=0.0, le=10.0, description="[m] of the orifice")
    cone_height: float = Field(0.012, gt=0.0, le=10.0, description="[m] from orifice to cylinder")
    step_size: beds.StepSize = 4e-5

    def _flaws(self) -> Iterator[str]:
        yield from super()._flaws()
        if self.orifice_radius >= self.silo_radius:
            yield (
                f"orifice_radius = {self.orifice_radius:g} m: must be less than silo_radius = "
                f"{self.silo_radius:g} m"
            )
        if self.grains == 0:
            yield (
                f"silo_radius = {self.silo_radius:g} m: no grain of radius = {self.radius:g} m "
                "finds room; must be some diameters"
            )

    @property
    def grains(self) -> int:
        """Return the number of grains: in each layer the sites with room."""
        reach = self.silo_radius - self.radius * (1.0 + math.sqrt(2.0) * self.scatter)
        x = lattice_sites(self.pitch, -reach, reach)
        return self.layers * int((x[:, None] ** 2 + x**2 <= reach**2).sum())

    @property
    def fall(self) -> float:
        """Return the height of the highest grain above the orifice [m]."""
        return self.layers * self.pitch + self.cone_height

    @property
    def floor_area(self) -> float:
        """Return the area of the cylinder [m2]."""
        return math.pi * self.silo_radius**2

    def section(self, height: float) -> float:
        """Return the area [m2] between the walls at a height over the orifice [m]."""
        low, high = self.orifice_radius, self.silo_radius
        # np.interp takes seven times as long for a number, and an integral asks for thousands
        slope = (high - low) / self.cone_height
        return math.pi * (slope * height + low if height < self.cone_height else high) ** 2

    @property
    def cone_volume(self) -> float:
        """Return the volume of the cone [m3]."""
        low, high = self.orifice_radius, self.silo_radius
        return math.pi / 3.0 * self.cone_height * (low**2 + low * high + high**2)


PUBLISHED_SILO = Silo(
    layers=78, youngs_modulus=1e9, steel_youngs_modulus=2.1e11, silo_radius=0.1,
    orifice_radius=0.02, cone_height=0.08, settle_time=0.5, duration=5.0, step_size=1.5e-6,
)  # fmt: skip
WIDE = f"{PUBLISHED}-wide"
WIDE_SILO = PUBLISHED_SILO.replace(orifice_radius=0.03, cone_height=0.07)
COMPARED = ("discharge_rate_per_s", "bed_solid_fraction", "bed_coordination")


# ---- scales that are known


def beverloo_scale(orifice: float, grain: float, bulk_density: float, gravity: float) -> float:
    """Return rho_b sqrt(g) (D - k d)^(5/2) [kg/s]: C times it is the discharge rate.

    ``orifice`` D and ``grain`` d are diameters [m], ``bulk_density`` [kg/m3], ``gravity`` [m/s2];
    0 where nothing passes. Beverloo, Leniger and van de Velde, Chem. Eng. Sci. 15, 260 (1961).
    """
    free = max(orifice - BEVERLOO_MARGIN * grain, 0.0)
    return float(bulk_density * math.sqrt(gravity) * free**2.5)


def janssen_share(height: float, radius: float, friction: float, ratio: float) -> float:
    """Return the share of the weight in an upright cylinder that its walls bear.

    ``height`` of the grains and ``radius`` [m], ``friction`` of the wall, fully mobilised, and
    ``ratio`` K of horizontal to vertical stress: 1 - (1 - exp(-x))/x with x = 2 mu K h/R.
    Janssen, Z. Ver. Dtsch. Ing. 39, 1045 (1895).
    """
    x = 2.0 * friction * ratio * height / radius
    return 1.0 + math.expm1(-x) / x if x > 0.0 else 0.0


# ---- a run


def _discharge(p: Silo, table: Table) -> dict[str, float]:
    """Return rate and times; the rate is the slope of a line through the number that remains."""
    after = table["time_s"] > 0.0
    t, remaining = (table[name][after] for name in ("time_s", "remaining"))
    gone = 1.0 - remaining / p.grains
    if gone[-1] < STEADY[1]:
        last = t[remaining == remaining[-1]][0]
        raise EngineUndecidedError(
            f"undecided: arching, or duration = {p.duration:g} s is too short: {remaining[-1]:.0f} "
            f"grains of {p.grains} remain, the last one left at {last:.3g} s; orifice_radius = "
            f"{p.orifice_radius:g} m is {p.orifice_radius / p.radius:.3g} radii of a grain",
            {},
        )
    steady = (gone >= STEADY[0]) & (gone <= STEADY[1])
    rate = -float(np.polyfit(t[steady], remaining[steady], 1)[0])
    return {
        "discharge_rate_per_s": rate,
        "discharge_rate_kg_per_s": rate * p.grain.mass,
        "half_time_s": float(t[gone >= 0.5][0]),
        "passed_ratio": float(gone[-1]),
    }


def _loads(p: Silo, output: Output, surface: float, volume: float) -> dict[str, float]:
    """Return loads of the walls over the weight; ``surface`` [m], ``volume`` [m3] of the bed."""
    shaft, cone, floor = (output.number(f"{w}_N") / p.weight for w in ("shaft", "cone", "floor"))
    height = max(surface - p.cone_height, 0.0)
    share = janssen_share(height, p.silo_radius, p.steel_friction, STRESS_RATIO)
    in_cylinder = 1.0 - p.cone_volume / volume if height else 0.0
    return {
        "shaft_load_ratio": shaft,
        "walls_load_ratio": shaft + cone + floor,
        "janssen_load_ratio": share * in_cylinder,
    }


def _arching_share(sample: Sample) -> Value:
    """Return the share of runs without a rate, with its 95 % interval (Wilson)."""
    from scipy.stats import binomtest

    arched, runs = len(sample.undecided), len(sample.undecided) + len(sample.rows)
    share = binomtest(arched, runs).proportion_ci(0.95, method="wilson")
    ratio = arched / runs
    note = f"{arched} of {runs} seeds; 95 % interval {share.low:.3f} to {share.high:.3f}"
    return Value(ratio, float(max(share.high - ratio, ratio - share.low)), note)


class SiloCase(BulkCase[Silo]):
    """A silo with a hopper runs empty: discharge rate, loads at rest, energy.

    Grains settle in a cylinder on a cone of steel whose orifice is closed; it is opened, and
    the number that remains is counted: one of the three bulk processes of Dosta and others
    (2024). Grains start at the same places in each code.
    """

    name = "silo"
    parameters = Silo
    series = ("time_s", "remaining", "astray", "kinetic_J", "potential_J")
    quantities = (
        Quantity("discharge_rate_per_s", "1/s", "slope of the number that remains, while 10 % to "
                 "60 % have left", 1e3),
        Quantity("discharge_rate_kg_per_s", "kg/s", "the same times the mass of a grain", 0.1),
        Quantity("beverloo_factor", "1", "C of Beverloo's law W = C rho_b sqrt(g) (D - k d)^(5/2) "
                 "with k = 1.5; about 0.58 is expected of wide silos", 0.5),
        Quantity("half_time_s", "s", "from the opening until half of the grains have left", 0.3),
        Quantity("passed_ratio", "1", "share of the grains that have left at the end"),
        Quantity("energy_rise_ratio", "1", f"largest rise of kinetic and potential energy, {ABOVE}",
                 1e-6),
        Quantity("elastic_ratio", "1", f"elastic energy of normal springs at rest, {ABOVE}", 1e-3),
        Quantity("bed_kinetic_ratio", "1", "kinetic energy at rest, over that of the flow", 1e-3),
        Quantity("bed_height_m", "m", "of a level bed of the same mean height", 0.03),
        *bulk.BED_STATE,
        Quantity("shaft_load_ratio", "1", "upward force of the cylinder at rest, over the weight",
                 0.1),
        Quantity("walls_load_ratio", "1", "of cylinder, cone and floor, likewise"),
        Quantity("janssen_load_ratio", "1", "the cylinder's share by Janssen's formula, wall "
                 "friction fully mobilised and K = 0.5: the most that is expected", 0.1),
        bulk.WALL_TIME,
    )  # fmt: skip
    presets = {"small": Silo(), PUBLISHED: PUBLISHED_SILO, WIDE: WIDE_SILO}  # noqa: RUF012
    sources = {  # noqa: RUF012
        "small": "Dosta and others 2024 (moduli a thousand times smaller, a quarter of the size)",
        **dict.fromkeys(
            (PUBLISHED, WIDE),
            "Dosta and others 2024, filled from a lattice: their places are not public",
        ),
    }
    setups = (
        *bulk.seed_setups(Silo(), {"quick": 4, "default": 16, "full": 24}, COMPARED),
        *bulk.seed_setups(PUBLISHED_SILO, {"full": 4}, COMPARED, PUBLISHED),
        *bulk.seed_setups(WIDE_SILO, {"full": 4}, COMPARED, WIDE),
    )
    curves = (
        Curve("discharge", "Grains that remain over time", "time_s", "time after the opening (s)",
              "remaining", "grains that remain"),
    )  # fmt: skip
    gain = "energy_rise_ratio"
    rest_scale = "the energy of the flow"

    def _quantities(self, p: Silo, output: Output, table: Table) -> dict[str, float]:
        bulk.check_grains(p, output, table, "beyond the walls")
        flow, mean_height = _discharge(p, table), output.number("mean_height_m")
        surface, volume = level_bed(p.section, 0.0, 10.0 * mean_height + p.cone_height, mean_height)
        solid = p.grains * p.grain.volume / volume
        scale = beverloo_scale(2.0 * p.orifice_radius, 2.0 * p.radius, p.density * solid, p.gravity)
        above = p.weight * mean_height
        steady = slice(*np.searchsorted(-table["remaining"], [-(1 - s) * p.grains for s in STEADY]))
        quantities = {
            **flow,
            "beverloo_factor": flow["discharge_rate_kg_per_s"] / scale if scale else math.nan,
            "energy_rise_ratio": bulk.energy_rise(output, table) / above,
            "bed_kinetic_ratio": output.number("bed_kinetic_J") / table["kinetic_J"][steady].mean(),
            "bed_height_m": surface,
            "bed_solid_fraction": solid,
            "bed_coordination": output.number("coordination"),
            **_loads(p, output, surface, volume),
        }
        if output.has("elastic_J"):
            quantities["elastic_ratio"] = output.number("elastic_J") / above
        return quantities

    def columns(self, p: Silo, table: Table) -> dict[str, Floats]:
        """Return time [s] and the number that remains."""
        return {name: table[name] for name in ("time_s", "remaining")}

    def _plane(self, p: Silo) -> Plane:
        radii = np.array([p.silo_radius, p.silo_radius, p.orifice_radius])
        heights = (p.layers * p.pitch, 0.0, -p.cone_height)
        return Plane(0.0, [(-radii, heights), (radii, heights)])

    def _elastic_bound(self, p: Silo, sample: Sample) -> float:
        return p.largest_elastic_energy / (0.5 * p.weight * sample.mean("bed_height_m"))

    def _more_checks(self, setup: Setup[Silo]) -> Iterator[Check]:
        """Yield arching, Beverloo's factor and Janssen's load, all findings."""
        p, finding = setup.runs[0], partial(self.check, setup, kind=Kind.FINDING)
        yield Check(
            setup=setup.name, quantity="arching", unit="1", kind=Kind.FINDING, expected=0.0,
            measure=lambda bench: _arching_share(self.sample(bench, setup)),
        )  # fmt: skip
        yield finding(
            "beverloo_factor", lambda s: s.mean_value("beverloo_factor"), BEVERLOO_FACTOR,
            note=f"C of Beverloo's law with k = {BEVERLOO_MARGIN:g}; 0.55 to 0.65 was measured in "
            "silos much wider than their orifice, this one is "
            f"{p.silo_radius / p.orifice_radius:.3g} times as wide",
        )  # fmt: skip
        yield finding(
            "shaft_load_ratio", _shaft_load, lambda s: s.mean("janssen_load_ratio"),
            note=f"expected by Janssen with K = {STRESS_RATIO:g} and friction fully mobilised, "
            "which is the most",
        )  # fmt: skip


def _shaft_load(sample: Sample) -> Value:
    note = f"all walls bear {sample.mean('walls_load_ratio'):.4g} of the weight"
    return sample.mean_value("shaft_load_ratio", note)


CASE = SiloCase()
