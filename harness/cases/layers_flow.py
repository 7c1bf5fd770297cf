"""Layers of frictionless spheres in steady flow at one angle: friction, inertial number, profiles.

Definitions as of GDR MiDi (2004), Eur. Phys. J. E 14, 341, and Jop, Forterre and Pouliquen (2006),
Nature 441, 727: mu = tau / P, I = shear rate d / sqrt(P / rho), rho the density of a grain. Stress
is that of contacts (the virial, half to each sphere) and of fluctuations, positive in compression.

In steady uniform flow the momentum balance fixes the stress at every height, whatever the law:
P(z) A is the weight above times cos(angle), tau(z) A the same times sin(angle), so mu = tan(angle).
The stress of the contacts and the force on the base are compared with it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pydantic import Field
from scipy import stats

from harness.cases.contract import Case, LevelName, Plan, Reference
from harness.cases.display import Display
from harness.cases.layers.case import PACKED
from harness.cases.layers.system import CONTACT_ALLOWED, Packing, values_of
from harness.cases.text import tolerances_of
from harness.engines.contract import Job, Output, Template
from harness.engines.cost import engine_seconds
from harness.engines.traits import Traits
from harness.errors import EngineLostAtomsError, EngineOutputError, EngineUndecidedError
from harness.parameters.allowed import allowed_in

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

NAME = "layers-flow"

SLICE = 0.25
"""[d] height of a slice."""

WINDOW = 4
"""Slices over which profiles are averaged: a diameter, as grains stand in layers."""

GRAIN_DENSITY = 6.0 / math.pi
"""[m/d^3] of a grain."""

PREPARED = 20.0
"""[sqrt(d/g)] before the angle is set."""

STEADY = 0.1
"""Relative drift of the kinetic energy over the measurement that counts as none: of the speed it is
half as much."""

NEVER_STEADY = 0.5
"""Relative drift beyond which no flow is called steady, however uncertain the drift is: what grows
evenly, as in free fall, is correlated from block to block as well."""

CONFIDENT = 0.99
"""Of the interval of a drift: a steady flow whose blocks are independent is called unsteady once in
a hundred runs."""


class Flow(Packing):
    """Layers at one angle: how long they settle and are measured, and in how many blocks."""

    length: int = Field(10, ge=2, le=10000, description="[d] of the box along the flow")
    width: int = Field(
        5, ge=1, le=10000, description="[d] of the box across; 1: all spheres in one plane"
    )
    angle: float = Field(14.0, gt=0.0, le=45.0, description="[deg] of the base")
    settle_time: float = Field(
        100.0, gt=0.0, le=1e6, description="[-] before the flow is measured, in sqrt(d/g)"
    )
    flow_time: float = Field(200.0, gt=1.0, le=1e6, description="[-] measured, in sqrt(d/g)")
    blocks: int = Field(
        10, ge=6, le=100, description="[-] parts of the measurement, for uncertainty and drift"
    )
    arrest_speed: float = Field(
        0.01, gt=0.0, le=0.1, description="[-] mean speed of a flow at least, in sqrt(g d)"
    )


TEMPLATE = Template(
    name=NAME, variants={"": values_of(Flow())}, allowed={**allowed_in(Flow), **CONTACT_ALLOWED}
)

SUMS = ("count", "volume", "mass", "momentum", "mxx", "myy", "mzz", "mxz",
        "virial_xx", "virial_yy", "virial_zz", "virial_xz")  # fmt: skip
"""Of a slice, as the script writes them."""


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
    def of(cls, case: Flow, output: Output) -> Slices:
        """Return the slices in an output; raise EngineOutputError for none."""
        rows = output.rows("slice", 2 + len(SUMS))
        if not len(rows):
            raise EngineOutputError(f"{output.who} left no profile of the flow")
        block, height = rows[:, 0].astype(int) - 1, np.round(rows[:, 1] / SLICE - 0.5).astype(int)
        lowest = int(height.min()) - WINDOW  # a window that begins there is empty
        place = height - lowest
        shape = (case.blocks, int(place.max()) + 1 + WINDOW)
        sums = {name: np.zeros(shape) for name in SUMS}
        for name, values in zip(SUMS, rows[:, 2:].T, strict=True):
            sums[name][block, place] = values
        z = np.asarray(SLICE * (np.arange(shape[1]) + lowest + 0.5), dtype=np.float64)
        return cls(z, sums, float(case.length * case.width), case.angle)

    def mean(self, block: int | None = None) -> Slices:
        """Return one block, or the mean over all, as slices of one block."""
        chosen = slice(None) if block is None else slice(block, block + 1)
        sums = {
            name: values[chosen].mean(axis=0, keepdims=True) for name, values in self.sums.items()
        }
        return Slices(self.height, sums, self.area, self.angle)

    def total(self, name: str) -> Floats:
        """Return a sum over all slices, (blocks,)."""
        return np.asarray(self.sums[name].sum(axis=1))

    def profile(self) -> dict[str, Floats]:
        """Return the profile of the first block, each (slices,), over windows of a diameter."""
        sums = {name: values[0] for name, values in self.sums.items()}
        mass = np.where(sums["mass"] > 0.0, sums["mass"], np.nan)
        speed = sums["momentum"] / mass
        moving = sums["momentum"] * np.nan_to_num(speed)  # of the mean flow of a slice
        kinetic = {"xx": sums["mxx"] - moving, "yy": sums["myy"], "zz": sums["mzz"]}
        volume = self.area * SLICE * WINDOW
        total = _windowed(sums["mass"])
        there = np.where(total > 0.0, total, np.nan)
        flow = _windowed(sums["momentum"]) / there
        normal = _windowed(kinetic["zz"] - sums["virial_zz"]) / volume
        shear = -_windowed(sums["mxz"] - sums["virial_xz"]) / volume
        above = (np.cumsum(sums["mass"][::-1])[::-1] - 0.5 * sums["mass"]) / self.area
        rate = np.gradient(flow, SLICE)
        with np.errstate(invalid="ignore", divide="ignore"):
            return {
                "height": self.height,
                "solid_fraction": _windowed(sums["volume"]) / volume,
                "velocity": flow,
                "granular_temperature": _windowed(sum(kinetic.values())) / (3.0 * there),
                "shear_rate": rate,
                "normal_stress": normal,
                "shear_stress": shear,
                "weight_above": above * math.cos(math.radians(self.angle)),
                "mu": shear / normal,
                "inertial_number": rate / np.sqrt(normal / GRAIN_DENSITY),
            }

    @property
    def middle(self) -> NDArray[np.bool_]:
        """Return which slices lie between the quartiles of the grains' heights."""
        count = self.sums["count"].sum(axis=0)
        below = np.cumsum(count) / count.sum()
        return np.asarray((below >= 0.25) & (below - count / count.sum() <= 0.75))


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
    """What a flow left: blocks of equal length, each with its means and its slices.

    ``blocks`` (blocks, 11) as the script writes them, ``time`` that of one [sqrt(d/g)], ``mass``
    that of all grains [m].
    """

    case: Flow
    blocks: Floats
    slices: Slices
    time: float
    mass: float

    @classmethod
    def of(cls, case: Flow, output: Output) -> Measurement:
        """Return the measurement in an output; raise EngineOutputError where a part is missing.

        EngineLostAtomsError for a grain below the base, EngineUndecidedError for a flow that
        stopped: it has no means.
        """
        verdict = output.text("verdict")
        if verdict == "fell_through":
            raise EngineLostAtomsError(
                f"a grain fell through the base: roughness = {case.roughness:g} d is too much for "
                f"seed = {case.seed}"
            )
        if verdict == "stopped":
            raise EngineUndecidedError(
                f"undecided: the flow stopped at angle = {case.angle:g} deg, its mean speed is "
                f"below arrest_speed = {case.arrest_speed:g}",
                {},
            )
        blocks = output.rows("block", 11)
        if verdict != "flowed" or len(blocks) != case.blocks:
            raise EngineOutputError(
                f"{output.who} left the verdict {verdict[:20]!r} and {len(blocks)} blocks of "
                f"{case.blocks}"
            )
        numbers = output.number("block_time"), output.number("mass")
        return cls(case, blocks, Slices.of(case, output), *numbers)

    @property
    def drift(self) -> Drift:
        """Return how much the kinetic energy changes over the measurement, over its mean.

        By a straight line through the blocks; the interval holds it with :data:`CONFIDENT`. Where
        what is off the line goes on from a block to the next, with the correlation r, it is wider
        by sqrt((1 + r) / (1 - r)) (Santer et al. 2000, J. Geophys. Res. 105, 7337). Off a line
        through few blocks r comes out too small, by (2 + 4 r) / count (Kendall 1954, Marriott and
        Pope 1954, Biometrika 41, 390 and 403), which is added.
        """
        energy = self.blocks[:, 2]
        place = np.arange(len(energy))
        line = stats.linregress(place, energy)
        off = energy - line.intercept - line.slope * place
        count = len(energy)
        seen = float(off[1:] @ off[:-1] / (off @ off + 1e-300))
        goes_on = min(max((count * seen + 2.0) / (count - 4.0), 0.0), 0.9)
        scale = count / energy.mean()
        quantile = float(stats.t.ppf(0.5 + CONFIDENT / 2, count - 2))
        half = quantile * float(line.stderr) * scale
        half *= math.sqrt((1.0 + goes_on) / (1.0 - goes_on))
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
        """Return the declared quantities."""
        values = self._means()
        measured = [self._of_middle(self.slices.mean(block)) for block in range(len(self.blocks))]
        for name, value in self._of_middle(self.slices.mean()).items():
            values[name] = value
            values[f"{name}_uncertainty"] = uncertainty_of(
                [of_block[name] for of_block in measured]
            )
        return values

    def _means(self) -> dict[str, float]:
        _, speed, _, touching, height, along, out, first, last, *levers = self.blocks.T
        tilt, drift = math.radians(self.case.angle), self.drift
        weight = self.mass * math.sin(tilt), self.mass * math.cos(tilt)
        gained = self.mass * (last - first) / self.time
        # moments of the weight about the plane z = 0, less those of the base's forces, on an area
        # by the number of grains over it
        heights, grains = self.mass * height.mean(), self.slices.total("count").mean()
        area = grains / (self.case.layers * (self.case.filled or self.case.length))
        area *= self.case.length
        expected = [
            (heights * math.sin(tilt) - levers[0].mean()) / area,
            (heights * math.cos(tilt) + levers[1].mean()) / area,
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

    def _of_middle(self, slices: Slices) -> dict[str, float]:
        """Return means between the quartiles of the grains' heights in the mean flow."""
        profile, middle = slices.profile(), self.slices.middle
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


UNCERTAIN = ("solid_fraction", "velocity", "granular_temperature", "shear_rate", "normal_stress",
             "shear_stress", "mu", "inertial_number")  # fmt: skip
OF_MIDDLE = ("solid_fraction", "granular_temperature", "normal_stress")


def uncertainty_of(values: Sequence[float]) -> float:
    """Return the half width of the 95 % interval of the mean of independent values."""
    return _half_width(len(values)) * float(np.std(values, ddof=1))


def _half_width(count: int) -> float:
    """Return the half width of the 95 % interval of a mean of so many, over their scatter."""
    return float(stats.t.ppf(0.975, count - 1)) / math.sqrt(count)


def read(case: Flow, output: Output) -> Mapping[str, float]:
    """Return the declared quantities of a steady flow.

    Raise as :meth:`Measurement.of`, and EngineUndecidedError, with what was measured, for a flow
    that becomes faster or slower: it has no steady state, or not yet.
    """
    measured = Measurement.of(case, output)
    values, drift = {**measured.quantities(), "steps": output.number("steps")}, measured.drift
    if abs(drift.value) > min(max(drift.half_width, STEADY), NEVER_STEADY):
        change = "faster" if drift.value > 0.0 else "slower"
        raise EngineUndecidedError(
            f"undecided: the flow becomes {change}: its kinetic energy changes by "
            f"{100 * drift.value:+.0f} +- {100 * drift.half_width:.0f} % over flow_time = "
            f"{case.flow_time:g}",
            values,
        )
    return values


PLANNED = Flow(layers=4, length=8, width=4, angle=16.0, settle_time=50.0, flow_time=100.0)
"""Small, for the balances."""

TOLERANCES = tolerances_of(__file__)

REFERENCES = dict.fromkeys(TOLERANCES, 1.0)


class FlowCase(Case[Flow]):
    """Frictionless layers in steady flow at one angle: friction, inertial number, profiles."""

    name = NAME
    group = "layers"
    template = TEMPLATE
    shown_by = "harness.cases.layers_flow:FlowDisplay"

    @property
    def presets(self) -> Mapping[str, Flow]:
        """Return four layers at 14 deg, and a small flow."""
        return {"flow": Flow(), "small": PLANNED}

    def job(self, parameters: Flow) -> Job:
        """Return the job of one flow."""
        return Job(TEMPLATE, values_of(parameters))

    def read(self, parameters: Flow, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return means with uncertainties; raise EngineUndecidedError for an unsteady flow."""
        return read(parameters, output)

    def profile(self, parameters: Flow, output: Output) -> Mapping[str, Sequence[float]]:
        """Return the profile over the height, in d, m and sqrt(d/g)."""
        profile = Measurement.of(parameters, output).profile()
        there = np.isfinite(profile["velocity"])
        return {name: values[there].tolist() for name, values in profile.items()}

    def references(self, parameters: Flow, traits: Traits) -> Mapping[str, Reference]:
        """Return the momentum balance: tan(angle), and 1 for what is held against the weight."""
        tangent = Reference(math.tan(math.radians(parameters.angle)), "closed form")
        references = {name: Reference(value, "closed form") for name, value in REFERENCES.items()}
        return {"mu": tangent, **references}

    def seconds(self, parameters: Flow, rules: Traits | None, solver: str = "") -> float:
        """Return what a flow is expected to take [s], good to a factor of three."""
        if rules is None:
            return 0.0
        steps = (PREPARED + parameters.settle_time + parameters.flow_time) / parameters.step
        particles = parameters.grains + parameters.base_spheres
        return PACKED * engine_seconds(steps, particles, rules)

    def plans(self, level: LevelName, traits: Traits) -> Sequence[Plan[Flow]]:
        """Return a small flow, whose balances are judged."""
        return [Plan("a small flow", PLANNED, TOLERANCES)]


class FlowDisplay(Display):
    """Shows friction and solid fraction over the inertial number."""

    def figures(self, rows: pd.DataFrame) -> Mapping[str, Callable[[], Figure]]:
        """Return friction and solid fraction over the inertial number."""
        return {"flow-law": partial(flow_law_figure, rows)} if len(rows) else {}


def flow_law_figure(rows: pd.DataFrame) -> Figure:
    """Draw mu(I) and phi(I) of runs, a colour for each number of layers, 95 % intervals."""
    from harness.report.style import COLOURS, MARKERS, label, legend_below, panels

    figure = panels(1, 2, width=4.6, height=3.8)
    columns = (("mu", "friction mu = tau / P"), ("solid_fraction", "solid fraction, middle half"))
    for axes, (name, words) in zip(figure.axes, columns, strict=True):
        for number, (layers, points) in enumerate(rows.groupby("layers")):
            axes.errorbar(
                points["inertial_number"],
                points[name],
                xerr=points["inertial_number_uncertainty"],
                yerr=points[f"{name}_uncertainty"],
                ls="none",
                lw=1,
                marker=MARKERS[number % len(MARKERS)],
                color=COLOURS[1 + number % 6],
                mfc="none",
                label=f"{layers} layers",
            )
        label(axes, "inertial number I", words)
        axes.set_xlim(left=0.0)
    legend_below(figure)
    return figure


CASE = FlowCase()
