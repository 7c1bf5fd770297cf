"""Yade as an engine of the harness: cases in, results out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import TypeVar

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.tower.timing import Plan, plan
from harness.engines.contract import Engine, Route
from harness.engines.input_values import Values, drop_values
from harness.engines.parallel import cores
from harness.engines.process import Limits
from harness.engines.traits import Traits
from harness.engines.yade.batch import Batches, Job, Output
from harness.engines.yade.program import find, version
from harness.engines.yade.read import read_drop, read_incline, read_tower
from harness.engines.yade.scripts import (
    drop_script,
    incline_script,
    incline_values,
    tower_script,
    tower_values,
)
from harness.errors import EngineError, RequestError
from harness.observables.provenance import Provenance
from harness.observables.tower import TowerRun
from harness.parameters.contact import Contact
from harness.parameters.tower import Tower

Case = TypeVar("Case")
Run = TypeVar("Run")


class Yade(Engine):
    """Yade as packaged: it runs a generated script, ``workers`` processes side by side.

    Raise RequestError when ``program`` is not there, EngineMissingError when Yade is not
    installed or the program is not Yade.
    """

    name = "yade"
    traits = Traits(
        install_hint="apt install yade (Debian, Ubuntu), or --yade PATH",
        versions=("2023.02a",),
        integrator="mfix-euler",
        tails=("clipped",),
        caveats=(
            "Its own formulas for tc and en, and for young and en, take m/2 for the effective "
            "mass against a fixed sphere.",
            "With young and en near 0 its search for the dashpot fails: it warns and leaves "
            "the dashpot out, and the contact is elastic.",
            "NewtonIntegrator damps every force by 0.2 unless damping=0 is given.",
            "Coefficients of two materials act in series: each needs twice those of the contact.",
        ),
    )

    def __init__(
        self,
        program: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
    ) -> None:
        self._program = find(program, self.traits.install_hint)
        self._who = Provenance(
            engine=self.name,
            engine_version=version(self._program),
            executable=self._program,
            how="executable",
            integrator=self.traits.integrator,
        )
        self._batches = Batches(self._program, workers or cores(), limits or Limits())
        self._logs: dict[str, str] = {}

    def identify(self) -> Provenance:
        """Return version and executable."""
        return self._who

    def drops(self, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
        """Run the drop's generated script for all cases, in order."""
        self._check(case.contact for case in cases)
        jobs = [Job(drop_script(), self.drop_values(case)) for case in cases]

        def read(case: Drop, output: Output, who: Provenance) -> DropRun:
            return read_drop(case, output.results, output.series, who)

        return self._run(cases, jobs, read)

    def drop_values(self, case: Drop) -> Values:
        """Return what a case sets in the drop's script."""
        return drop_values(case)

    def inclines(
        self, cases: Sequence[Incline], route: Route, *, every: int | None = None
    ) -> list[InclineRun | EngineError]:
        """Run the incline's generated script for all cases, in order."""
        if every is not None and every < 1:
            raise RequestError(f"every = {every}: must be at least 1 step")
        self._check(case.contact for case in cases)
        sampled: Values = {} if every is None else {"series_every": every}
        jobs = [
            Job(
                incline_script(),
                {"route": route, **incline_values(case), **sampled},
                series=every is not None,
            )
            for case in cases
        ]

        def read(case: Incline, output: Output, who: Provenance) -> InclineRun:
            return read_incline(case, output.results, who, output.series, every)

        return self._run(cases, jobs, read)

    def towers(
        self,
        cases: Sequence[Tower],
        duration: float,
        *,
        steps_per_contact: float | None = None,
        samples: int | None = None,
        profiles: bool = False,
    ) -> list[TowerRun | EngineError]:
        """Run the tower's generated script for all cases, in order."""
        plans = [plan(case, duration, steps_per_contact, samples) for case in cases]
        jobs = [
            Job(tower_script(), tower_values(case, timing))
            for case, timing in zip(cases, plans, strict=True)
        ]

        def read(timed: tuple[Tower, Plan], output: Output, who: Provenance) -> TowerRun:
            case, timing = timed
            return read_tower(case, timing, output.series, who, profiles)

        return self._run(list(zip(cases, plans, strict=True)), jobs, read)

    def logs(self) -> dict[str, str]:
        """Return, for each script, the results of the first run of it that finished."""
        return dict(self._logs)

    def close(self) -> None:
        """End Yade's processes."""
        self._batches.close()

    def _check(self, contacts: Iterable[Contact]) -> None:
        """Raise RequestError for a contact that Yade cannot state."""
        for contact in contacts:
            refused = self.traits.refuses(contact)
            if refused:
                raise RequestError(
                    f"engine 'yade' cannot state contact {contact.name!r}: {refused}"
                )

    def _run(
        self,
        cases: Sequence[Case],
        jobs: Sequence[Job],
        read: Callable[[Case, Output, Provenance], Run],
    ) -> list[Run | EngineError]:
        """Run a job for each case and read what it left; errors in their places."""
        runs: list[Run | EngineError] = []
        for case, job, output in zip(cases, jobs, self._batches.run(jobs), strict=True):
            if isinstance(output, EngineError):
                output.log = _headed(job, output.log)
                runs.append(output)
                continue
            script = job.script
            who = replace(self._who, script=script.name, script_sha256=script.sha256)
            log = _headed(job, output.results)
            try:
                runs.append(read(case, output, who))
            except EngineError as error:
                error.log = log
                runs.append(error)
            else:
                self._logs.setdefault(script.name, log)
        return runs


def _headed(job: Job, text: str) -> str:
    """Return a text below the command that runs the same again."""
    values = " ".join(f"{name}={value}" for name, value in job.values.items())
    head = f"# yade -n -x {job.script.name} {values}\n# sha256 of the script: "
    return f"{head}{job.script.sha256}\n{text or 'Yade left no words.'}\n"
