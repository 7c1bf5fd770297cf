"""The case ``layers``: frictionless spheres in layers on a tilted rough base."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from harness.cases.contract import Case, LevelName, Plan, Reference
from harness.cases.display import Display
from harness.cases.layers.system import (
    NAME,
    QUANTITIES,
    RAISED,
    SINGLE,
    TEMPLATE,
    Layers,
    job_of,
    profile_in,
    read,
)
from harness.cases.verification import Study, Verification
from harness.comparison.verdicts import Tolerance
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Job, Output
from harness.engines.cost import engine_seconds
from harness.engines.traits import Traits
from harness.errors import EngineError
from harness.parameters.law import PLASTIC
from harness.report.sections import Drawing, Section

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from harness.cases.layers.system import Profile


TITLE = "Frictionless layers"

EXPLAINED = (
    "Frictionless spheres in layers on a rough base, periodic along and across, lowered until they "
    "rest. A single grain on the ordered row is the incline: it must stop at the incline's "
    "critical angle."
)


def flow_section(engine: str, profile: Profile) -> Section:
    """Return the section with the profile of a flow in an engine."""
    drawing = Drawing(
        "layers-profile",
        "Profile of a small flow of layers",
        "Mean speed of the grains and solid fraction, in slices of a quarter of a diameter, four "
        "layers at 16 deg. Each grain counts whole in the slice of its centre, so that the "
        "fraction rises and falls with the layers and may exceed that of a packing.",
        lambda: profile_drawn(engine, profile),
    )
    return Section(TITLE, (EXPLAINED,), drawings=(drawing,))


def profile_drawn(engine: str, profile: Profile) -> Figure:
    """Draw speed and solid fraction of the slices over their height."""
    from matplotlib.figure import Figure

    from harness.report.style import COLOURS

    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    speeds, fractions = figure.subplots(1, 2, sharey=True)
    speeds.plot(profile.speed, profile.height, "o-", color=COLOURS[0])
    speeds.set(xlabel="mean speed (sqrt(g d))", ylabel="height above the base (d)")
    fractions.plot(profile.solid_fraction, profile.height, "s-", color=COLOURS[1])
    fractions.set(xlabel="solid fraction, grains by their centres")
    figure.suptitle(f"Four layers at 16 deg, {engine}")
    return figure


FLOWING = Layers(layers=4, length=8, width=4, first_angle=16.0, rate=0.5)
"""A small flow, for its profile."""

PACKED = 2.0
"""Cost of a particle and step in a packing, by that of a grain on a row: the least of the committed
runs at 1,000 to 3,000 grains are 0.16 to 0.26 us."""

LOWERING = {1: 18.5, 2: 29.3, 4: 50.7, 8: 54.3}
"""[sqrt(d/g) for each d of length] from the first angle to the stop at LOWERING_RATE, by layers:
means over the runs of reports/layers; a longer box is longer in coming to rest. Other thicknesses
lie between, or are the last."""

LOWERING_RATE = 0.1
"""[deg for each d] at which that was measured; the time goes as its inverse."""

LEAST_SPEED = 0.01
"""[sqrt(g d)] of a flow that is not at rest: no descent takes longer than its angles at it."""

RISE_DEG = 2.5
"""[deg] from the stop to the start: what raised runs of 1 to 8 layers took."""

STATIC_DEG = 30.0
"""A grain at rest touches two spheres 30 deg either side of the row's normal."""


_OVERLAP_DEG = math.degrees(1.0 / SINGLE.stiffness_over_weight)

STOP = Tolerance(
    "deg",
    SINGLE.rate + _OVERLAP_DEG,
    0.0,
    "the angle falls by the rate over the well that is not passed any more; the weight presses "
    "m g/k into the row, an angle of m g/(k d)",
)
"""Of the angle at which the single grain stops."""

_RISE = math.radians(RAISED.rise)

