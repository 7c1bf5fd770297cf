"""The case ``incline``: one passage, its closed form, and the critical angle as a search."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from importlib import resources
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from pydantic import Field

from harness.cases.base import COLUMNS, Case, Check, Level, Quantity, Value, path_in
from harness.cases.bench import OWN, Bench
from harness.cases.incline import checks
from harness.cases.incline import search as searches
from harness.cases.incline.angle import CriticalAngle
from harness.cases.incline.closed_form import ONE_SHOCK, expected_angle, rebound, rigid_angle
from harness.cases.incline.runs import Fate, expected_steps, job_of, read
from harness.cases.incline.system import Incline, OverRow, Route
from harness.engines.base import Engine, Job, Output
from harness.errors import EngineError, RequestError, Unsupported
from harness.model.base import Parameters
from harness.model.law import CLIPPED, CONTACTS, PLASTIC, SOURCE
from harness.report.content import Discs, Drawing, Opening, Section
from harness.theory import incline as theory

if TYPE_CHECKING:
    from harness.report.figures import Figure

R = TypeVar("R", bound=OverRow)
Result = TypeVar("Result")


class Search(Parameters):
    """How a critical angle is searched for."""

    # fmt: off
    method: Route = Field(
        "passage", description="[-] root of the energy over one well, or smallest moving angle")
    tolerance: float | None = Field(
        None, ge=searches.FINEST_DEG, le=searches.COARSEST_DEG,
        description="[deg] resolution of the search; none: 0.001 by passage, 0.005 by steady")
    starts: int = Field(
        searches.PHASES, ge=searches.FEWEST_PHASES, le=1000,
        description="[-] starts within a step, a passage is their mean, its uncertainty their range"
    )
    # fmt: on


class OverRowCase(Case[R]):
    """A grain on a tilted row: one passage, and the critical angle by a search."""

    group = "incline"
    search_options = Search
    quantities = (
        Quantity("margin_over_mgd", "1", "energy left after one well, less that of a grain at rest "
                 "on the next crest, in m g d", 0.05, rigid=True),
        Quantity("moves_on", "1", "1 where the grain passes the well, 0 where it is trapped"),
        Quantity("touching", "1", "1 where the grain is in contact at the end"),
        Quantity("time_s", "s", "duration of the motion", lambda p: p.unit_of_time),
        Quantity("steps", "1", "time steps that were taken", lambda p: p.unit_of_time / p.step),
        Quantity("critical_angle_deg", "deg", "smallest angle at which the grain keeps moving",
                 10.0, varies=("angle", "phase")),
        Quantity("uncertainty_deg", "deg", "of the critical angle: range of single runs, and of "
                 "the search", 1e-3, varies=("angle", "phase")),
        Quantity("monotone", "1", "1 where no angle above a moving one was trapped, 0 where one "
                 "was", varies=("angle", "phase")),
        Quantity("runs", "1", "runs behind the critical angle", 10.0, varies=("angle", "phase")),
    )  # fmt: skip

    exact_by = "rigid grains"  # in closed form; by events with rebounds, integrated with friction
    run_job: ClassVar[Callable[..., Job]]  # of a case, a route and the steps between samples

    def job(self, parameters: R) -> Job:
        """Return the job of one passage."""
        return self.run_job(parameters, "passage")

    def measure_on(self, bench: Bench, route: Route) -> searches.Measure:
        """Return a function that runs cases of a route on a bench."""
        return searches.engine_measure(bench, route, self.run_job)

    def measure(self, parameters: R, output: Output) -> Mapping[str, float]:
        """Return the outcome of one passage."""
        run = read(parameters, "passage", output)
        fate = {"moves_on": float(run.fate is Fate.MOVES_ON), "touching": float(run.touching)}
        lasted = {"time_s": run.time_s, "steps": float(run.steps)}
        return {"margin_over_mgd": run.margin, **fate, **lasted}

    def critical_angle(self, parameters: R, bench: Bench, **options: Any) -> CriticalAngle:
        """Return the critical angle [deg]; ``options`` are those of :class:`Search`.

        Raise RequestError for a contact that the method cannot measure.
        """
        chosen = Search(**options)
        measure, case = self.measure_on(bench, chosen.method), parameters
        case = searches.prepared(case, chosen.method)
        return searches.search(measure, case, chosen.method, chosen.tolerance, chosen.starts)

    def search(
        self, names: Sequence[str], parameters: R, bench: Bench, **options: Any
    ) -> Mapping[str, Value]:
        """Search for the critical angle, as :meth:`critical_angle` does."""
        angle = self.critical_angle(parameters, bench, **options)
        values = {"critical_angle_deg": angle.value, "uncertainty_deg": angle.uncertainty,
                  "monotone": float(angle.monotone), "runs": float(len(angle.runs))}  # fmt: skip
        errors = {"critical_angle_deg": angle.uncertainty}
        return {n: Value(values[n], errors.get(n, 0.0)) for n in names if n in values}


class InclineCase(OverRowCase[Incline]):
    """A grain on a tilted row of fixed spheres: the critical angle, with and without friction."""

    name = "incline"
    has_figures = True
    summary = "A grain on a tilted row of fixed spheres: the critical angle of steady motion."
    parameters = Incline
    presets = {  # noqa: RUF012 - as the base declares it
        name: Incline(contact=contact, steps_per_contact=100.0 if contact is PLASTIC else 50.0)
        for name, contact in CONTACTS.items()
    }
    sources = {SOURCE.name: "the source paper, arXiv 2409.13633"}  # noqa: RUF012
    solvers = ("hard-sphere",)
    run_job = staticmethod(job_of)

    def exact(self, parameters: Incline) -> Mapping[str, float]:
        """Return the margin and the critical angle of rigid grains, of contacts that allow it."""
        p, values = parameters, dict[str, float]()
        if rebound(p.contact) <= ONE_SHOCK and p.friction == 0.0:
            half = math.degrees(p.half_angle)
            margin = theory.passage_margin(p.angle, theory.kept_speed(half, 0.0) ** 2, half)
            values["margin_over_mgd"] = margin * p.arm / p.diameter
        if (angle := expected_angle(p)) is not None:
            values["critical_angle_deg"] = angle
        return values

    def cost(self, parameters: Incline) -> float:
        """Return the steps of a passage times the bodies, for an estimate of its time."""
        return expected_steps(parameters, "passage") * (parameters.spheres + 1)

    def solve(self, parameters: Incline, solver: str) -> Mapping[str, float]:
        """Follow the grain over rigid spheres from event to event, without friction."""
        if solver not in self.solvers:
            return super().solve(parameters, solver)
        if not parameters.is_plain:
            raise RequestError("hard-sphere: takes no friction, and a grain of the row's size")
        from harness.solvers import hard_sphere

        e = rebound(parameters.contact)
        fate, energy, _, slid, _ = hard_sphere.passage(parameters.angle, e)
        outcome = {"moves_on": float(fate == hard_sphere.MOVES_ON), "touching": float(slid)}
        angle = hard_sphere.critical_angle(e)
        return {"margin_over_mgd": energy, **outcome, "critical_angle_deg": angle}

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine, of all levels."""
        return checks.checks(engine)

    def checks_up_to(self, engine: Engine, level: Level) -> Iterable[Check]:
        """Return the checks of an engine up to a level; those of longer ones are not made."""
        return checks.checks(engine, level)

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return the sections of a report: the angle, the contacts, friction."""
        return _sections([bench for name, bench in benches.items() if name != OWN])

    def film_job(self, parameters: Incline, frames: int) -> Job:
        """Return the job of steady motion, with so many samples."""
        steps = expected_steps(parameters, "steady")
        return job_of(parameters, "steady", max(1, round(steps / max(1, frames - 1))))

    def discs(self, parameters: Incline, output: Output) -> Discs:
        """Return the grain over the row, tilted as it is, with its speed [m/s]."""
        path, d = path_in(output), parameters.diameter
        x, y, vx, vy = (path[name] for name in COLUMNS[1:])
        row = np.arange(math.floor(x.min() / d), math.ceil(x.max() / d) + 2) * d
        sine, cosine = math.sin(parameters.tilt), math.cos(parameters.tilt)
        return Discs(
            f"The grain over the bumps at {parameters.angle:g} deg",
            path["time_s"],
            (x * cosine + y * sine)[:, None],
            (y * cosine - x * sine)[:, None],
            np.array([0.5 * parameters.grain]),
            fixed=np.column_stack([row * cosine, -row * sine, np.full(len(row), 0.5 * d)]),
            value=np.hypot(vx, vy)[:, None],
            value_label="speed (m/s)",
        )


# ---- what a report shows

STEPS = (
    "In a well the velocity turns by 60 deg. Without rebound its part along the old path is lost "
    "but for cos 60 deg = 1/2, so a quarter of the energy is left: E becomes (E + m g d sin θ) / 4 "
    "from well to well.",
    "The steady energy is E* = m g d sin θ / 3. The next crest takes C = m g d (1 - cos(30 deg - "
    "θ)).",
    "E* = C at θ_c = 2 atan(tan(15 deg) / 3) = "
    f"{theory.critical_angle():.4f} deg: below it the grain is trapped.",
)
TERMS = (
    ("well", "where the grain touches two fixed spheres; the shock happens there"),
    ("crest", "the highest point of the path, right above a sphere"),
    ("passage", "a grain comes over a crest at rest; the energy left after one well, less that of "
     "the next crest, is 0 at θ_c"),
    ("steady", "the second way to θ_c: long runs, in which the grain moves on or is trapped"),
    ("tail", "the part of a contact in which its dashpot pulls, as it opens; kept, or clipped"),
    ("plastic", "a contact with strong damping and no tail: it hardly rebounds, as in the theory"),
)  # fmt: skip
CONTACTS_TEXT = f"""\
- *source* (e = 1e-20, tail kept): the attractive tail holds back the contact that opens. The angle
  rises above the closed form by about k^(-1/2) as the step goes to zero; at 50 steps the tail is
  mostly skipped, and the two errors nearly cancel.
