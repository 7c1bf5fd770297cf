"""Kratos DEM as an engine of the harness: cases in, results out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.judge import run_of_path
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.tower.timing import plan
from harness.engines.contract import Engine, Route
from harness.engines.input_values import Values, drop_values
from harness.engines.kratos.batches import Batches
from harness.engines.kratos.jobs import Job, Output
from harness.engines.kratos.read import read_path, read_tower
from harness.engines.kratos.scripts import (
    RELEASES,
    Scheme,
    Script,
    drop_script,
    incline_script,
    incline_values,
    tower_script,
    tower_values,
)
from harness.engines.parallel import cores
from harness.engines.process import Limits
from harness.engines.traits import Traits
from harness.errors import EngineError, RequestError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

Result = TypeVar("Result")

REFERENCE: dict[Scheme, str] = {
    "Velocity_Verlet": "velocity-verlet",
    "Symplectic_Euler": "mfix-euler",
}
"""The reference DEM's names of Kratos's integrators."""

LOOK = 50
"""Steps between two samples, unless told otherwise: as often as the others look."""


class Kratos(Engine):
    """Kratos DEM in worker processes of the Python ``program``, this one unless given.

    ``scheme`` is Kratos's integrator. ``workers`` processes run side by side, as many as
    there are cores unless told otherwise.
    """

    name = "kratos"
    traits = Traits(
        install_hint="pip install KratosDEMApplication (extra 'kratos'), or --kratos PYTHON",
        versions=RELEASES,
        integrator=REFERENCE["Velocity_Verlet"],
        tails=("clipped",),
        effective_masses=("full", "half"),
        digits=15,
        caveats=(
            "Only the first search for contacts goes by SearchTolerance: every later one goes by "
            "search_tolerance_against_walls, also where there is no wall, and with 0 there and "
            "the default NeighbourSearchFrequency of 50 contacts are found up to 50 steps late.",
            "A restitution below 0.001 counts as 0.001.",
            "A fixed sphere counts with its own mass: against one of its size a grain has m/2.",
            "Symplectic_Euler, the default, tells forces one step and velocities half a step "
            "behind positions; Velocity_Verlet does not.",
        ),
    )

    def __init__(
        self,
        program: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
        scheme: Scheme = "Velocity_Verlet",
    ) -> None:
        self._scheme: Scheme = scheme
        self.traits = replace(type(self).traits, integrator=REFERENCE[scheme])
        self._logs: dict[str, str] = {}
        self._batches = Batches(
            program, self.traits.install_hint, workers or cores(), limits or Limits()
        )

    def identify(self) -> Provenance:
        """Return the version and the Python that has it."""
        return self._batches.identify()

    def drops(self, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
        """Run the drop's generated script for each case, in order."""
        self._check(cases)
        jobs = [self._job(drop_script(), drop_values(case)) for case in cases]

        def read(index: int, output: Output, who: Provenance) -> DropRun:
            case = cases[index]
            path = read_path(output.series, rows=case.steps // case.every + 1)
            return DropRun(case, path, output.seconds, who)

        return self._run(jobs, read)

    def inclines(
        self, cases: Sequence[Incline], route: Route, *, every: int | None = None
    ) -> list[InclineRun | EngineError]:
        """Run the incline's generated script for each case, in order."""
        self._check(cases)
        if every is not None and every < 1:
            raise RequestError(f"every = {every}: must be at least 1 step")
        rest = {"route": route, "series_every": every or LOOK}
        jobs = [self._job(incline_script(), {**incline_values(case), **rest}) for case in cases]

        def read(index: int, output: Output, who: Provenance) -> InclineRun:
            path = read_path(output.series)
            keep = every is not None
            return run_of_path(cases[index], route, path, who, seconds=output.seconds, keep=keep)

        return self._run(jobs, read)

    def towers(
        self,
        cases: Sequence[Tower],
        duration: float,
        *,
        steps_per_contact: float | None = None,
        samples: int | None = None,
        profiles: bool = False,
    ) -> list[TowerRun | EngineError]:
        """Run the tower's generated script for each case, in order."""
        plans = [plan(case, duration, steps_per_contact, samples) for case in cases]
        jobs = []
        for case, timing in zip(cases, plans, strict=True):
            values = tower_values(case, timing.duration, timing.steps_per_contact)
            jobs.append(self._job(tower_script(), {**values, "series_every": timing.every}))

        def read(index: int, output: Output, who: Provenance) -> TowerRun:
            return read_tower(cases[index], plans[index], output.series, who, profiles)

        return self._run(jobs, read)

    def logs(self) -> dict[str, str]:
        """Return, for each script, the RESULT lines of the first run of it that finished."""
        return dict(self._logs)

    def close(self) -> None:
        """End the worker processes."""
        self._batches.close()

    def _check(self, cases: Sequence[Drop] | Sequence[Incline]) -> None:
        """Raise RequestError for a contact that Kratos does not have."""
        for case in cases:
            refused = self.traits.refuses(case.contact)
            if refused:
                raise RequestError(f"contact {case.contact.name!r} is not for kratos: {refused}")

    def _job(self, script: Script, values: Values) -> Job:
        return Job(script, {**values, "scheme": self._scheme})

    def _run(
        self, jobs: Sequence[Job], read: Callable[[int, Output, Provenance], Result]
    ) -> list[Result | EngineError]:
        """Run the jobs and read what they left; an error takes the place of its run's result."""
        who = self.identify()
        results: list[Result | EngineError] = []
        for index, output in enumerate(self._batches.run(jobs)):
            job = jobs[index]
            try:
                if isinstance(output, EngineError):
                    raise output
                results.append(read(index, output, self._signed(who, job)))
            except EngineError as error:
                error.log = job.headed(error.log)
                results.append(error)
            else:
                self._logs.setdefault(job.script.name, job.headed(output.log))
        return results

    def _signed(self, who: Provenance, job: Job) -> Provenance:
        """Return the engine's identity with the script that ran and its integrator."""
        return replace(
            who,
            script=job.script.name,
            script_sha256=job.script.sha256,
            integrator=self.traits.integrator,
        )
