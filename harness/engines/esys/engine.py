"""ESyS-Particle as an engine of the harness: a process for each model, read from its files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TypeVar

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.judge import run_of_path
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.tower.timing import Plan, plan
from harness.engines.contract import Engine, Route
from harness.engines.esys.launch import Finished, Launcher
from harness.engines.esys.read import WHO, error_of, read_drop, read_paths, read_tower
from harness.engines.esys.scripts import (
    Script,
    drop_script,
    incline_parameters,
    incline_script,
    tower_parameters,
    tower_script,
)
from harness.engines.input_values import Value, drop_values
from harness.engines.parallel import cores, parallel_map
from harness.engines.process import Limits
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineTimeoutError, RequestError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.observables.trajectory import Trajectory
from harness.parameters.contact import Contact
from harness.parameters.hertz import fewest_steps_per_contact
from harness.parameters.tower import Tower

Result = TypeVar("Result")

WATCH = 50
"""Steps between two looks at a grain, as many as the reference DEM takes."""


class Esys(Engine):
    """ESyS-Particle with Hertz's contact on the incline and linear springs in towers.

    ``program`` is the executable, ``launcher`` the command that starts it on two ranks
    (Open MPI's ``mpirun.openmpi``, or ``mpirun``, unless told otherwise). ``workers``
    runs go side by side, as many as there are cores unless told otherwise.
    """

    name = "esys"
    traits = Traits(
        install_hint="apt install esys-particle (Debian), or --esys PATH",
        versions=("2.3.4",),
        integrator="mfix-euler",
        tails=("clipped",),
        spring="Hertz",
        caveats=(
            "LinearDashpot brakes along the tangent too: it cannot state a frictionless contact.",
            "setParticleNonDynamic takes a tag, and says nothing when it is given an id.",
            "An exception in the script leaves the worker waiting for ever.",
            "getForce of a particle crashes, and so does getParticleList before the first step.",
            "Field savers append to the files of an earlier run, and write six digits.",
        ),
    )

    def __init__(
        self,
        program: str | None = None,
        launcher: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
    ) -> None:
        self._launcher = Launcher(program, launcher, limits or Limits(), self.traits.install_hint)
        self._workers = workers or cores()
        self._logs: dict[str, str] = {}

    def identify(self) -> Provenance:
        """Return version, executable and launcher, which a short run tells."""
        return self._provenance

    @cached_property
    def _provenance(self) -> Provenance:
        return replace(self._launcher.identify(), integrator=self.traits.integrator)

    def drops(self, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
        """Run the drop's generated script for each case, in order."""
        for case in cases:
            self._check(case.contact)
        script = drop_script()
        who = self._who(script)

        def one(case: Drop) -> DropRun | EngineError:
            def read(left: Finished) -> DropRun:
                return DropRun(case, read_drop(case, left.series), left.ended.seconds, who)

            return self._result(script, drop_values(case), read)

        return parallel_map(one, cases, self._workers)

    def inclines(
        self, cases: Sequence[Incline], route: Route, *, every: int | None = None
    ) -> list[InclineRun | EngineError]:
        """Run the incline's generated script, once for cases that differ by their phases only."""
        for case in cases:
            self._check(case.contact)
            _check_step(case)
        groups: dict[Incline, list[int]] = {}
        for index, case in enumerate(cases):
            key = case.replace(phase=0.0) if route == "passage" else case
            groups.setdefault(key, []).append(index)
        results: dict[int, InclineRun | EngineError] = {}

        def serve(indices: list[int]) -> None:
            done = self._rows([cases[index] for index in indices], route, every)
            results.update(zip(indices, done, strict=True))

        parallel_map(serve, groups.values(), self._workers)
        return [results[index] for index in range(len(cases))]

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
        parameters = [tower_parameters(*job) for job in zip(cases, plans, strict=True)]
        script = tower_script()
        who = self._who(script)

        def one(job: tuple[Tower, Plan, Mapping[str, Value]]) -> TowerRun | EngineError:
            case, timing, values = job

            def read(left: Finished) -> TowerRun:
                rows = timing.steps // timing.every
                return read_tower(case, timing.step, rows, left.series, who, profiles)

            return self._result(script, values, read)

        jobs = list(zip(cases, plans, parameters, strict=True))
        return parallel_map(one, jobs, self._workers)

    def logs(self) -> dict[str, str]:
        """Return, for each script, what the first run of it that finished said."""
        return dict(self._logs)

    def close(self) -> None:
        """End what runs and remove the temporary files."""
        self._launcher.close()

    def _rows(
        self, cases: Sequence[Incline], route: Route, every: int | None
    ) -> list[InclineRun | EngineError]:
        """Run cases that share all but their phases, in rows side by side in one model.

        Where that dies, each runs in a model of its own.
        """
        script = incline_script()
        who = self._who(script)
        values = incline_parameters(cases, route, every or WATCH)

        def read(left: Finished) -> tuple[Finished, list[Trajectory]]:
            return left, read_paths(left.series, len(cases))

        found = self._result(script, values, read)
        if isinstance(found, EngineTimeoutError) or (
            isinstance(found, EngineError) and len(cases) == 1
        ):
            return [found] * len(cases)
        if isinstance(found, EngineError):
            return [run for case in cases for run in self._rows([case], route, every)]
        left, paths = found
        results: list[InclineRun | EngineError] = []
        for case, path in zip(cases, paths, strict=True):
            try:
                run = run_of_path(
                    case,
                    route,
                    path,
                    who,
                    seconds=left.ended.seconds / len(cases),
                    keep=every is not None,
                    law="Hertz",
                )
            except EngineError as error:
                error.log = _log(script, values, left)
                results.append(error)
            else:
                results.append(run)
        return results

    def _result(
        self, script: Script, values: Mapping[str, Value], read: Callable[[Finished], Result]
    ) -> Result | EngineError:
        """Return what is read of a run, or the error of a run that went wrong, with its log."""
        left: Finished | None = None
        try:
            left = self._launcher.run(script, values)
            error = error_of(left.ended, self._launcher.limits.seconds)
            if error is not None:
                raise error
            result = read(left)
        except EngineError as error:
            error.log = _log(script, values, left)
            return error
        self._logs.setdefault(script.name, _log(script, values, left))
        return result

    def _check(self, contact: Contact) -> None:
        """Raise RequestError for a contact that ESyS-Particle cannot state."""
        reason = self.traits.refuses(contact)
        if reason:
            raise RequestError(f"contact {contact.name!r} cannot be stated in {WHO}: {reason}")

    def _who(self, script: Script) -> Provenance:
        """Return the engine's identity with the script that ran."""
        return replace(self.identify(), script=script.name, script_sha256=script.sha256)


def _check_step(case: Incline) -> None:
    """Raise RequestError for a step that the integrator may not take."""
    fewest = fewest_steps_per_contact(case.contact)
    if case.steps_per_contact <= fewest:
        raise RequestError(
            f"steps_per_contact = {case.steps_per_contact:g} is unstable in {WHO} at damping "
            f"ratio {case.contact.zeta:.4g}: must be greater than {fewest:.3f}"
        )


def _log(script: Script, values: Mapping[str, Value], left: Finished | None) -> str:
    """Return what a run said below the command that runs the same again."""
    words = " ".join(script.arguments(values))
    head = f"# mpirun -np 2 esysparticle {script.name} {words}\n# sha256 of the script: "
    said = left.ended.said if left else ""
    return f"{head}{script.sha256}\n{said or 'ESyS-Particle said nothing.'}\n"
