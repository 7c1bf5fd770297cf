"""Run the study of a case: its arms as sweeps are run, then what the case concludes from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from harness.cases.case_study import (
    Arm,
    CaseStudy,
    Conclusion,
    EngineOf,
    Level,
    Row,
    StudyCost,
)
from harness.cases.contract import Case
from harness.cases.registry import all_cases, get_case
from harness.engines.registry import engine_class
from harness.errors import EngineMissingError, RequestError
from harness.home import RESTARTS, cache_place
from harness.observables.reference import ReferencePoints
from harness.parameters.base import Parameters
from harness.shown import Shown
from harness.store.entries import Entries
from harness.workflows.case_run import usual_engine
from harness.workflows.earlier_runs import EarlierRuns, read_runs, script_digest
from harness.workflows.opened import opened
from harness.workflows.progress import Progress, silent
from harness.workflows.sweep_local import CheckedExecutor, Executor, Local, Work
from harness.workflows.sweep_plan import Asked, Plan, Point
from harness.workflows.sweep_run import DONE, FAILED, UNDECIDED, as_frame, run_plan

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure

RUN_SECONDS = 7200
"""That a run may take, or its part between two restart files: half an hour on an idle core."""

ExecutorOf = Callable[[int], Executor]
"""Returns what runs work with so many ranks of MPI in each run."""


@dataclass(frozen=True, repr=False)
class StudyResult(Shown):
    """What a study found, with every run behind it; ``missing`` says why an arm has no runs.

    ``taken`` runs are those of an earlier study.
    """

    case: str
    title: str
    question: str
    level: Level
    engine: str
    runs: tuple[Row, ...]
    conclusion: Conclusion
    missing: Mapping[str, str] = field(default_factory=dict)
    taken: int = 0

    def count(self, status: str) -> int:
        """Return how many runs have a status, as ``done``, ``undecided`` or ``failed``."""
        return sum(row["status"] == status for row in self.runs)

    def record(self) -> dict[str, Any]:
        """Return it as a JSON-ready mapping."""
        return {
            "case": self.case,
            "level": self.level,
            "engine": self.engine,
            "runs": len(self.runs),
            "undecided": self.count(UNDECIDED),
            "failed": self.count(FAILED),
            "missing": dict(self.missing),
            "test": self.conclusion.test,
            "verdict": list(self.conclusion.verdict),
            "rows": [dict(row) for row in self.conclusion.rows],
        }

    def frame(self) -> pd.DataFrame:
        """Return the rows of results as a table."""
        return as_frame(self.conclusion.rows)

    def told(self) -> dict[str, str]:
        """Return the verdict and how many runs it rests on."""
        runs = ", ".join(f"{self.count(one)} {one}" for one in (DONE, UNDECIDED, FAILED))
        return {"verdict": " ".join(self.conclusion.verdict), "runs": runs, "level": self.level}

    def drawn(self) -> Figure:
        """Draw the first figure of the report."""
        drawings = [one for section in self.conclusion.sections for one in section.drawings]
        if not drawings:
            raise RequestError(f"plot: no run of this study of {self.case} measured anything")
        return cast("Figure", drawings[0].draw())


def study_of(name: str) -> tuple[Case[Any], CaseStudy]:
    """Return a case and its study; raise RequestError for a case that has none."""
    case = get_case(name)
    found = case.study()
    if found is None:
        having = ", ".join(n for n, one in all_cases().items() if one.study() is not None)
        raise RequestError(f"case {name!r} has no study: must be one of {having}")
    return case, found


def planned(name: str, level: Level) -> tuple[int, float]:
    """Return how many runs a level of a study has, and their time on one core [s], kept or not.

    Raise RequestError for a case without a study.
    """
    case, asked = study_of(name)
    rules = engine_class(usual_engine(case)).traits
    runs = {(one, arm.ranks) for arm in asked.arms(level) for one in arm.parameters}
    return len(runs), sum(case.seconds(one, rules) for one, _ in runs)


def cost_of(name: str, level: Level, engine_of: EngineOf, earlier: Path | None = None) -> StudyCost:
    """Return what a level of a study costs, by the wall times in a runs.csv or as measured here.

    Raise RequestError for a case without a study and for a bad file, EngineError where an engine
    is to be measured and is not here.
    """
    case, asked = study_of(name)
    if earlier is None:
        return asked.cost(level, engine_of)
    read_runs(earlier, case, asked.arms(level)[0].parameters[0])  # raises for a bad file
    import pandas as pd

    frame = pd.read_csv(earlier)
    runs = frame[frame["status"] == DONE].to_dict("records")
    if not runs:
        raise RequestError(f"--runs {earlier}: has no run that is done")
    return asked.cost(level, engine_of, [{str(key): row[key] for key in row} for row in runs])


def study(
    name: str,
    level: Level = "default",
    *,
    points: ReferencePoints | None = None,
    executor_of: ExecutorOf | None = None,
    progress: Progress = silent,
    earlier: Path | None = None,
    least_ranks: int = 1,
) -> StudyResult:
    """Run the study of a case at a level (``quick``, ``default``, ``full``) and conclude.

    Runs are kept and not run twice, so a study that was killed goes on. ``executor_of`` runs them
    elsewhere, on ``least_ranks`` of MPI at least, ``points`` are drawn beside the results, and
    ``earlier`` is the runs.csv of a study before: what is done in it is taken from it. A run that
    fails is a row with the reason; an engine that cannot run with several ranks leaves that arm
    out. Raise RequestError for a case without a study and for a bad file, EngineError where the
    engine is not here.
    """
    case, asked = study_of(name)
    place = cache_place().path
    options = {"limits": str(RUN_SECONDS), "restarts": str(place / RESTARTS)}
    local = Local(partial(opened, options=options), Entries(place))
    chosen = executor_of or (lambda _: local)
    arms, engine = asked.arms(level), usual_engine(case)
    known = earlier and read_runs(earlier, case, arms[0].parameters[0])
    rows: dict[str, Sequence[Row]] = {}
    missing: dict[str, str] = {}
    taken = 0
    if executor_of is not None:
        _check_all(case, engine, arms, executor_of, least_ranks, known or EarlierRuns({}))
    for ranks in sorted({max(arm.ranks, least_ranks) for arm in arms}):
        some = [arm for arm in arms if max(arm.ranks, least_ranks) == ranks]
        try:
            run = chosen(ranks)
            if known:
                run = known.beside(run, ranks)
                taken += sum(known.count(engine, ranks, arm.parameters) for arm in some)
            rows |= _rows_of(case, engine, some, run, ranks, progress)
        except (EngineMissingError, RequestError) as error:
            if ranks == least_ranks:
                raise
            missing |= {arm.name: " ".join(str(error).split()) for arm in some}
            rows |= {arm.name: () for arm in some}
    runs = [{"arm": arm, **row} for arm, found in rows.items() for row in found]
    found = asked.conclude(rows, points)
    return StudyResult(
        case.name, asked.title, asked.question, level, engine, tuple(runs), found, missing, taken
    )


def _check_all(
    case: Case[Any],
    engine: str,
    arms: Sequence[Arm],
    executor_of: ExecutorOf,
    least_ranks: int,
    known: EarlierRuns,
) -> None:
    """Raise RequestError for runs that an executor cannot make, before any is begun."""
    runs: dict[int, list[Parameters]] = {}
    for arm in arms:
        ranks = max(arm.ranks, least_ranks)
        left = [one for one in arm.parameters if not known.count(engine, ranks, [one])]
        runs.setdefault(ranks, []).extend(left)
    for ranks, some in runs.items():
        try:
            run = executor_of(ranks)
        except (EngineMissingError, RequestError):  # said where these arms are run
            continue
        if isinstance(run, CheckedExecutor):
            run.check(Work(case, engine, some))


def _rows_of(
    case: Case[Any],
    engine: str,
    arms: Sequence[Arm],
    run: Executor,
    ranks: int,
    progress: Progress,
) -> dict[str, Sequence[Row]]:
    """Return the rows of arms that are run together; what two of them share is run once."""
    points = [Point({}, one) for arm in arms for one in arm.parameters]
    plan = Plan(Asked(case.name, {}, {}), case, (engine,), tuple(points))
    made = iter(run_plan(plan, run, progress).rows)
    how = {"ranks": ranks, "script": script_digest(case, engine)}
    found = [{**how, **next(made)} for arm in arms for _ in arm.parameters]
    for row in found:
        row["ranks"] = row["ranks"] or ranks  # what was asked for, of a run that did not end
    rest = iter(found)
    return {arm.name: [next(rest) for _ in arm.parameters] for arm in arms}
