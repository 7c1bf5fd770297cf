"""Run the study of a case: its arms as sweeps are run, then what the case concludes from them.

Runs of an earlier study, of this machine or another, are read from its runs.csv and not made
again.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from harness.cases.contract import Case, LevelName, Measured
from harness.cases.registry import all_cases, get_case
from harness.cases.study import Arm, CaseStudy, Conclusion, EngineOf, Row, StudyCost
from harness.engines.registry import engine_class
from harness.errors import EngineMissingError, EngineUndecidedError, HarnessError, RequestError
from harness.files import RESTARTS, cache_place
from harness.observables.provenance import Provenance
from harness.observables.reference import ReferencePoints
from harness.parameters.base import Parameters
from harness.shown import Result
from harness.store.cache import opened
from harness.store.entries import Entries
from harness.workflows.case_runs import usual_engine
from harness.workflows.progress import Progress, silent
from harness.workflows.sweep_plan import (
    SweepPlan,
    SweepPoint,
    SweepRequest,
    parameter_columns,
    quantity_key,
)
from harness.workflows.sweep_run import (
    DONE,
    FAILED,
    UNDECIDED,
    CheckedExecutor,
    Executor,
    Local,
    Ran,
    Work,
    as_frame,
    run_plan,
    undecided,
)

if TYPE_CHECKING:
    import pandas as pd

    from harness.shown.figure import Figure


OF_A_RUN = ("engine", "engine_version", "ranks", "script", "status", "wall_time_s")
"""Columns that identify a run, with its parameters; quantities are further ones."""

RESTART_LINES = re.compile(r"^#> restarts\n.*?^#< restarts\n", re.MULTILINE | re.DOTALL)
"""Marks in a script, and the lines between them: how a run that was cut goes on."""

COMMENT_LINES = re.compile(r"^\s*#.*\n", re.MULTILINE)
"""Comments of a script; ``#`` begins them in the language of every engine that takes scripts."""

FURTHER = {"arm", "reason"}
LARGEST = 2**28
"""[bytes] of a file."""

Key = tuple[str, ...]


@dataclass(frozen=True)
class EarlierRuns:
    """The runs of a file that were done or are undecided, by engine, ranks and parameters."""

    rows: Mapping[Key, Measured | EngineUndecidedError]

    def count(self, engine: str, ranks: int, runs: Iterable[Parameters]) -> int:
        """Return how many of some runs are there."""
        return sum(_key(engine, ranks, run) in self.rows for run in runs)

    def or_run(self, executor: Executor, ranks: int) -> Executor:
        """Return what takes runs from the file where they are there, and else runs them."""

        def run(work: Work) -> Iterator[tuple[int, Ran]]:
            missing = []
            for place, parameters in enumerate(work.parameters):
                kept = self.rows.get(_key(work.engine, ranks, parameters))
                if kept is None:
                    missing.append(place)
                else:
                    yield place, kept
            if missing:
                for place, ran in _run_missing(executor, work, missing):
                    yield place, ran

        return run


def _run_missing(
    executor: Executor, work: Work, places: Sequence[int]
) -> Iterator[tuple[int, Ran]]:
    """Yield runs that are made; where some were known, an engine that is not here fails the rest.

    Where none was, it is raised.
    """
    rest = replace(work, parameters=[work.parameters[place] for place in places])
    yielded: set[int] = set()
    try:
        for place, ran in executor(rest):
            yielded.add(places[place])
            yield places[place], ran
    except (EngineMissingError, RequestError) as error:
        if len(places) == len(work.parameters):
            raise
        failed: HarnessError = error
        yield from ((place, failed) for place in places if place not in yielded)


def script_digest(case: Case[Any], engine: str) -> str:
    """Return a digest of the script that an engine runs for a case: another one is another run.

    Without what a script has between :data:`RESTARTS`, which does nothing in a run that writes no
    restart file, and without its comments, which name the version of the harness.
    """
    inputs = engine_class(engine).inputs([case.template])
    texts = {
        name: COMMENT_LINES.sub("", RESTART_LINES.sub("", text)) for name, text in inputs.items()
    }
    return hashlib.sha256(repr(sorted(texts.items())).encode()).hexdigest()[:12]


