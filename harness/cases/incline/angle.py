"""Critical angles of the incline in an engine: at one stiffness and step, and extrapolated.

The angle of rigid spheres is the limit of the step to zero, then of the stiffness to infinity, by
passage with the plastic contact. LAMMPS damps by the velocity of half a step ago: the angle is
of first order in the step. In the stiffness the order k^(-1/2) cancels, as the grain is pressed in
and comes back while it moves on; the error falls as 1/k with a next term k^(-3/2). With friction
so little that shocks slide, the order k^(-1/2) does not cancel: -8.5 deg zeta / sqrt(k) at
mu = 0.03, k in N/m.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import Field, model_validator

from harness import __version__
from harness.cases.bench import Bench
from harness.cases.incline.closed_form import check_passage, rigid_angle
from harness.cases.incline.runs import Run, read
from harness.cases.incline.search import PHASES, CriticalAngle, Measure, prepared, search
from harness.cases.incline.system import Incline, Route, friction_text, job_of, scene_of
from harness.engines.base import Job, Output
from harness.engines.output import Provenance, motion_tables
from harness.engines.process import cores, parallel_map
from harness.errors import EngineError, Unsupported
from harness.model.base import Parameters
from harness.model.law import PLASTIC
from harness.report.content import Plottable, power, value_text
from harness.results.series import Limit, limit
from harness.store.cache import EngineChoice, opened
from harness.theory.incline import sticking_friction

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes

    from harness.report.figures import Figure

Progress = Callable[[str, int, int], None]  # stage, done, expected
REFERENCE = Provenance("reference", __version__, how="compiled")
STEP_EXPONENTS, STIFFNESS_EXPONENTS = (1.0,), (1.0, 1.5)
SLIDING_EXPONENTS = (0.5, 1.0)  # of the stiffness, where shocks slide
RUNS: dict[Route, int] = {"passage": 12, "steady": 16}  # of a search, about
DIGITS = 15  # of an engine whose margins are the reference's to round-off


def critical_angle(
    case: Incline | None = None,
    *,
    method: Route = "passage",
    tolerance_deg: float | None = None,
    phases: int = PHASES,
    wells: int | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> CriticalAngle:
    """Return the critical angle [deg] of a case, the source's contact unless given.

    ``method`` is ``passage`` or ``steady``; ``tolerance_deg`` is the resolution of the search.
    ``phases`` are the starts within a step of a passage, ``wells`` those to pass in steady motion.
    ``engine`` is an open one, or the name of one that is opened and whose runs are kept, LAMMPS
    unless given; ``fresh`` runs again what was kept. Raise EngineError for a run that failed,
    RequestError for a contact that rebounds too much for a passage.
    """
    case, done = prepared(case or Incline(), method, wells), 0
    with opened(engine, fresh=fresh) as running:
        run = engine_measure(Bench(running), method)

        def measure(cases: Sequence[Incline]) -> Sequence[Run]:
            nonlocal done
            runs = run(cases)
            done += len(runs)
            if progress is not None:
                progress(f"runs, {method}", done, max(RUNS[method], done))
            return runs

        return search(measure, case, method, tolerance_deg, phases)


def extrapolated_critical_angle(
    case: Incline | None = None,
    *,
    ladder: Ladder | None = None,
    engine: EngineChoice = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> ExtrapolatedAngle:
    """Return the critical angle [deg] with the step to zero, then the stiffness to infinity.

    By passage, with the plastic contact unless a case is given. Raise the first EngineError;
    raise RequestError for a contact that rebounds too much, before any run.
    """
    case, ladder = case or Incline(contact=PLASTIC), ladder or Ladder()
    for refined in ladder.cases(case):
        check_passage(refined)
    with opened(engine, fresh=fresh) as running:
        return extrapolated_on(Bench(running), ladder, case, progress)


# ---- on a bench, which runs nothing twice


def angle_on(
    bench: Bench, case: Incline, method: Route = "passage", tolerance_deg: float | None = None
) -> CriticalAngle:
    """Return the critical angle of a case in the engine of a bench.

    The reference guides a search where the engine writes as many digits.
    """
    measure, case = engine_measure(bench, method), prepared(case, method)
    guide = reference_measure(bench, method) if bench.engine.traits.digits >= DIGITS else None
    return search(measure, case, method, tolerance_deg, reference=guide)


def reference_angle(bench: Bench, case: Incline) -> CriticalAngle:
    """Return the critical angle by passage in the reference, by the bench's conventions."""
    return search(reference_measure(bench, "passage"), case, "passage")


def extrapolated_on(
    bench: Bench, ladder: Ladder, case: Incline, progress: Progress | None = None
) -> ExtrapolatedAngle:
    """Return the limit of the critical angle in the engine of a bench."""
    cases, done = ladder.cases(case), 0

    def angle_of(refined: Incline) -> CriticalAngle:
        nonlocal done
        angle = angle_on(bench, refined)
        done += 1
        if progress is not None:
            progress("critical angles", done, len(cases))
        return angle

    return extrapolate(parallel_map(angle_of, cases, cores()))


