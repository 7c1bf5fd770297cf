"""How the reproduction runs the incline in an engine: the one place that knows it."""

from __future__ import annotations

from collections.abc import Sequence

from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.incline.runs import run_inclines
from harness.engines.contract import Engine
from harness.errors import EngineError
from harness.observables.trajectory import Trajectory

ANGLES_DEG = (10.20, 10.22)
"""A hundredth of a degree either side of the source's 10.21 deg: trapped, and moving."""


def sampled(
    engine: Engine, cases: Sequence[Incline], every: int
) -> list[tuple[InclineRun, Trajectory]]:
    """Run cases in steady motion; return each with its path, sampled every so many steps.

    Raise the first EngineError.
    """
    found = []
    for run in run_inclines(engine, cases, "steady", every=every):
        if isinstance(run, EngineError):
            raise run
        assert run.trajectory is not None
        found.append((run, run.trajectory))
    return found
