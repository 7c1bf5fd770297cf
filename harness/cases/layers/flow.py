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
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field

from harness.cases.base import Check, Level, Quantity, Value
from harness.cases.bench import OWN, Bench
from harness.cases.layers import PREPARED, Floats, Packing, PackingCase, check_base, middle_half
from harness.engines.base import Engine
from harness.engines.output import Output
from harness.errors import EngineError, EngineOutputError, EngineUndecidedError
from harness.report.content import Drawing, Section
from harness.results.rows import Kind, Tolerance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SLICE = 0.25  # [d] height of a slice
WINDOW = 4  # slices over which profiles are averaged: a diameter, as grains stand in layers
GRAIN_DENSITY = 6.0 / math.pi  # [m/d^3] of a grain
CONFIDENT = 0.99  # of the interval of a drift: one steady flow of a hundred is called unsteady
SUMS = ("count", "volume", "mass", "momentum", "mxx", "myy", "mzz", "mxz",
        "virial_xx", "virial_yy", "virial_zz", "virial_xz")  # of a slice, in a script  # fmt: skip
UNCERTAIN = ("solid_fraction", "velocity", "granular_temperature", "shear_rate", "normal_stress",
             "shear_stress", "mu", "inertial_number")  # fmt: skip


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
class Measurement:
    """The measurement of a flow in blocks of equal length, in m, d and sqrt(d/g).

    ``blocks`` (blocks, 11) as the script writes them; ``sums`` over slices by name, each (blocks,
    slices), ``height`` (slices,) above the mean height of the base. ``time`` is that of a block,
    ``mass`` that of all grains, ``area`` that of the base.
    """

    parameters: Flow
    blocks: Floats
    height: Floats
    sums: Mapping[str, Floats]
    time: float
    mass: float
    area: float

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
        blocks, rows = output.rows("block", 11), output.rows("slice", 2 + len(SUMS))
        if verdict != "flowed" or len(blocks) != p.blocks or not len(rows):
            raise EngineOutputError(
                f"{output.engine} left the verdict {verdict[:20]!r}, {len(blocks)} blocks of "
                f"{p.blocks} and {len(rows)} slices"
            )
        block, number = rows[:, 0].astype(int) - 1, np.round(rows[:, 1] / SLICE - 0.5).astype(int)
        place = number - number.min() + WINDOW  # a window that begins at 0 is empty
        sums = np.zeros((len(SUMS), p.blocks, int(place.max()) + 1 + WINDOW))
        sums[:, block, place] = rows[:, 2:].T
        height = SLICE * (np.arange(sums.shape[2]) + number.min() - WINDOW + 0.5)
        numbers = output.number("block_time"), output.number("mass")
        table = dict(zip(SUMS, sums, strict=True))
        return cls(p, blocks, height, table, *numbers, float(p.length * p.width))

    @property
    def mean(self) -> dict[str, Floats]:
        """Return the sums over slices averaged over the blocks, each (slices,)."""
        return {name: values.mean(axis=0) for name, values in self.sums.items()}

    @property
    def drift(self) -> tuple[float, float]:
        """Return the change of the kinetic energy over its mean, and the half width of 99 %.

        By a straight line through the blocks. Where residuals persist from a block to the next,
        with the correlation r, it is wider by sqrt((1 + r) / (1 - r)) (Santer et al. 2000,
        J. Geophys. Res. 105, 7337). Of residuals from a line through few blocks r comes out too
        small, by (2 + 4 r) / count (Kendall 1954, Marriott and Pope 1954, Biometrika 41, 390 and
        403), which is added.
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
        return float(line.slope) * scale, half * math.sqrt((1.0 + persists) / (1.0 - persists))

    def profile(self) -> dict[str, Floats]:
        """Return the profile, each (slices,), with uncertainties by the scatter of the blocks."""
        profile, each = self._profile(self.mean), self._profile(self.sums)
        more = {f"{name}_uncertainty": uncertainty_of(each[name]) for name in UNCERTAIN}
        return {"height": self.height, **profile, **more}

    def _profile(self, sums: Mapping[str, Floats]) -> dict[str, Floats]:
        """Return the profile of sums (..., slices), over windows of a diameter."""
        mass, momentum, volume = sums["mass"], sums["momentum"], self.area * SLICE * WINDOW
        moving = momentum * np.nan_to_num(momentum / _filled(mass))  # mean flow of a slice
        kinetic = {"xx": sums["mxx"] - moving, "yy": sums["myy"], "zz": sums["mzz"]}
        total = _filled(_windowed(mass))
        flow = _windowed(momentum) / total
        normal = _windowed(kinetic["zz"] - sums["virial_zz"]) / volume
        shear = -_windowed(sums["mxz"] - sums["virial_xz"]) / volume
        above = (np.cumsum(mass[..., ::-1], axis=-1)[..., ::-1] - 0.5 * mass) / self.area
        rate = np.gradient(flow, SLICE, axis=-1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return {
                "solid_fraction": _windowed(sums["volume"]) / volume,
                "velocity": flow,
                "granular_temperature": _windowed(sum(kinetic.values())) / (3.0 * total),
                "shear_rate": rate,
                "normal_stress": normal,
                "shear_stress": shear,
                "weight_above": above * math.cos(math.radians(self.parameters.angle)),
                "mu": shear / normal,
                "inertial_number": rate / np.sqrt(normal / GRAIN_DENSITY),
            }

    def quantities(self) -> dict[str, float]:
        """Return the declared quantities but for the steps."""
        _, speed, _, touching, height, along, out, first, last, *levers = self.blocks.T
        p, tilt, drift = self.parameters, math.radians(self.parameters.angle), self.drift
        weight = self.mass * math.sin(tilt), self.mass * math.cos(tilt)
        gained = self.mass * (last - first) / self.time
        # moments of the weight about the plane z = 0, less those of the base's forces, over the
        # area of the base by the number of grains over it
        moment = self.mass * height.mean()
        area = float(self.sums["count"].sum(axis=1).mean() / p.layers / (p.filled or p.length))
        moments = (
            (moment * math.sin(tilt) - levers[0].mean()) / (area * p.length),
            (moment * math.cos(tilt) + levers[1].mean()) / (area * p.length),
        )
        profile = self._profile(self.mean)
        shear, normal = (
            float(profile[name].sum() * SLICE) for name in ("shear_stress", "normal_stress")
        )
        each = [{name: v[k] for name, v in self.sums.items()} for k in range(len(self.blocks))]
        middles, middle = [self._middle(sums) for sums in each], self._middle(self.mean)
        scatter = {name: uncertainty_of(np.array([m[name] for m in middles])) for name in middle}
        return {
            "mean_speed": float(speed.mean()),
            "mean_speed_uncertainty": float(uncertainty_of(speed)),
            "coordination": float(touching.mean()),
            "mean_height": float(height.mean()),
            "mu": float(along.sum() / -out.sum()),
            "mu_uncertainty": float(uncertainty_of(along / -out)),
            "mu_of_contacts": shear / normal,
            "momentum_balance": float((along + gained).mean() / weight[0]),
            "weight_on_base": float(-out.mean() / weight[1]),
            "shear_stress_balance": shear / moments[0],
            "normal_stress_balance": normal / moments[1],
            "kinetic_energy_drift": drift[0],
            "kinetic_energy_drift_uncertainty": drift[1],
            **middle,
            **{f"{name}_uncertainty": float(half) for name, half in scatter.items()},
        }

    def _middle(self, sums: Mapping[str, Floats]) -> dict[str, float]:
        """Return means between the quartiles of the grains' heights."""
        count, profile = sums["count"], self._profile(sums)
        middle = middle_half(count)
        height, speed = self.height[middle], profile["velocity"][middle]
        rate = float(np.polyfit(height, speed, 1, w=np.sqrt(count[middle]))[0])
        names = ("solid_fraction", "granular_temperature", "normal_stress")
        fraction, temperature, pressure = (float(np.mean(profile[n][middle])) for n in names)
        return {
            "solid_fraction": fraction,
            "granular_temperature": temperature,
            "pressure": pressure,
            "shear_rate": rate,
            "inertial_number": rate / math.sqrt(pressure / GRAIN_DENSITY),
        }