def engine_measure(
    bench: Bench,
    route: Route,
    job: Callable[..., Job] = job_of,
    reader: Callable[..., Run] = read,
) -> Measure:
    """Return a function that runs cases in the engine of a bench.

    Raise Unsupported for a case that the engine refuses, the first EngineError of a run.
    """

    def measure(cases: Sequence[Incline]) -> list[Run]:
        jobs = [job(case, route) for case in cases]
        if reason := next(filter(None, map(bench.refusal, jobs)), ""):
            raise Unsupported(reason)
        runs = []
        for case, outcome in zip(cases, bench.outcomes(jobs), strict=True):
            if isinstance(outcome, EngineError):
                raise outcome
            try:
                runs.append(reader(case, route, outcome))
            except EngineError as error:
                raise error.with_log(error.log or outcome.log) from None
        return runs

    return measure


def reference_measure(bench: Bench, route: Route) -> Measure:
    """Return a function that runs cases in the reference, by the conventions of a bench's engine.

    Raise Unsupported for a case that the engine cannot run.
    """

    def run(case: Incline) -> Run:
        scene = scene_of(case, route)
        tables = motion_tables(bench.reference(scene), scene, sampled=False)
        return read(case, route, Output((), REFERENCE, tables, title="the reference"))

    return lambda cases: parallel_map(run, cases, cores())


# ---- step to zero, stiffness to infinity


class Ladder(Parameters):
    """Stiffnesses over that of a case, and steps per contact time, of an extrapolation."""

    # fmt: off
    factors: tuple[float, ...] = Field(
        (0.1, 10**-0.5, 1.0, 10**0.5, 10.0), description="[-] stiffness over the case's stiffness")
    steps_per_contact: tuple[float, ...] = Field(
        (50.0, 100.0, 200.0, 400.0), description="[-] steps per contact time")
    # fmt: on

    @model_validator(mode="after")
    def _check(self) -> Ladder:
        if len(set(self.factors)) < 4 or min(self.factors) <= 0.0:
            raise ValueError(f"factors = {self.factors}: needs four different positive ones")
        if len(set(self.steps_per_contact)) < 3:
            raise ValueError(f"steps_per_contact = {self.steps_per_contact}: needs three different")
        return self

    def cases(self, case: Incline) -> list[Incline]:
        """Return the refined cases, the costliest first so that no core idles at the end."""
        refined = [
            case.replace(stiffness=case.stiffness * factor, steps_per_contact=steps)
            for factor in self.factors
            for steps in self.steps_per_contact
        ]
        return sorted(refined, key=lambda case: case.step)


QUICK_LADDER = Ladder(factors=(0.1, 10**-0.5, 1.0, 10**0.5), steps_per_contact=(50.0, 100.0, 200.0))
FULL_LADDER = Ladder(factors=(0.1, 10**-0.5, 1.0, 10**0.5, 10.0, 10**1.5, 100.0))


