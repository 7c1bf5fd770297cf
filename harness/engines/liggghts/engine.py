"""LIGGGHTS as an engine of the harness: cases in, results out, through its executable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.tower.timing import Plan, plan
from harness.engines.contract import Engine, Route
from harness.engines.lammps.fingerprint import facts, program_files
from harness.engines.lammps.jobs import Job, Output
from harness.engines.lammps.read import read_drop, read_incline
from harness.engines.lammps.read_tower import read_tower
from harness.engines.liggghts.executable import Executable
from harness.engines.liggghts.jobs import drop_job, incline_job, tower_job
from harness.engines.liggghts.scripts import all_scripts
from harness.engines.parallel import cores
from harness.engines.process import Limits
from harness.engines.programs import find_program
from harness.engines.traits import Traits
from harness.errors import EngineError, EngineMissingError, RequestError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower

PROGRAM = "liggghts"
INTEGRATOR = "velocity-verlet"

Case = TypeVar("Case")
Run = TypeVar("Run")


class Liggghts(Engine):
    """LIGGGHTS-PUBLIC's executable, ``liggghts`` on PATH unless ``program`` says otherwise.

    ``workers`` processes run side by side, as many as there are cores unless told
    otherwise. Raise RequestError for a program that is not there, EngineMissingError
    where none was named and there is none.
    """

    name = "liggghts"
    traits = Traits(
        install_hint="apt install liggghts (Debian, Ubuntu), or --liggghts PATH",
        versions=("LIGGGHTS-PUBLIC 3.8.0",),
        integrator=INTEGRATOR,
        lineage="LAMMPS",
        caveats=(
            "In two dimensions (dimension 2) its particles are discs of unit height: 3/2 of the "
            "mass of spheres of 1 m.",
            "Clipping the tail (limitForce) is an option, off by default.",
            "Model hooke refuses restitutions up to 0.05, and its stiffness grows with the "
            "effective mass to the power 1/5: take hooke/stiffness.",
            "Words cannot be compared in its scripts, and errors are silent without a log.",
        ),
    )

    def __init__(
        self,
        program: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
    ) -> None:
        self._logs: dict[str, str] = {}
        self._runner = Executable(self._found(program), workers or cores(), limits or Limits())

    def identify(self) -> Provenance:
        """Return version and executable."""
        return self._runner.identify()

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return the contents of LIGGGHTS and of the scripts it is given, read once."""
        return self._fingerprint

    @cached_property
    def _fingerprint(self) -> dict[str, Any] | None:
        files = program_files(Path(self.identify().executable))
        scripts = {script.name: script.sha256 for script in all_scripts()}
        return {**facts(self.name, "executable", files), "scripts": scripts} if files else None

    def drops(self, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
        """Run the drop's generated script for each case, in order."""

        def read(case: Drop, output: Output, who: Provenance) -> DropRun:
            path = read_drop(case, output.series or "", "LIGGGHTS")
            return DropRun(case, path, output.seconds, who)

        return self._results(cases, [drop_job(case) for case in cases], read)

    def inclines(
        self, cases: Sequence[Incline], route: Route, *, every: int | None = None
    ) -> list[InclineRun | EngineError]:
        """Run the incline's generated script for each case, in order."""

        def read(case: Incline, output: Output, who: Provenance) -> InclineRun:
            return read_incline(case, output.log, output.series, output.seconds, who)

        return self._results(cases, [incline_job(case, route, every) for case in cases], read)

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
        timed = list(zip(cases, plans, strict=True))

        def read(planned: tuple[Tower, Plan], output: Output, who: Provenance) -> TowerRun:
            case, timing = planned
            return read_tower(case, timing.step, output.series or "", who, profiles)

        return self._results(timed, [tower_job(*planned) for planned in timed], read)

    def logs(self) -> dict[str, str]:
        """Return, for each script, the log of the first run of it that finished."""
        return dict(self._logs)

    def close(self) -> None:
        """End LIGGGHTS's processes."""
        self._runner.close()

    def _found(self, program: str | None) -> str:
        if program is not None:
            return find_program(self.name, program)
        try:
            return find_program(self.name, PROGRAM)
        except RequestError:
            raise EngineMissingError(
                f"no {PROGRAM} on PATH; install it: {self.traits.install_hint}"
            ) from None

    def _results(
        self,
        cases: Sequence[Case],
        jobs: Sequence[Job],
        read: Callable[[Case, Output, Provenance], Run],
    ) -> list[Run | EngineError]:
        """Run the jobs and read each; an error stands in the place of its result."""
        results: list[Run | EngineError] = []
        for case, job, output in zip(cases, jobs, self._runner.run(jobs), strict=True):
            if isinstance(output, EngineError):
                results.append(_with_log(output, job, output.log))
                continue
            try:
                run = read(case, output, self._who(job))
            except EngineError as error:
                results.append(_with_log(error, job, output.log))
            else:
                self._logs.setdefault(job.script.name, _headed(job, output.log))
                results.append(run)
        return results

    def _who(self, job: Job) -> Provenance:
        """Return the engine's identity with the script that ran."""
        return replace(
            self.identify(),
            script=job.script.name,
            script_sha256=job.script.sha256,
            integrator=INTEGRATOR,
        )


def _with_log(error: EngineError, job: Job, log: str) -> EngineError:
    """Return the error with what the run left, headed by what was run."""
    error.log = _headed(job, log)
    return error


def _headed(job: Job, log: str) -> str:
    """Return a log below the command that runs the same again."""
    variables = " ".join(f"-var {name} {value}" for name, value in job.variables.items())
    head = f"# liggghts -in {job.script.name} {variables}\n# sha256 of the script: "
    return f"{head}{job.script.sha256}\n{log or 'LIGGGHTS left no log.'}\n"