def uncertainty_of(values: Floats) -> Floats:
    """Return the half width of the 95 % interval of the mean of independent values (N, ...)."""
    from scipy import stats

    count = len(values)
    half_width = float(stats.t.ppf(0.975, count - 1)) / math.sqrt(count)
    return np.asarray(half_width * np.std(values, axis=0, ddof=1))


def _windowed(values: Any) -> Floats:
    """Return the sums over :data:`WINDOW` slices about each, (..., slices)."""
    kernel = np.concatenate([[0.5], np.ones(WINDOW - 1), [0.5]])
    return np.apply_along_axis(np.convolve, -1, values, kernel, mode="same")


def _filled(mass: Floats) -> Floats:
    return np.where(mass > 0.0, mass, np.nan)


# ---- the case

# drift of the kinetic energy over a measurement, relative to its mean: none, and never steady,
# however uncertain it is, as in free fall the blocks are correlated as well
STEADY, NEVER_STEADY = 0.1, 0.5
_LOOKS = "a mean of 1000 looks at a stress that fluctuates by its own size: 1 / sqrt(1000)"
BALANCES = {
    "momentum_balance": Tolerance(
        relative=4e-3,
        reason="an identity of velocity Verlet but for half a step at both ends of a block, where "
        "the force is off its mean by the weight at most: step / block time / sin(angle), 2.4e-3",
    ),
    "weight_on_base": Tolerance(
        relative=5e-3,
        reason="the momentum normal to the base changes over a block by a hundredth of M sqrt(g d) "
        "at most: 1e-3 of the weight times the time, and half a step at both ends",
    ),
    "shear_stress_balance": Tolerance(relative=0.032, reason=_LOOKS),
    "normal_stress_balance": Tolerance(relative=0.032, reason=_LOOKS),
}