def read_runs(path: Path, case: Case[Any], example: Parameters) -> EarlierRuns:
    """Return the runs of a case in a file; ``example`` is an example of its parameters.

    Raise RequestError in a line for a file that cannot be read, has no such columns, or a value
    that is no number.
    """
    where = f"--runs {path}"
    rows = csv.DictReader(io.StringIO(_text(path, where)))
    try:
        parameters = tuple(parameter_columns(example))
        quantities = {quantity.name: quantity_key(quantity) for quantity in case.quantities}
        _check_columns(rows.fieldnames or (), (*OF_A_RUN, *parameters, *quantities.values()), where)
        scripts: dict[str, str] = {}
        runs: dict[Key, Measured | EngineUndecidedError] = {}
        results: dict[Key, tuple[str, Measured]] = {}
        for number, row in enumerate(rows, start=2):
            place = f"{where}, row {number}"
            if None in row or None in row.values():
                raise RequestError(f"{place}: must have as many values as there are columns")
            if row["status"] not in (DONE, UNDECIDED):
                continue
            _check_script(row, case, scripts, place)
            key = tuple(_plain(row[name]) for name in ("engine", "ranks", *parameters))
            values = {name: _number(row, column, place) for name, column in quantities.items()}
            kept = {name: value for name, value in values.items() if value is not None}
            provenance = Provenance(row["engine"], row["engine_version"])
            ranks = int(_number(row, "ranks", place) or 1)
            ran = Measured(kept, provenance, _number(row, "wall_time_s", place) or 0.0, ranks)
            result = row["status"], ran
            if results.setdefault(key, result) != result:
                raise RequestError(f"{place}: the same run as another row, with another result")
            runs[key] = (
                ran if row["status"] == DONE else undecided(row.get("reason") or "undecided", ran)
            )
    except csv.Error as error:
        raise RequestError(f"{where}: is no table ({error})") from None
    return EarlierRuns(runs)