@dataclass(frozen=True, repr=False)
class ExtrapolatedAngle(Plottable):
    """The critical angle of rigid spheres from an engine, with the angles behind it.

    ``at_stiffness`` has the limit in the step at each stiffness [N/m], ``rigid`` the limit of
    those in the inverse stiffness.
    """

    angles: tuple[CriticalAngle, ...]
    at_stiffness: dict[float, Limit]
    rigid: Limit

    @property
    def value(self) -> float:
        """Return the extrapolated critical angle [deg]."""
        return self.rigid.value

    @property
    def uncertainty(self) -> float:
        """Return its uncertainty [deg]."""
        return self.rigid.uncertainty

    def to_json(self) -> dict[str, Any]:
        """Return the result, JSON-ready; stiffness and step are null: extrapolated."""
        return {
            **self.angles[0].to_json(),
            "critical_angle_deg": self.value,
            "uncertainty_deg": self.uncertainty,
            "extrapolated": True,
            "stiffness_N_per_m": None,
            "steps_per_contact": None,
            "runs": sum(len(angle.runs) for angle in self.angles),
            "steps": sum(angle.steps for angle in self.angles),
            "order_in_stiffness": self.rigid.order,
            "order_in_stiffness_interval": list(self.rigid.order_interval),
            "limits": [
                {
                    "stiffness_N_per_m": stiffness,
                    "critical_angle_deg": at.value,
                    "uncertainty_deg": at.uncertainty,
                    "order_in_step": at.order,
                    "order_in_step_interval": list(at.order_interval),
                }
                for stiffness, at in self.at_stiffness.items()
            ],
            "ladder": self.to_frame().to_dict(orient="records"),
        }

    def to_frame(self) -> pd.DataFrame:
        """Return the angles as a table: stiffness, steps per contact, angle, uncertainty."""
        import pandas as pd

        names = ("stiffness_N_per_m", "steps_per_contact", "critical_angle_deg", "uncertainty_deg")
        return pd.DataFrame([{name: a.to_json()[name] for name in names} for a in self.angles])

    def summary(self) -> dict[str, str]:
        """Return the angle, the contact, the stiffnesses, the expected angle and the engine."""
        first, stiffnesses = self.angles[0], [*self.at_stiffness]
        expected, model = rigid_angle(first.case)
        return {
            "critical angle": value_text(self.value, self.uncertainty, "deg"),
            "case": f"incline, {first.case.contact.name} contact{friction_text(first.case)}, step "
            "to zero, then stiffness to infinity",
            "ladder": f"{len(self.angles)} angles, k = {power(min(stiffnesses))} to "
            f"{power(max(stiffnesses))} N/m",
            "theory": f"{expected:.5f} deg ({model})",
            "engine": first.output.provenance.label,
        }

    def draw(self) -> Figure:
        """Draw the critical angle over the step, and its limits over the stiffness."""
        from harness.report.figures import BLACK, COLOURS, MARKERS, label, legend_below, panels

        figure = panels(1, 2, 3.8, 3.9)
        over_step, over_stiffness = figure.axes
        for number, (stiffness, at) in enumerate(self.at_stiffness.items()):
            colour, marker = COLOURS[number % len(COLOURS)], MARKERS[number % len(MARKERS)]
            name, fine = f"k = {power(stiffness)} N/m", np.linspace(0.0, at.h.max(), 50)
            over_step.errorbar(
                at.h, at.y, at.errors, fmt=marker, color=colour, label=name, capsize=2
            )
            over_step.plot(fine, at.curve(fine), color=colour, lw=0.9)
            over_step.plot(0.0, at.value, marker, color=colour, mfc="white", clip_on=False)
        over_step.locator_params(axis="x", nbins=5, steps=[1, 2, 5, 10])
        label(over_step, "1 / steps per contact time", "critical angle (deg)", "step to zero")
        self._draw_over_stiffness(over_stiffness)
        expected, _ = rigid_angle(self.angles[0].case)
        for axes in figure.axes:
            axes.axhline(expected, color=BLACK, ls="--", lw=1, label=f"theory {expected:.5f} deg")
        legend_below(figure, 3)
        return figure

    def _draw_over_stiffness(self, axes: Axes) -> None:
        from harness.report.figures import BLUE, GREEN, label

        rigid = self.rigid
        name = f"{self.angles[0].output.provenance.engine}, step to zero"
        axes.errorbar(
            1.0 / rigid.h, rigid.y, rigid.errors, fmt="o", color=BLUE, capsize=2, label=name
        )
        fine = np.geomspace(rigid.h.min() / 30.0, rigid.h.max(), 100)
        order = f"fit, observed order {rigid.order:.2f}"
        axes.plot(1.0 / fine, rigid.curve(fine), color=BLUE, lw=0.9, label=order)
        low, high = rigid.value - rigid.uncertainty, rigid.value + rigid.uncertainty
        text = f"limit {rigid.value:.5f} ± {rigid.uncertainty:.5f} deg"
        axes.axhspan(low, high, color=GREEN, alpha=0.25, label=text)
        axes.set_xscale("log")
        label(axes, "stiffness k (N/m)", "critical angle (deg)", "then stiffness to infinity")


def extrapolate(angles: Sequence[CriticalAngle]) -> ExtrapolatedAngle:
    """Return the limit of angles over stiffnesses and steps.

    Raise RequestError for fewer than three steps at a stiffness or fewer than four stiffnesses.
    """

    def stiffness(angle: CriticalAngle) -> float:
        return angle.case.stiffness

    def step_limit(group: Sequence[CriticalAngle]) -> Limit:
        steps = [1.0 / angle.case.steps_per_contact for angle in group]
        values, errors = [a.value for a in group], [a.mean_error for a in group]
        return limit(steps, values, errors, STEP_EXPONENTS)

    ordered = sorted(angles, key=lambda a: (stiffness(a), a.case.steps_per_contact))
    limits = {k: step_limit(list(group)) for k, group in groupby(ordered, key=stiffness)}
    values = [at.value for at in limits.values()]
    errors = [at.uncertainty for at in limits.values()]
    exponents = SLIDING_EXPONENTS if _shocks_slide(angles[0].case) else STIFFNESS_EXPONENTS
    rigid = limit([1.0 / k for k in limits], values, errors, exponents)
    return ExtrapolatedAngle(tuple(ordered), limits, rigid)


def _shocks_slide(case: Incline) -> bool:
    """Return whether the friction of a case is too small for the shock of a rolling grain."""
    half = math.degrees(case.half_angle)
    return 0.0 < case.friction < sticking_friction(half, case.inertia)