SMALL = Flow(layers=4, length=8, width=4, angle=16.0, settle_time=50.0, flow_time=100.0)
ANGLES = (16.0, 18.0, 21.0, 24.0)  # [deg] of small flows that are steady; one at level quick
_MIDDLE = "of the middle half of the grains"


def _with_uncertainty(
    name: str, meaning: str, scale: float, uncertainty: float = 0.01,
    interval: str = "95 %, by the scatter of the blocks",
) -> Iterable[Quantity[Flow]]:  # fmt: skip
    yield Quantity(name, "1", meaning, scale)
    yield Quantity(f"{name}_uncertainty", "1", interval, uncertainty)


class FlowCase(PackingCase[Flow]):
    """Frictionless layers in steady flow at one angle: friction, inertial number, profiles."""

    name = "layers-flow"
    has_figures = True
    parameters = Flow
    quantities = (
        *_with_uncertainty("mean_speed", "of the grains, in sqrt(g d)", 1.0, 0.1),
        *_with_uncertainty("mu", "force on the base along the flow over that into it", 0.3),
        Quantity("mu_of_contacts", "1", "shear stress over normal stress of contacts and "
                 "fluctuations, over the depth", 0.3),
        *_with_uncertainty("inertial_number", f"I = shear rate d / sqrt(P / rho), {_MIDDLE}", 0.3),
        *_with_uncertainty("solid_fraction", _MIDDLE, 0.5),
        *_with_uncertainty(
            "shear_rate", f"of the mean velocity, {_MIDDLE}, in sqrt(g/d)", 0.3),
        *_with_uncertainty("pressure", f"normal stress of contacts and fluctuations, {_MIDDLE}, in "
                           "m g/d^2", 1.0, 0.1),
        *_with_uncertainty("granular_temperature", "a third of the mean squared fluctuation of the "
                           f"velocity, {_MIDDLE}, in g d", 0.1),
        Quantity("coordination", "1", "contacts of a grain"),
        Quantity("mean_height", "1", "of the grains, in d above the base"),
        *_with_uncertainty("kinetic_energy_drift", "of the kinetic energy over the measurement, "
                           "over its mean", 0.1, 0.1, "99 %, of a line through the blocks"),
        Quantity("momentum_balance", "1", "force on the base along the flow and gain of momentum, "
                 "over M g sin(angle)"),
        Quantity("weight_on_base", "1", "force into the base over M g cos(angle)"),
        Quantity("shear_stress_balance", "1", "shear stress of contacts and fluctuations over the "
                 "depth, over the moment of the weight"),
        Quantity("normal_stress_balance", "1", "normal stress likewise"),
        Quantity("steps", "1", "time steps that were taken", lambda p: p.time / p.step),
    )  # fmt: skip
    presets = {"flow": Flow(), "small": SMALL}  # noqa: RUF012

    def measure(self, parameters: Flow, output: Output) -> Mapping[str, float]:
        """Return the means of a steady flow with their uncertainties.

        Raise as :meth:`Measurement.of`, and EngineUndecidedError, with the values, for a flow that
        becomes faster or slower.
        """
        measured = Measurement.of(parameters, output)
        values, (drift, half) = measured.quantities(), measured.drift
        values["steps"] = output.number("steps")
        if abs(drift) > min(max(half, STEADY), NEVER_STEADY):
            change = "faster" if drift > 0.0 else "slower"
            raise EngineUndecidedError(
                f"undecided: the flow becomes {change}: its kinetic energy changes by "
                f"{100 * drift:+.0f} +- {100 * half:.0f} % over flow_time = "
                f"{parameters.flow_time:g}",
                values,
            )
        return values

    def exact(self, parameters: Flow) -> Mapping[str, float]:
        """Return the momentum balance: tan(angle), and 1 for forces over those of the weight."""
        tangent = math.tan(math.radians(parameters.angle))
        return {"mu": tangent, **dict.fromkeys(BALANCES, 1.0)}

    def profile(self, parameters: Flow, output: Output) -> Mapping[str, Sequence[float]]:
        """Return the profile over the height, in d, m and sqrt(d/g)."""
        profile = Measurement.of(parameters, output).profile()
        flows = np.isfinite(profile["velocity"])
        return {name: values[flows].tolist() for name, values in profile.items()}

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the balances of small flows, and their inertial number and solid fraction."""
        for angle in ANGLES:
            p = SMALL.replace(angle=angle)
            level: Level = "quick" if angle == ANGLES[0] else "default"
            for name, tolerance in BALANCES.items():
                yield self._check(p, name, level, tolerance)
            for name in ("inertial_number", "solid_fraction"):
                yield self._check(p, name, level)

    def _check(self, p: Flow, name: str, level: Level, tolerance: Tolerance | None = None) -> Check:
        """Return the check of a balance, or the record of a quantity that the law decides."""
        job = self.job(p)

        def measured(bench: Bench) -> Value:
            values = self.measure(p, bench.output(job))
            return Value(values[name], values.get(f"{name}_uncertainty", 0.0))

        def scatter(bench: Bench) -> Tolerance:
            reason = "runs of other rounding part: twice the half width of the interval of 95 %"
            return Tolerance(2.0 * measured(bench).uncertainty, reason=reason)

        return Check(
            setup=f"4 layers, 8 x 4 d, {p.angle:g} deg", quantity=name, unit="1", level=level,
            kind=Kind.ANALYTIC if tolerance else Kind.RECORDED, jobs=[job], measure=measured,
            expected=1.0 if tolerance else math.nan, tolerance=tolerance or scatter,
        )  # fmt: skip

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return friction and solid fraction over the inertial number, of each engine."""
        engines = [bench for name, bench in benches.items() if name != OWN]
        flows = {b.engine.title: values for b in engines if (values := self._flows(b))}
        if not flows:
            return ()
        drawing = Drawing(
            "layers-flow-law",
            "Friction and solid fraction over the inertial number",
            "Four layers of 8 x 4 d at several angles; bars are 95 % by the scatter of ten blocks.",
            lambda: _law_figure(flows),
        )
        text = (
            "Steady uniform flow, from the momentum balance alone: force on the base along the "
            "flow M g sin(angle), into it M g cos(angle), so mu = tan(angle); the virial theorem "
            "gives the stresses summed over the depth, as moments of the weight about the base. "
            "Everything else is measured."
        )
        return (Section("Layers in steady flow", text, drawings=(drawing,)),)

    def _flows(self, bench: Bench) -> list[Mapping[str, float]]:
        """Return the quantities of the small flows that were run and are steady."""
        flows = []
        for p in (SMALL.replace(angle=angle) for angle in ANGLES):
            if bench.has_run([self.job(p)]):
                with suppress(EngineError):  # its rows have it
                    flows.append(self.measure(p, bench.output(self.job(p))))
        return flows


def _law_figure(flows: Mapping[str, Sequence[Mapping[str, float]]]) -> Figure:
    from harness.report.figures import COLOURS, MARKERS, label, legend_below, panels

    figure = panels(1, 2, 3.5, 3.6)
    labels = {"mu": "friction mu = tau / P", "solid_fraction": "solid fraction"}
    x = "inertial_number"
    for axes, (y, words) in zip(figure.axes, labels.items(), strict=True):
        for place, (title, values) in enumerate(flows.items()):
            columns = (x, y, f"{y}_uncertainty", f"{x}_uncertainty")
            at, height, up, across = ([row[name] for row in values] for name in columns)
            axes.errorbar(at, height, up, across, ls="none", marker=MARKERS[place],
                          color=COLOURS[place], mfc="none", label=title)  # fmt: skip
        label(axes, "inertial number I", words)
    legend_below(figure)
    return figure


CASE = FlowCase()