def _text(path: Path, where: str) -> str:
    try:
        if path.stat().st_size > LARGEST:
            raise RequestError(f"{where}: is longer than {LARGEST} bytes")
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise RequestError(f"{where}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise RequestError(f"{where}: is no UTF-8 text") from None


def _check_columns(names: Sequence[str], wanted: Sequence[str], where: str) -> None:
    """Raise RequestError for a column that is missing, or that might tell runs apart."""
    missing = [name for name in wanted if name not in names]
    further = [name for name in names if name not in {*wanted, *FURTHER}]
    if missing or further:
        problem = f"no column {missing[0]}" if missing else f"an unknown column {further[0]}"
        raise RequestError(f"{where}: {problem}; must be the runs.csv of a study by this version")


def _check_script(
    row: Mapping[str, str], case: Case[Any], scripts: dict[str, str], place: str
) -> None:
    """Raise RequestError for a run by another script than the engine's own now."""
    engine = row["engine"]
    if engine not in scripts:
        scripts[engine] = script_digest(case, engine)
    if row["script"] != scripts[engine]:
        raise RequestError(
            f"{place}: script = {row['script'][:20]!r}: was made by another script of {case.name}; "
            f"this version's is {scripts[engine]!r}"
        )


def _number(row: Mapping[str, str], column: str, place: str) -> float | None:
    text = row[column]
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RequestError(f"{place}: {column} = {text[:40]!r} must be a finite number")
    return value


def _key(engine: str, ranks: int, parameters: Parameters) -> Key:
    return tuple(
        _plain(value) for value in (engine, ranks, *parameter_columns(parameters).values())
    )


def _plain(value: Any) -> str:
    """Return a value as it is compared: 8 and 8.0 are one, None is an empty cell."""
    text = "" if value is None else str(value)
    try:
        return repr(float(text))
    except ValueError:
        return text


RUN_SECONDS = 7200
"""That a run may take, or its part between two restart files: half an hour on an idle core."""

ExecutorOf = Callable[[int], Executor]
"""Returns what runs work with so many ranks of MPI in each run."""


@dataclass(frozen=True, repr=False)
class StudyResult(Result):
    """What a study found, with every run behind it; ``missing`` says why an arm has no runs.

    ``taken`` runs are those of an earlier study.
    """

    case: str
    title: str
    question: str
    level: LevelName
    engine: str
    runs: tuple[Row, ...]
    conclusion: Conclusion
    missing: Mapping[str, str] = field(default_factory=dict)
    taken: int = 0

    def count(self, status: str) -> int:
        """Return how many runs have a status, as ``done``, ``undecided`` or ``failed``."""
        return sum(row["status"] == status for row in self.runs)

    def to_json(self) -> dict[str, Any]:
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

    def to_frame(self) -> pd.DataFrame:
        """Return the rows of results as a table."""
        return as_frame(self.conclusion.rows)

    def summary(self) -> dict[str, str]:
        """Return the verdict and how many runs it rests on."""
        runs = ", ".join(f"{self.count(status)} {status}" for status in (DONE, UNDECIDED, FAILED))
        return {"verdict": " ".join(self.conclusion.verdict), "runs": runs, "level": self.level}

    def draw(self) -> Figure:
        """Draw the first figure of the report."""
        drawings = [drawing for section in self.conclusion.sections for drawing in section.drawings]
        if not drawings:
            raise RequestError(f"plot: no run of this study of {self.case} measured anything")
        return cast("Figure", drawings[0].draw())


def study_of(name: str) -> tuple[Case[Any], CaseStudy]:
    """Return a case and its study; raise RequestError for a case that has none."""
    case = get_case(name)
    case_study = case.study()
    if case_study is None:
        having = ", ".join(
            n for n, parameters in all_cases().items() if parameters.study() is not None
        )
        raise RequestError(f"case {name!r} has no study: must be one of {having}")
    return case, case_study


def planned(name: str, level: LevelName) -> tuple[int, float]:
    """Return how many runs a level of a study has, and their time on one core [s], kept or not.

    Raise RequestError for a case without a study.
    """
    case, case_study = study_of(name)
    rules = engine_class(usual_engine(case)).traits
    runs = {(other, arm.ranks) for arm in case_study.arms(level) for other in arm.parameters}
    return len(runs), sum(case.seconds(parameters, rules) for parameters, _ in runs)


def cost_of(
    name: str, level: LevelName, engine_of: EngineOf, earlier: Path | None = None
) -> StudyCost:
    """Return what a level of a study costs, by the wall times in a runs.csv or as measured here.

    Raise RequestError for a case without a study and for a bad file, EngineError where an engine
    is to be measured and is not here.
    """
    case, case_study = study_of(name)
    if earlier is None:
        return case_study.cost(level, engine_of)
    read_runs(earlier, case, case_study.arms(level)[0].parameters[0])  # raises for a bad file
    import pandas as pd

    frame = pd.read_csv(earlier)
    runs = frame[frame["status"] == DONE].to_dict("records")
    if not runs:
        raise RequestError(f"--runs {earlier}: has no run that is done")
    return case_study.cost(level, engine_of, [{str(key): row[key] for key in row} for row in runs])


def study(
    name: str,
    level: LevelName = "default",
    *,
    points: ReferencePoints | None = None,
    executor_of: ExecutorOf | None = None,
    progress: Progress = silent,
    earlier: Path | None = None,
    least_ranks: int = 1,
) -> StudyResult:
    """Run the study of a case at a level (``quick``, ``default``, ``full``) and conclude.

    Runs are kept and not run twice, so a study that was killed goes on. ``executor_of`` runs them
    elsewhere, on ``least_ranks`` of MPI at least, ``points`` are drawn with the results, and
    ``earlier`` is the runs.csv of a study before: what is done in it is taken from it. A run that
    fails is a row with the reason; an engine that cannot run with several ranks leaves that arm
    out. Raise RequestError for a case without a study and for a bad file, EngineError where the
    engine is not here.
    """
    case, case_study = study_of(name)
    place = cache_place().path
    options = {"limits": str(RUN_SECONDS), "restarts": str(place / RESTARTS)}
    local = Local(partial(opened, options=options), Entries(place))
    chosen = executor_of or (lambda _: local)
    arms, engine = case_study.arms(level), usual_engine(case)
    kept = earlier and read_runs(earlier, case, arms[0].parameters[0])
    rows: dict[str, Sequence[Row]] = {}
    missing: dict[str, str] = {}
    taken = 0
    if executor_of is not None:
        _check_all(case, engine, arms, executor_of, least_ranks, kept or EarlierRuns({}))
    for ranks in sorted({max(arm.ranks, least_ranks) for arm in arms}):
        some = [arm for arm in arms if max(arm.ranks, least_ranks) == ranks]
        try:
            run = chosen(ranks)
            if kept:
                run = kept.or_run(run, ranks)
                taken += sum(kept.count(engine, ranks, arm.parameters) for arm in some)
            rows |= _rows_of(case, engine, some, run, ranks, progress)
        except (EngineMissingError, RequestError) as error:
            if ranks == least_ranks:
                raise
            missing |= {arm.name: " ".join(str(error).split()) for arm in some}
            rows |= {arm.name: () for arm in some}
    runs = [{"arm": arm, **row} for arm, arm_rows in rows.items() for row in arm_rows]
    conclusion = case_study.conclude(rows, points)
    return StudyResult(
        case.name,
        case_study.title,
        case_study.question,
        level,
        engine,
        tuple(runs),
        conclusion,
        missing,
        taken,
    )


def _check_all(
    case: Case[Any],
    engine: str,
    arms: Sequence[Arm],
    executor_of: ExecutorOf,
    least_ranks: int,
    kept: EarlierRuns,
) -> None:
    """Raise RequestError for runs that an executor cannot make, before any is begun."""
    runs: dict[int, list[Parameters]] = {}
    for arm in arms:
        ranks = max(arm.ranks, least_ranks)
        missing = [
            parameters
            for parameters in arm.parameters
            if not kept.count(engine, ranks, [parameters])
        ]
        runs.setdefault(ranks, []).extend(missing)
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
    points = [SweepPoint({}, parameters) for arm in arms for parameters in arm.parameters]
    plan = SweepPlan(SweepRequest(case.name, {}, {}), case, (engine,), tuple(points))
    new_rows = iter(run_plan(plan, run, progress).rows)
    how = {"ranks": ranks, "script": script_digest(case, engine)}
    of_arms = [{**how, **next(new_rows)} for arm in arms for _ in arm.parameters]
    for row in of_arms:
        row["ranks"] = row["ranks"] or ranks  # what was asked for, of a run that did not end
    rest = iter(of_arms)
    return {arm.name: [next(rest) for _ in arm.parameters] for arm in arms}
