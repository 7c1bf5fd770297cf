"""The measurement of a steady flow of layers: blocks, slices over the height, means, profiles."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from pydantic import Field

from harness.cases.layers.packing import PREPARED, Floats, Packing, check_base, middle_half
from harness.engines.output import Output
from harness.errors import EngineOutputError, EngineUndecidedError

SLICE = 0.25  # [d] height of a slice
WINDOW = 4  # slices over which profiles are averaged: a diameter, as grains stand in layers
GRAIN_DENSITY = 6.0 / math.pi  # [m/d^3] of a grain
CONFIDENT = 0.99  # of the interval of a drift: one steady flow of a hundred is called unsteady
SUMS = ("count", "volume", "mass", "momentum", "mxx", "myy", "mzz", "mxz",
        "virial_xx", "virial_yy", "virial_zz", "virial_xz")  # of a slice, in a script  # fmt: skip
UNCERTAIN = ("solid_fraction", "velocity", "granular_temperature", "shear_rate", "normal_stress",
             "shear_stress", "mu", "inertial_number")  # fmt: skip
OF_MIDDLE = ("solid_fraction", "granular_temperature", "normal_stress")


class Flow(Packing):
    """Layers at one angle: how long they settle and are measured, and in how many blocks."""

    # fmt: off
    length: int = Field(10, ge=2, le=10000, description="[d] of the box along the flow")
    width: int = Field(
        5, ge=1, le=10000, description="[d] of the box across; 1: all spheres in one plane")
    angle: float = Field(14.0, gt=0.0, le=45.0, description="[deg] of the base")
    settle_time: float = Field(
        100.0, gt=0.0, le=1e6, description="[-] before the flow is measured, in sqrt(d/g)")
    flow_time: float = Field(200.0, gt=1.0, le=1e6, description="[-] measured, in sqrt(d/g)")
    blocks: int = Field(
        10, ge=6, le=100, description="[-] parts of the measurement, for uncertainty and drift")
    arrest_speed: float = Field(
        0.01, gt=0.0, le=0.1, description="[-] mean speed of a flow at least, in sqrt(g d)")
    # fmt: on

    @property
    def time(self) -> float:
        """Return the time of a run [sqrt(d/g)]."""
        return PREPARED + self.settle_time + self.flow_time


@dataclass(frozen=True)
class Slices:
    """Sums over slices of the flow, each (blocks, slices); ``height`` (slices,) in d.

    In m, d, sqrt(d/g). ``area`` is that of the base. Heights are above the mean height of the base.
    """

    height: Floats
    sums: Mapping[str, Floats]
    area: float
    angle: float

    @classmethod
    def of(cls, p: Flow, output: Output) -> Slices:
        """Return the slices in an output; raise EngineOutputError for none."""
        rows = output.rows("slice", 2 + len(SUMS))
        if not len(rows):
            raise EngineOutputError(f"{output.who} left no profile of the flow")
        block, height = rows[:, 0].astype(int) - 1, np.round(rows[:, 1] / SLICE - 0.5).astype(int)
        lowest = int(height.min()) - WINDOW  # a window that begins there is empty
        place = height - lowest
        shape = (p.blocks, int(place.max()) + 1 + WINDOW)
        sums = {name: np.zeros(shape) for name in SUMS}
        for name, values in zip(SUMS, rows[:, 2:].T, strict=True):
            sums[name][block, place] = values
        z = np.asarray(SLICE * (np.arange(shape[1]) + lowest + 0.5), dtype=np.float64)
        return cls(z, sums, float(p.length * p.width), p.angle)

    def mean(self, block: int | None = None) -> Slices:
        """Return one block, or the mean over all, as slices of one block."""
        chosen = slice(None) if block is None else slice(block, block + 1)
        sums = {name: v[chosen].mean(axis=0, keepdims=True) for name, v in self.sums.items()}
        return Slices(self.height, sums, self.area, self.angle)

    def total(self, name: str) -> Floats:
        """Return a sum over all slices, (blocks,)."""
        return np.asarray(self.sums[name].sum(axis=1))

    def profile(self) -> dict[str, Floats]:
        """Return the profile of the first block, each (slices,), over windows of a diameter."""
        sums = {name: values[0] for name, values in self.sums.items()}
        mass = np.where(sums["mass"] > 0.0, sums["mass"], np.nan)
        moving = sums["momentum"] * np.nan_to_num(sums["momentum"] / mass)  # mean flow of a slice
        kinetic = {"xx": sums["mxx"] - moving, "yy": sums["myy"], "zz": sums["mzz"]}
        volume = self.area * SLICE * WINDOW
        total = _windowed(sums["mass"])
        filled = np.where(total > 0.0, total, np.nan)
        flow = _windowed(sums["momentum"]) / filled
        normal = _windowed(kinetic["zz"] - sums["virial_zz"]) / volume
        shear = -_windowed(sums["mxz"] - sums["virial_xz"]) / volume
        above = (np.cumsum(sums["mass"][::-1])[::-1] - 0.5 * sums["mass"]) / self.area
        rate = np.gradient(flow, SLICE)
        with np.errstate(invalid="ignore", divide="ignore"):
            return {
                "height": self.height,
                "solid_fraction": _windowed(sums["volume"]) / volume,
                "velocity": flow,
                "granular_temperature": _windowed(sum(kinetic.values())) / (3.0 * filled),
                "shear_rate": rate,
                "normal_stress": normal,
                "shear_stress": shear,
                "weight_above": above * math.cos(math.radians(self.angle)),
                "mu": shear / normal,
                "inertial_number": rate / np.sqrt(normal / GRAIN_DENSITY),
            }


def _windowed(values: Floats) -> Floats:
    """Return the sums over :data:`WINDOW` slices about each, (slices,)."""
    kernel = np.concatenate([[0.5], np.ones(WINDOW - 1), [0.5]])
    return np.convolve(values, kernel, mode="same")


class Drift(NamedTuple):
    """A relative change with the half width of its interval."""

    value: float
    half_width: float


@dataclass(frozen=True)
class Measurement:
    """The measurement of a flow: blocks of equal length, each with its means and its slices.

    ``blocks`` (blocks, 11) as the script writes them, ``time`` that of one [sqrt(d/g)], ``mass``
    that of all grains [m].
    """

    parameters: Flow
    blocks: Floats
    slices: Slices
    time: float
    mass: float

    @classmethod
    def of(cls, p: Flow, output: Output) -> Measurement:
        """Return the measurement in an output; raise EngineOutputError for a missing part.

        EngineLostAtomsError for a grain below the base, EngineUndecidedError for a flow that
        stopped: it has no means.
        """
        verdict = output.text("verdict")
        check_base(p, verdict)
        if verdict == "stopped":
            raise EngineUndecidedError(
                f"undecided: the flow stopped at angle = {p.angle:g} deg, its mean speed is "
                f"below arrest_speed = {p.arrest_speed:g}",
                {},
            )
        blocks = output.rows("block", 11)
        if verdict != "flowed" or len(blocks) != p.blocks:
            raise EngineOutputError(
                f"{output.who} left the verdict {verdict[:20]!r} and {len(blocks)} blocks of "
                f"{p.blocks}"
            )
        numbers = output.number("block_time"), output.number("mass")
        return cls(p, blocks, Slices.of(p, output), *numbers)

    @property
    def drift(self) -> Drift:
        """Return the change of the kinetic energy over the measurement, over its mean.

        By a straight line through the blocks, with an interval of 99 %. Where residuals persist
        from a block to the next, with the correlation r, it is wider by sqrt((1 + r) / (1 - r))
        (Santer et al. 2000, J. Geophys. Res. 105, 7337). Of residuals from a line through few
        blocks r comes out too small, by (2 + 4 r) / count (Kendall 1954, Marriott and Pope 1954,
        Biometrika 41, 390 and 403), which is added.
        """
        from scipy import stats

        energy = self.blocks[:, 2]
        place, count = np.arange(len(energy)), len(energy)
        line = stats.linregress(place, energy)
        residual = energy - line.intercept - line.slope * place
        seen = float(residual[1:] @ residual[:-1] / (residual @ residual + 1e-300))
        persists = min(max((count * seen + 2.0) / (count - 4.0), 0.0), 0.9)
        scale = count / energy.mean()
        quantile = float(stats.t.ppf(0.5 + CONFIDENT / 2, count - 2))
        half = quantile * float(line.stderr) * scale
        half *= math.sqrt((1.0 + persists) / (1.0 - persists))
        return Drift(float(line.slope) * scale, half)

    def profile(self) -> dict[str, Floats]:
        """Return the profile, each (slices,), with uncertainties by the scatter of the blocks."""
        profile = self.slices.mean().profile()
        with np.errstate(invalid="ignore", divide="ignore"):
            each = [self.slices.mean(block).profile() for block in range(len(self.blocks))]
        half = _half_width(len(each))
        for name in UNCERTAIN:
            scatter = np.std([block_profile[name] for block_profile in each], axis=0, ddof=1)
            profile[f"{name}_uncertainty"] = np.asarray(half * scatter)
        return profile

    def quantities(self) -> dict[str, float]:
        """Return the declared quantities but for the steps."""
        values = self._means()
        each = [_of_middle(self.slices.mean(block)) for block in range(len(self.blocks))]
        for name, value in _of_middle(self.slices.mean()).items():
            uncertainty = uncertainty_of([of_block[name] for of_block in each])
            values |= {name: value, f"{name}_uncertainty": uncertainty}
        return values

    def _means(self) -> dict[str, float]:
        _, speed, _, touching, height, along, out, first, last, *levers = self.blocks.T
        tilt, drift = math.radians(self.parameters.angle), self.drift
        weight = self.mass * math.sin(tilt), self.mass * math.cos(tilt)
        gained = self.mass * (last - first) / self.time
        # moments of the weight about the plane z = 0, less those of the base's forces
        moment = self.mass * height.mean()
        expected = [
            (moment * math.sin(tilt) - levers[0].mean()) / self._area,
            (moment * math.cos(tilt) + levers[1].mean()) / self._area,
        ]
        profile = self.slices.mean().profile()
        shear, normal = (
            float(profile[name].sum() * SLICE) for name in ("shear_stress", "normal_stress")
        )
        return {
            "mean_speed": float(speed.mean()),
            "mean_speed_uncertainty": uncertainty_of(speed),
            "coordination": float(touching.mean()),
            "mean_height": float(height.mean()),
            "mu": float(along.sum() / -out.sum()),
            "mu_uncertainty": uncertainty_of(along / -out),
            "mu_of_contacts": shear / normal,
            "momentum_balance": float((along + gained).mean() / weight[0]),
            "weight_on_base": float(-out.mean() / weight[1]),
            "shear_stress_balance": shear / expected[0],
            "normal_stress_balance": normal / expected[1],
            "kinetic_energy_drift": drift.value,
            "kinetic_energy_drift_uncertainty": drift.half_width,
        }

    @property
    def _area(self) -> float:
        """Return the area of the base [d^2] by the number of grains over it."""
        p, grains = self.parameters, self.slices.total("count").mean()
        return float(grains / (p.layers * (p.filled or p.length)) * p.length)


def _of_middle(slices: Slices) -> dict[str, float]:
    """Return means between the quartiles of the grains' heights in the mean flow."""
    profile = slices.profile()
    middle = middle_half(slices.sums["count"][0])
    count = slices.sums["count"][0][middle]
    height, speed = profile["height"][middle], profile["velocity"][middle]
    rate = float(np.polyfit(height, speed, 1, w=np.sqrt(count))[0])
    mean = {name: float(np.mean(profile[name][middle])) for name in OF_MIDDLE}
    return {
        "solid_fraction": mean["solid_fraction"],
        "granular_temperature": mean["granular_temperature"],
        "pressure": mean["normal_stress"],
        "shear_rate": rate,
        "inertial_number": rate / math.sqrt(mean["normal_stress"] / GRAIN_DENSITY),
    }


def uncertainty_of(values: Sequence[float] | Floats) -> float:
    """Return the half width of the 95 % interval of the mean of independent values."""
    return _half_width(len(values)) * float(np.std(values, ddof=1))


def _half_width(count: int) -> float:
    """Return the half width of the 95 % interval of a mean of so many, over their scatter."""
    from scipy import stats

    return float(stats.t.ppf(0.975, count - 1)) / math.sqrt(count)
