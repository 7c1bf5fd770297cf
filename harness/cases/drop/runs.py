"""Run drops in an engine, and read what comes back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from harness.cases.drop.parameters import Drop
from harness.cases.drop.template import job_of
from harness.cases.grain import COLUMNS, path_in
from harness.cases.runs import run_jobs
from harness.engines.contract import Engine, Output
from harness.errors import EngineError
from harness.observables.provenance import Provenance
from harness.observables.trajectory import Trajectory


@dataclass(frozen=True)
class DropRun:
    """The grain's path, origin in the fixed sphere's centre; ``seconds`` of wall time it took."""

    case: Drop
    path: Trajectory
    seconds: float
    provenance: Provenance


def run_drops(engine: Engine, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
    """Run a grain against one fixed sphere, case by case, and return the paths in order.

    Raise RequestError for a case that the engine cannot state.
    """
    return run_jobs(engine, cases, job_of, read)


def read(case: Drop, output: Output) -> DropRun:
    """Return the drop that an output tells of, every sample of it.

    Raise EngineOutputError for what is missing or cut, or ran with other settings, EngineNaNError
    for values that are not finite.
    """
    output.check_numbers({**case.settings(), "steps": case.steps})
    table = output.table(COLUMNS, case.steps // case.every + 1)
    return DropRun(case, path_in(table), output.seconds, output.provenance)
