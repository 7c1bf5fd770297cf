"""The case ``tower``: one run of it, its cost, its verification, its parts of the report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache

from harness.cases.contract import Case, LevelName, Measured, Reference
from harness.cases.tower.engine_checks import other_findings
from harness.cases.tower.run import MARGIN, NAME, SOLVERS, covering, read, tower
from harness.cases.tower.system import (
    TEMPLATE,
    Timing,
    TowerRunParameters,
    check_duration,
    job_of,
    timing_of,
)
from harness.cases.tower.verification import engine_findings, own_findings, planned
from harness.cases.verification import Study, Verification
from harness.comparison.verdicts import Planned
from harness.comparison.verification import Findings
from harness.engines.contract import Engine, Job, Output
from harness.engines.cost import engine_seconds
from harness.engines.traits import Traits
from harness.errors import EngineOutputError, RequestError
from harness.observables.tower import (
    SEARCH,
    TowerRun,
    energy_drift,
    grain_velocity_at,
    impulse,
    peak_force,
    turnaround,
    window_end,
)
from harness.parameters.tower import Tower
from harness.theory import chain

SAMPLES_PER_T0 = 1000


def tower_seconds(
    case: Tower,
    solver: str | None = None,
    rules: Traits | None = None,
    *,
    duration: float = SEARCH,
    steps_per_contact: float | None = None,
) -> float:
    """Return what a tower is expected to take [s] for ``duration`` [t0].

    In an engine of ``rules``, else in a solver of this package, RK4 unless another is named.
    Raise RequestError for a step or duration that cannot be.
    """
    check_duration(duration)
    if rules is not None:
        steps = timing_of(case, duration, steps_per_contact, 1).steps
        return engine_seconds(steps, case.particles, rules)
    from harness.solvers.chain import rk4  # kernels, which other cases do without
    from harness.solvers.chain.motion import exact_seconds, rk4_step_seconds, select_step

    if solver == "exact":
        return exact_seconds(case.particles, duration, SAMPLES_PER_T0 * duration)
    seconds = duration * case.contact_time
    steps = rk4.step_count(seconds, select_step(case, None, steps_per_contact))
    return steps * rk4_step_seconds(case.law, case.particles)


class TowerCase(Case[TowerRunParameters]):
    """A grain that runs into a row of particles at rest: force, impulse, energy."""

    name = NAME
    group = "chains"
    template = TEMPLATE
    verified_by = "harness.cases.tower.case:TowerVerification"
    shown_by = "harness.cases.tower.report:TowerDisplay"
    solvers = ("exact", "rk4")

    @property
    def presets(self) -> Mapping[str, TowerRunParameters]:
        """Return towers of the source: three particles under each law, and the tallest."""
        return {
            "source-overlap": TowerRunParameters(),
            "source": TowerRunParameters(law="deformable"),
            "source-tallest": TowerRunParameters(height=19, law="deformable"),
            "grain-on-one": TowerRunParameters(height=1),
        }

    def job(self, parameters: TowerRunParameters) -> Job:
        """Return the job of one run, long enough for the turnaround window."""
        return job_of(parameters.tower, _timing(parameters))

    def read(
        self, parameters: TowerRunParameters, output: Output, traits: Traits
    ) -> Mapping[str, float]:
        """Return the quantities of one run; raise EngineOutputError for a bad output."""
        run = read(parameters.tower, _timing(parameters), output, traits)
        try:
            return _quantities(run, parameters)
        except RequestError as error:
            raise EngineOutputError(f"{output.who}: {error}") from error

    def references(self, parameters: TowerRunParameters, traits: Traits) -> Mapping[str, Reference]:
        """Return the exact propagator's values, in closed form for a grain on one fixed particle.

        Energy is conserved: its drift is 0.
        """
        integrated = _quantities(_exact(parameters), parameters)
        references = {name: Reference(value, "integrated") for name, value in integrated.items()}
        closed = {name: Reference(v, "closed form") for name, v in _closed_form(parameters).items()}
        return references | closed

    def solve(self, parameters: TowerRunParameters, solver: str) -> Measured:
        """Run the exact propagator or RK4."""
        if solver not in SOLVERS:
            return super().solve(parameters, solver)
        run = tower(
            parameters.tower,
            solver=solver,
            duration=_duration(parameters),
            steps_per_contact=parameters.steps_per_contact,
        )
        return Measured(_quantities(run, parameters))

    def seconds(
        self, parameters: TowerRunParameters, rules: Traits | None, solver: str = ""
    ) -> float:
        """Return what a run and the exact one that it is held against are expected to take [s]."""
        case, duration = parameters.tower, parameters.duration
        of_engine = tower_seconds(
            case, solver, rules, duration=duration, steps_per_contact=parameters.steps_per_contact
        )
        return of_engine + tower_seconds(case, "exact", duration=duration)


@lru_cache(maxsize=64)
def _exact(parameters: TowerRunParameters) -> TowerRun:
    """Return the exact run that covers the duration and the turnaround window."""
    run = tower(parameters.tower, solver="exact", duration=parameters.duration)
    return covering(run, "turnaround")


def _duration(parameters: TowerRunParameters) -> float:
    """Return how long a run must be to cover the duration and the turnaround window [t0]."""
    end = window_end(_exact(parameters), "turnaround") / parameters.contact_time
    return parameters.duration if end < parameters.duration else end * MARGIN


def _timing(parameters: TowerRunParameters) -> Timing:
    return timing_of(parameters.tower, _duration(parameters), parameters.steps_per_contact, None)


def _quantities(run: TowerRun, parameters: TowerRunParameters) -> dict[str, float]:
    """Return the declared quantities of a run."""
    end = min(parameters.duration * parameters.contact_time, float(run.time[-1]))
    return {
        "peak_force_N": peak_force(run),
        "impulse_Ns": impulse(run),
        "turnaround_s": turnaround(run),
        "energy_drift": energy_drift(run),
        "final_velocity_m_per_s": grain_velocity_at(run, end),
    }


def _closed_form(parameters: Tower) -> dict[str, float]:
    """Return what is known in closed form: the drift, and one contact with a fixed particle."""
    values = {"energy_drift": 0.0}
    single = (
        parameters.height == 1 and parameters.base == "fixed" and parameters.start == "touching"
    )
    if not single or parameters.speed == 0.0:
        return values
    first, second = parameters.each("stiffness")
    stiffness, mass = 2 / (1 / first + 1 / second), parameters.each("mass")[0]
    impact = (mass, stiffness, parameters.speed, parameters.gravity)
    return values | {
        "peak_force_N": chain.peak_force_on_fixed(*impact),
        "impulse_Ns": chain.impulse_on_fixed(*impact),
        "turnaround_s": chain.contact_time_on_fixed(*impact) / 2,
    }


class TowerVerification(Verification):
    """Holds an engine against the exact propagator, and solvers against one another."""

    def planned(self, level: LevelName, engine: Engine) -> Sequence[Planned]:
        """Return the checks of each law, of the tall tower and of the impulse table."""
        return planned(level, engine)

    def run(self, engine: Engine, study: Study) -> Findings:
        """Hold an engine against the exact propagator, law by law.

        Of another engine its finest towers, and the order of its error.
        """
        return (engine_findings if study.role == "main" else other_findings)(engine, study)

    def run_solvers(self, study: Study) -> Findings:
        """Hold RK4 and the exact propagator against each other and closed forms."""
        return own_findings(study)


CASE = TowerCase()
