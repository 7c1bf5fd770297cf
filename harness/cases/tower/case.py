"""The case ``tower``: one run of it, its checks and its sections of a report."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

from harness.cases.base import Case, Check, Quantity
from harness.cases.bench import Bench
from harness.cases.tower import checks, show
from harness.cases.tower.impulse import MARGIN, Runner
from harness.cases.tower.parameters import SEARCH, Tower, TowerParameters
from harness.cases.tower.runs import Setup, TowerRun, make_setup, read, solve
from harness.cases.tower.windows import (
    energy_drift,
    grain_velocity_at,
    impulse,
    peak_force,
    turnaround,
    window_end,
)
from harness.engines.base import Engine, Job, Output
from harness.errors import EngineOutputError, RequestError
from harness.report.content import Discs, Section


def _force_scale(case: Tower) -> float:
    mass, stiffness = (case.each(name)[0] for name in ("mass", "stiffness"))
    return mass * case.gravity + case.speed * float((mass * stiffness) ** 0.5)


def _impulse_scale(case: Tower) -> float:
    return case.each("mass")[0] * (2.0 * case.speed + case.gravity * case.contact_time)


class TowerCase(Case[TowerParameters]):
    """A grain that runs into a row of particles at rest: force, impulse, energy."""

    name = "tower"
    group = "chains"
    summary = "A grain that runs into a row of particles at rest: force, impulse, energy."
    parameters = TowerParameters
    quantities = (
        Quantity("peak_force_N", "N", "largest contact force on the grain", _force_scale),
        Quantity("impulse_Ns", "N s", "impulse on the grain, turnaround window", _impulse_scale),
        Quantity("turnaround_s", "s", "time at which grain and base are closest",
                 lambda case: case.contact_time),
        Quantity("energy_drift", "1", "largest change of the energy, over its largest value"),
        Quantity("final_velocity_m_per_s", "m/s", "velocity of the grain after the duration",
                 lambda case: case.speed + case.gravity * case.contact_time),
    )  # fmt: skip
    presets = {  # noqa: RUF012 - as the base declares it
        "source-overlap": TowerParameters(),
        "source": TowerParameters(law="deformable"),
        "source-tallest": TowerParameters(height=19, law="deformable"),
        "grain-on-one": TowerParameters(height=1),
    }
    sources = {"source": "the source paper, arXiv 2409.13633"}  # noqa: RUF012
    solvers = ("exact", "rk4")

    def job(self, parameters: TowerParameters) -> Job:
        """Return the job of one run, long enough for the turnaround window."""
        return _setup(parameters).job

    def measure(self, parameters: TowerParameters, output: Output) -> Mapping[str, float]:
        """Return the quantities of one run; raise EngineOutputError for a bad output."""
        run = read(_setup(parameters), output)
        try:
            return _quantities(run, parameters)
        except RequestError as error:
            raise EngineOutputError(f"{output.engine}: {error}") from error

    def exact(self, parameters: TowerParameters) -> Mapping[str, float]:
        """Return the quantities by the exact propagator, which has no step; no drift of energy."""
        return {**_quantities(_exact(parameters), parameters), "energy_drift": 0.0}

    def reference(self, parameters: TowerParameters, bench: Bench) -> Mapping[str, float]:
        """Return the quantities at equal steps, of the deformable law by velocity Verlet here."""
        return _quantities(checks.reference_run(_setup(parameters), bench), parameters)

    def solve(self, parameters: TowerParameters, solver: str) -> Mapping[str, float]:
        """Return the quantities by the exact propagator or RK4."""
        if solver not in self.solvers:
            return super().solve(parameters, solver)
        run = solve(
            parameters,
            solver,
            duration=_duration(parameters),
            steps_per_contact=parameters.steps_per_contact,
        )
        return _quantities(run, parameters)

    def cost(self, parameters: TowerParameters) -> float:
        """Return the steps of a run times its particles."""
        setup = make_setup(parameters, parameters.duration, parameters.steps_per_contact)
        return float(setup.steps * parameters.particles)

    def film_job(self, parameters: TowerParameters, frames: int) -> Job:
        """Return the job of a run with so many samples."""
        return make_setup(parameters, parameters.duration, parameters.steps_per_contact, frames).job

    def discs(self, parameters: TowerParameters, output: Output) -> Discs:
        """Return the particles of a run, displacements drawn larger."""
        numbers = output.table(("step",))["step"]
        steps, every = int(numbers[-1]), int(numbers[min(1, len(numbers) - 1)])
        step = parameters.duration * parameters.contact_time / steps
        return show.discs(read(Setup(parameters, parameters.duration, step, steps, every), output))

    def checks(self, engine: Engine) -> Iterable[Check]:
        """Return the checks of an engine, against the exact propagator and at equal steps."""
        return checks.engine_checks(engine)

    def own_checks(self) -> Iterable[Check]:
        """Return RK4 against the exact propagator, and findings on the two laws."""
        return checks.solver_checks()

    def sections(self, benches: Mapping[str, Bench]) -> Sequence[Section]:
        """Return what a tower does to the critical angle, and the forces of engines."""
        return show.sections(benches)


def _setup(parameters: TowerParameters) -> Setup:
    return make_setup(parameters, _duration(parameters), parameters.steps_per_contact)


def _duration(parameters: TowerParameters) -> float:
    """Return how long a run must be to cover the duration and the turnaround window [t0]."""
    end = window_end(_exact(parameters), "turnaround") / parameters.contact_time
    return parameters.duration if end < parameters.duration else end * MARGIN


@lru_cache(maxsize=64)
def _exact(parameters: TowerParameters) -> TowerRun:
    """Return the exact run that covers the duration and the turnaround window."""
    runner = Runner("exact")
    (run,) = runner.runs([parameters], max(parameters.duration, SEARCH))
    return runner.covering(run, "turnaround")


def _quantities(run: TowerRun, parameters: TowerParameters) -> dict[str, float]:
    end = min(parameters.duration * parameters.contact_time, float(run.time[-1]))
    return {
        "peak_force_N": peak_force(run),
        "impulse_Ns": impulse(run),
        "turnaround_s": turnaround(run),
        "energy_drift": energy_drift(run),
        "final_velocity_m_per_s": grain_velocity_at(run, end),
    }


CASE = TowerCase()
