"""Run drops in an engine, and read what comes back."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from harness.cases.drop.parameters import Drop
from harness.cases.drop.result import DropRun
from harness.cases.drop.template import job_of
from harness.engines.contract import Engine, Output
from harness.errors import EngineError
from harness.observables.trajectory import Trajectory

COLUMNS = ("time_s", "x_m", "y_m", "vx_m_per_s", "vy_m_per_s")


def run_drops(engine: Engine, cases: Sequence[Drop]) -> list[DropRun | EngineError]:
    """Run a grain against one fixed sphere, case by case, and return the paths in order.

    Raise RequestError for a case that the engine cannot state.
    """
    results: list[DropRun | EngineError] = []
    outputs = engine.run([job_of(case) for case in cases])
    for case, output in zip(cases, outputs, strict=True):
        try:
            if isinstance(output, EngineError):
                raise output
            results.append(read(case, output))
        except EngineError as error:
            if isinstance(output, Output):
                error.log = output.log
            results.append(error)
    return results


def read(case: Drop, output: Output) -> DropRun:
    """Return the drop that an output tells of, every sample of it.

    Raise EngineOutputError for what is missing or cut, EngineNaNError for values that are not
    finite.
    """
    table = output.table(COLUMNS, case.steps // case.every + 1)
    columns = [np.asarray(table[name]) for name in COLUMNS]
    path = Trajectory(*(c[:, 0] if c.ndim == 2 else c for c in columns))
    return DropRun(case, path, output.seconds, output.provenance)