- *clipped* (critical damping, no tail): smooth in the step, but it rebounds with
  {rebound(CLIPPED):.3f}.
- *plastic* (damping ratio {PLASTIC.zeta:g}, no tail): first order in the step and nearly in 1/k.
  This is the e = 0 of the theory.

With restitution a grain bounces several times within a well. Neither reading of the theory of one
shock describes it: rigid spheres by events do (`dem-harness theory --restitution`)."""
FRICTION_TEXT = """\
A grain with friction rolls. The share s of its speed that a shock leaves grows from cos(2 phi) to
(cos(2 phi) + beta) / (1 + beta), and the critical angle falls. Slight friction raises it first: it
retards a grain that hardly spins yet. Between the closed forms a rigid grain is integrated with
Coulomb's limit in shocks and on arcs. The contact's tangential dashpot is beta / (1 + beta) of the
normal one: with equal ones, a shock sticks from mu = tan(phi) on."""


def _sections(benches: Sequence[Bench]) -> list[Section]:
    """Return the sections of a report on the engines of some benches; nothing is run for it."""
    return [_opening(benches), Section("The contacts", CONTACTS_TEXT), *_friction(benches)]


def _opening(benches: Sequence[Bench]) -> Section:
    drawings = [
        Drawing(
            "critical-angle-extrapolation",
            f"Critical angle, extrapolated: {bench.engine.title}",
            "Plastic contact, by passage. Left: first order in the step; open symbols are limits. "
            "Right: those limits over the stiffness. Dashed: the closed form.",
            limit.draw,
        )
        for bench in benches
        for ladder in (searches.FULL_LADDER, searches.Ladder(), searches.QUICK_LADDER)
        if (limit := _measured(bench, checks.ladder_jobs(checks.PLASTIC_CASE, ladder),
                               searches.extrapolated_on, ladder, checks.PLASTIC_CASE))
    ]  # fmt: skip
    sketch = resources.files(__package__) / "sketch.svg"
    opening = Opening(
        "At what angle does a grain without friction keep moving?",
        sketch.read_text(encoding="utf-8"),
        STEPS,
        "Harper, Dufek and Breard (arXiv:2409.13633), after the model of Quartier et al. (2000)",
        TERMS,
        figure=drawings[0] if drawings else None,
    )
    return Section("The critical angle", opening=opening)


def _friction(benches: Sequence[Bench]) -> Iterator[Section]:
    cases = [checks.friction_case(mu) for mu in (*checks.SLIGHT_FRICTIONS, *checks.FRICTIONS)]
    measured = {
        bench.engine.title: {
            case.friction: angle.value
            for case in cases
            if (angle := _measured(bench, checks.first_jobs(case), searches.angle_on, case))
        }
        for bench in benches
    }
    measured = {title: angles for title, angles in measured.items() if angles}
    if measured:
        without, rolling = (rigid_angle(checks.friction_case(mu))[0] for mu in (0.0, 1.0))
        drawing = Drawing(
            "critical-angle-friction",
            "Critical angle over friction",
            f"Equal spheres, k = 1e6 N/m, 50 steps: from {without:.4f} deg without "
            f"friction to {rolling:.4f} deg without slip. With little "
            "friction stiffness and step move the angle by hundredths of a degree, and so does a "
            "dashpot that Coulomb's limit leaves out.",
            partial(over_friction, measured),
        )
        yield Section("Friction", FRICTION_TEXT, drawings=(drawing,))


def _measured(
    bench: Bench, jobs: Sequence[Job], measure: Callable[..., Result], *args: Any
) -> Result | None:
    """Return the result of a search whose first jobs were run, None where they were not."""
    try:
        return measure(bench, *args) if bench.has_run(jobs) else None
    except (EngineError, Unsupported):  # it has a row
        return None


def over_friction(measured: Mapping[str, Mapping[float, float]]) -> Figure:
    """Draw the critical angle over friction: theory as a line, angles [deg] of each engine."""
    from harness.report import figures as look

    figure = look.panels(1, 1, 7.2, 4.2)
    (axes,) = figure.axes
    most = max(friction for angles in measured.values() for friction in angles)
    frictions = np.concatenate([np.linspace(0.0, 0.12, 41), np.linspace(0.13, most, 20)])
    rigid = [rigid_angle(checks.friction_case(float(mu)))[0] for mu in frictions]
    axes.plot(frictions, rigid, color=look.BLACK, lw=1.2, label="theory, rigid grain")
    for number, (name, angles) in enumerate(measured.items(), 1):
        axes.plot([*angles], [*angles.values()], look.MARKERS[number % 6], mfc="none", label=name,
                  color=look.COLOURS[number % 7])  # fmt: skip
    bound = theory.rolling_friction(theory.STATIC_ANGLE_DEG, theory.INERTIA["sphere"])
    if bound <= most:
        axes.axvline(bound, color="0.5", ls=":", label=f"rolls without slip from {bound:.4f} on")
    look.label(axes, "friction coefficient", "critical angle (deg)")
    look.legend_below(figure, 3)
    return figure


CASE = InclineCase()
