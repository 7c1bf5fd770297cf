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
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.base import Check, Level, Quantity, Value
from harness.cases.bench import OWN, Bench
from harness.cases.layers.measurement import Flow, Measurement
from harness.cases.layers.packing import PackingCase
from harness.engines.base import Engine
from harness.engines.output import Output
from harness.errors import EngineError, EngineUndecidedError
from harness.report.content import Drawing, Section
from harness.results.rows import Kind, Tolerance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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


class FlowCase(PackingCase[Flow]):
    """Frictionless layers in steady flow at one angle: friction, inertial number, profiles."""

    name = "layers-flow"
    summary = (
        "Frictionless layers in steady flow at one angle: friction, inertial number, profiles."
    )
    parameters = Flow
    quantities = (
        Quantity("mean_speed", "1", "of the grains, in sqrt(g d)"),
        Quantity("mean_speed_uncertainty", "1", "95 %, by the scatter of the blocks, as all "
                 "uncertainties here", 0.1),
        Quantity("mu", "1", "force on the base along the flow over that into it", 0.3),
        Quantity("mu_uncertainty", "1", "of it", 0.01),
        Quantity("mu_of_contacts", "1", "shear stress over normal stress of contacts and "
                 "fluctuations, over the depth", 0.3),
        Quantity("inertial_number", "1", f"I = shear rate d / sqrt(P / rho), {_MIDDLE}", 0.3),
        Quantity("inertial_number_uncertainty", "1", "of it", 0.01),
        Quantity("solid_fraction", "1", _MIDDLE, 0.5),
        Quantity("solid_fraction_uncertainty", "1", "of it", 0.01),
        Quantity("shear_rate", "1", f"of the mean velocity, {_MIDDLE}, in sqrt(g/d)", 0.3),
        Quantity("shear_rate_uncertainty", "1", "of it", 0.01),
        Quantity("pressure", "1", f"normal stress of contacts and fluctuations, {_MIDDLE}, in "
                 "m g/d^2"),
        Quantity("pressure_uncertainty", "1", "of it", 0.1),
        Quantity("granular_temperature", "1", "a third of the mean squared fluctuation of the "
                 f"velocity, {_MIDDLE}, in g d", 0.1),
        Quantity("granular_temperature_uncertainty", "1", "of it", 0.01),
        Quantity("coordination", "1", "contacts of a grain"),
        Quantity("mean_height", "1", "of the grains, in d above the base"),
        Quantity("kinetic_energy_drift", "1", "of the kinetic energy over the measurement, over "
                 "its mean", 0.1),
        Quantity("kinetic_energy_drift_uncertainty", "1", "of it, 99 %", 0.1),
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
        values, drift = measured.quantities(), measured.drift
        values["steps"] = output.number("steps")
        if abs(drift.value) > min(max(drift.half_width, STEADY), NEVER_STEADY):
            change = "faster" if drift.value > 0.0 else "slower"
            raise EngineUndecidedError(
                f"undecided: the flow becomes {change}: its kinetic energy changes by "
                f"{100 * drift.value:+.0f} +- {100 * drift.half_width:.0f} % over flow_time = "
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
        flows = {
            bench.engine.title: values
            for name, bench in benches.items()
            if name != OWN and (values := self._flows(bench))
        }
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
        found = []
        for angle in ANGLES:
            p = SMALL.replace(angle=angle)
            if bench.has_run([self.job(p)]):
                try:
                    found.append(self.measure(p, bench.output(self.job(p))))
                except EngineError:
                    continue  # its rows have the error
        return found


def _law_figure(flows: Mapping[str, Sequence[Mapping[str, float]]]) -> Figure:
    from harness.report.style import COLOURS, MARKERS, label, legend_below, panels

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
