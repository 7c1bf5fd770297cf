"""Which script runs a case, and with which variables."""

from __future__ import annotations

from collections.abc import Mapping

from harness.cases.drop.parameters import Drop
from harness.cases.incline.parameters import Incline
from harness.cases.tower.timing import Plan
from harness.engines.contract import Route
from harness.engines.lammps.jobs import Job
from harness.engines.lammps.scripts import (
    Script,
    check_variables,
    drop_variables,
    incline_variables,
)
from harness.engines.liggghts.scripts import (
    drop_script,
    incline_script,
    tower_script,
    tower_variables,
)
from harness.parameters.tower import Tower


def drop_job(case: Drop) -> Job:
    """Return the job of a drop, which writes the path."""
    return _job(drop_script(), drop_variables(case), series=True)


def incline_job(case: Incline, route: Route, every: int | None) -> Job:
    """Return the job of an incline; with ``every`` it writes the path."""
    variables = {"route": route, **incline_variables(case)}
    if every is not None:
        variables |= {"record": "yes", "series_every": str(every)}
    return _job(incline_script(case.contact.name), variables, series=every is not None)


def tower_job(case: Tower, timing: Plan) -> Job:
    """Return the job of a tower; raise RequestError for one that cannot be stated."""
    variables = {
        **tower_variables(case, timing.duration, timing.steps_per_contact),
        "everyone": "yes",
        "series_every": str(timing.every),
    }
    return _job(tower_script(), variables, series=True)


def _job(script: Script, variables: Mapping[str, str], *, series: bool) -> Job:
    check_variables(script, variables)
    return Job(script, variables, series)