START = Tolerance(
    "deg",
    RAISED.rise * math.sqrt(2.0 * RAISED.arrest_speed / _RISE) + _OVERLAP_DEG,
    0.0,
    "a grain that slides from rest has the speed that is looked for sqrt(2 speed/rise) later at "
    "most; the weight presses m g/k into the row",
)
"""Of the angle at which it starts again."""


class LayersCase(Case[Layers]):
    """Frictionless layers on a rough base: the angle at which their flow stops, starts."""

    name = NAME
    group = "layers"
    quantities = QUANTITIES
    template = TEMPLATE
    verified_by = "harness.cases.layers.case:LayersVerification"
    shown_by = "harness.cases.layers.case:LayersDisplay"

    @property
    def presets(self) -> Mapping[str, Layers]:
        """Return four layers, the single grain of the incline, and a small quick flow."""
        return {"layers": Layers(), "single": SINGLE, "small": FLOWING}

    def job(self, parameters: Layers) -> Job:
        """Return the job of one descent."""
        return job_of(parameters)

    def read(self, parameters: Layers, output: Output, traits: Traits) -> Mapping[str, float]:
        """Return angles and means; raise EngineOutputError for an undecided descent."""
        return read(parameters, output)

    def references(self, parameters: Layers, traits: Traits) -> Mapping[str, Reference]:
        """Return what a single grain on the row does; {} for any other system.

        Without rebound: overdamped contacts.
        """
        from harness.theory.incline import critical_angle

        single = parameters.grains == 1 and parameters.base == "ordered" and parameters.width == 1
        if not single:
            return {}
        references = {"start_angle_deg": Reference(STATIC_DEG, "closed form")}
        if parameters.contact.zeta >= PLASTIC.zeta:
            references["stop_angle_deg"] = Reference(critical_angle(), "closed form")
        return references

    def seconds(self, parameters: Layers, rules: Traits | None, solver: str = "") -> float:
        """Return what a descent is expected to take [s], good to a factor of three."""
        if rules is None:
            return 0.0
        particles = parameters.grains + parameters.base_spheres
        return PACKED * engine_seconds(steps_of(parameters), particles, rules)

    def plans(self, level: LevelName, traits: Traits) -> Sequence[Plan[Layers]]:
        """Return the single grain, lowered; beyond level quick raised as well."""
        plans = [Plan("one grain on a row stops", SINGLE, {"stop_angle_deg": STOP})]
        if level != "quick":
            start = {"start_angle_deg": START}
            plans.append(Plan("one grain on a row starts", RAISED, start))
        return plans


class LayersVerification(Verification):
    """Judges the plans, and runs a small flow for its profile."""

    case: LayersCase

    def run(self, engine: Engine, study: Study) -> Findings:
        """Judge the single grain, and run a small flow for its profile."""
        findings = super().run(engine, study)
        if not engine.refuses(self.case.job(FLOWING)):
            (output,) = engine.run([self.case.job(FLOWING)])
            if not isinstance(output, EngineError):
                findings.evidence = engine.title, profile_in(output)
        return findings


class LayersDisplay(Display):
    """Shows the profile of a small flow."""

    def sections(
        self, main: Findings | None, solvers: Findings, engines: Mapping[str, Findings]
    ) -> Sequence[Section]:
        """Return the limit in words and the profile of a small flow."""
        return () if main is None or main.evidence is None else (flow_section(*main.evidence),)


def steps_of(case: Layers) -> float:
    """Return the number of steps that a descent is expected to take."""
    slowness = float(np.interp(case.layers, [*LOWERING], [*LOWERING.values()]))
    longest = (case.first_angle - case.lowest_angle) / case.rate / LEAST_SPEED
    expected = slowness * case.length * LOWERING_RATE / case.rate
    lowering = min(expected, longest, case.time_limit)
    raising = 0.0 if case.rise == 0.0 else RISE_DEG / case.rise
    return (20.0 + case.flow_time + lowering + raising) / case.step


CASE = LayersCase()
