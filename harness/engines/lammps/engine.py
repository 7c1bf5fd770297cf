"""LAMMPS as an engine of the harness: cases in, results out, whichever way it runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from harness.engines.contract import Engine, Route
from harness.engines.lammps.executable import Executable
from harness.engines.lammps.inprocess import InProcess
from harness.engines.lammps.jobs import Job, Limits, Output, Runner
from harness.engines.lammps.read import read_incline
from harness.engines.lammps.scripts import check_variables, incline_script, incline_variables
from harness.engines.parallel import cores
from harness.errors import EngineError
from harness.observables.incline import InclineRun
from harness.observables.provenance import Provenance
from harness.parameters.incline import Incline


class Lammps(Engine):
    """LAMMPS in-process (default), or the executable ``lmp`` with an optional MPI launcher.

    ``workers`` processes run side by side, as many as there are cores unless
    told otherwise (one under a launcher, which has ranks of its own).
    """

    name = "lammps"

    def __init__(
        self,
        lmp: str | None = None,
        launcher: str | None = None,
        workers: int | None = None,
        limits: Limits | None = None,
    ) -> None:
        workers, limits = workers or cores(), limits or Limits()
        self._runner: Runner
        if lmp is None and launcher is None:
            self._runner = InProcess(workers, limits)
        else:
            self._runner = Executable(lmp or "lmp", launcher or "", workers, limits)

    def identify(self) -> Provenance:
        """Return version, packages, executable and how it is run."""
        return self._runner.identify()

    def inclines(
        self, cases: Sequence[Incline], route: Route, *, every: int | None = None
    ) -> list[InclineRun | EngineError]:
        """Run the incline's generated script for each case, in order."""
        jobs = [_job(case, route, every) for case in cases]
        outputs = self._runner.run(jobs)
        return [
            self._read(case, job, output)
            for case, job, output in zip(cases, jobs, outputs, strict=True)
        ]

    def close(self) -> None:
        """End LAMMPS's processes."""
        self._runner.close()

    def _read(
        self, case: Incline, job: Job, output: Output | EngineError
    ) -> InclineRun | EngineError:
        if isinstance(output, EngineError):
            return output
        who = replace(self.identify(), script=job.script.name, script_sha256=job.script.sha256)
        try:
            return read_incline(case, output.log, output.series, output.seconds, who)
        except EngineError as error:
            return error


def _job(case: Incline, route: Route, every: int | None) -> Job:
    script = incline_script(case.contact.name)
    variables = {"route": route, **incline_variables(case)}
    if every is not None:
        variables["series_every"] = str(every)
    check_variables(script, variables)
    return Job(script, variables, series=every is not None)
