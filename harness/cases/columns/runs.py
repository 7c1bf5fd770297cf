"""Run grains over columns in an engine, read what comes back, and find their critical angle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from harness.cases.columns.parameters import Columns
from harness.cases.columns.routes import judge
from harness.cases.columns.template import TOUCHING, job_of
from harness.cases.grain import path_in
from harness.cases.incline.judge import Judgement
from harness.cases.incline.parameters import Incline
from harness.cases.incline.result import InclineRun
from harness.cases.incline.runs import read_by
from harness.cases.incline.template import Route
from harness.cases.runs import complete, run_jobs
from harness.engines.contract import Engine, Output
from harness.engines.output import Table
from harness.errors import EngineError

if TYPE_CHECKING:
    from harness.cases.incline.critical_angle import CriticalAngle


def read(case: Columns, route: Route, output: Output, every: int | None = None) -> InclineRun:
    """Return the run that an output tells of; errors as for the incline."""

    def judged(looks: Table) -> Judgement:
        return judge(case, route, path_in(looks), looks[TOUCHING])

    return read_by(judged, case, route, output, every)


def run_columns(
    engine: Engine, cases: Sequence[Columns], route: Route, *, every: int | None = None
) -> list[InclineRun | EngineError]:
    """Run the cases and return their results in order, errors in place."""
    return run_jobs(
        engine,
        cases,
        lambda case: job_of(case, route, every),
        lambda case, output: read(case, route, output, every),
    )


def critical_angle(
    case: Columns,
    engine: Engine,
    *,
    method: Route = "passage",
    tolerance_deg: float = 1e-3,
    phases: int = 2,
) -> CriticalAngle:
    """Return the critical angle [deg] of a case, whose own angle is ignored.

    ``passage`` or ``steady`` motion, as for the incline. Raise EngineError when a run fails, and
    RequestError when a grain flies where a passage is judged.
    """
    from harness.cases.incline.passage import critical_angle_by_passage
    from harness.cases.incline.steady import critical_angle_by_steady_motion

    def measure(cases: Sequence[Incline]) -> list[InclineRun]:
        return complete(run_columns(engine, [c for c in cases if isinstance(c, Columns)], method))

    if method == "steady":
        return critical_angle_by_steady_motion(measure, case, tolerance_deg=tolerance_deg)
    return critical_angle_by_passage(measure, case, tolerance_deg=tolerance_deg, phases=phases)
