"""Sweep a case over its parameters and over engines: one tidy row a run.

The cache is the memory: a run that is done is not made again, and a sweep that was killed goes on.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness import __version__
from harness.cases.base import Value
from harness.cases.bench import Bench, job_key
from harness.cases.registry import ALL, get_case
from harness.engines.base import Engine, Job
from harness.engines.jobs import cores, parallel_each
from harness.errors import (
    EngineError,
    EngineMissingError,
    EngineOutputError,
    EngineUndecidedError,
    HarnessError,
    RequestError,
)
from harness.files import check_writable, lock_file, text_writer, write_files
from harness.report.notebook import Shown
from harness.store.cache import opened
from harness.workflows.executors import completed, opened_on
from harness.workflows.progress import Progress, silent
from harness.workflows.runs import OpenEngine, searched
from harness.workflows.settings import PRESET, as_text, flat_values
from harness.workflows.sweep_plan import Point, SweepPlan, SweepRequest, plan

if TYPE_CHECKING:
    import pandas as pd

    from harness.report.style import Figure
    from harness.workflows.points import Points

CHUNK = 512  # runs whose jobs are in memory at a time
SEARCHES = 64  # that wait for the runs of an executor at a time
LOCK, REQUEST = ".lock", "sweep.json"
DONE, FAILED, NOT_TESTED = "done", "failed", "not tested"
UNDECIDED, REFUSED, PENDING = "undecided", "refused", "pending"
STATUSES = (DONE, UNDECIDED, FAILED, NOT_TESTED, REFUSED, PENDING)
Row = Mapping[str, Any]


@dataclass(frozen=True)
class Ran:
    """What became of a run: its values by quantity, or the error; ``seconds`` of wall time."""

    values: Mapping[str, Value] = field(default_factory=dict)
    version: str = ""
    seconds: float | None = None
    error: HarnessError | None = None

    @property
    def status(self) -> str:
        """Return the status of its row."""
        if self.error is None:
            return DONE
        if isinstance(self.error, EngineUndecidedError):
            return UNDECIDED
        return FAILED if isinstance(self.error, EngineError) else NOT_TESTED


@dataclass(frozen=True, repr=False)
class Sweep(Shown):
    """The rows of a sweep, flat: engine, parameters, quantities, status.

    ``missing`` are engines of ``all`` that could not be opened, with the reason.
    """

    plan: SweepPlan
    rows: tuple[Row, ...]
    missing: Mapping[str, str] = field(default_factory=dict)

    def count(self, status: str) -> int:
        """Return how many rows have a status, one of :data:`STATUSES`."""
        return sum(row["status"] == status for row in self.rows)

    def to_json(self) -> dict[str, Any]:
        """Return the sweep as a JSON-ready mapping."""
        counts = {s.replace(" ", "_"): self.count(s) for s in STATUSES if s != PENDING}
        record = {"case": self.plan.case.name, "over": list(self.plan.request.over), **counts}
        rows = [dict(row) for row in self.rows]
        return {**record, "missing_engines": dict(self.missing), "rows": rows}

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a table; what a run does not have is NaN."""
        return as_frame(self.rows)

    def summary(self) -> dict[str, str]:
        """Return the number of runs, the case and the engines."""
        counts = ((self.count(status), status) for status in STATUSES)
        return {
            "runs": ", ".join(f"{number} {status}" for number, status in counts if number),
            "case": f"{self.plan.case.name} over {', '.join(self.plan.request.over)}",
            "engines": ", ".join(self.plan.engines),
        }

    def draw(self) -> Figure:
        """Draw the first quantity over the first parameters; RequestError where there is none."""
        if (figure := self.figure()) is None:
            raise RequestError(f"no run of this sweep of {self.plan.case.name} measured anything")
        return figure

    def figure(self, points: Points | None = None) -> Figure | None:
        """Return the figure, with the user's points; None where nothing was measured."""
        from harness.workflows.sweep_figure import sweep_figure

        return sweep_figure(self.plan, self.to_frame(), points)


def sweep(
    case: str,
    over: Mapping[str, Any],
    *,
    fixed: Mapping[str, Any] | None = None,
    engines: str | Iterable[str] = "",
    quantities: str | Iterable[str] = "",
    open_engine: OpenEngine = opened,
    executor: Executor | None = None,
    progress: Progress = silent,
) -> Sweep:
    """Run a case at every combination of the values of its parameters, in each engine.

    ``over`` maps names of parameters, of nested ones with a dot, to sequences of values or to text
    such as ``1e5:1e7:log5``; ``fixed`` are values of all runs. ``engines`` are engines and solvers
    of the case. With an ``executor`` its workers make the runs, in place of ``open_engine``. A run
    that fails is a row. Raise RequestError for a name or value that is not allowed;
    EngineMissingError for an engine that is not here.
    """
    texts = {name: as_text(values) for name, values in over.items()}
    same = {name: as_text(value) for name, value in (fixed or {}).items()}
    request = SweepRequest(case, (texts,), same, as_text(engines), as_text(quantities))
    runner = Runner(open_engine if executor is None else partial(opened_on, executor), executor)
    return run_plan(plan(request), runner, progress=progress)


@dataclass(frozen=True)
class Runner:
    """Makes the runs of a sweep: in engines, in processes of an executor if there is one."""

    open_engine: OpenEngine = opened
    executor: Executor | None = None

    def outcomes(self, chosen: SweepPlan, engine: str) -> Iterator[tuple[int, Ran]]:
        """Yield the place and the outcome of each run as soon as it is over, in any order.

        Raise EngineError where the engine cannot be opened.
        """
        places = [i for i, point in enumerate(chosen.points) if point.parameters is not None]
        points = [chosen.points[place] for place in places]
        if chosen.solves(engine):
            calls = [(chosen.case.name, point.parameters, engine) for point in points]
            found: Iterable[tuple[int, Ran | EngineError]]
            if self.executor is None:
                found = ((i, solved(*call)) for i, call in enumerate(calls))
            else:
                found = completed(self.executor, solved, calls)
            for index, ran in found:
                yield places[index], Ran(error=ran) if isinstance(ran, EngineError) else ran
            return
        with self.open_engine(engine) as running:
            if searched(chosen.case, chosen.quantities):
                search = partial(_searched, chosen, running)
                at_once = SEARCHES if self.executor else cores()
                for index, ran in parallel_each(search, points, at_once):
                    yield places[index], ran
                return
            for first in range(0, len(places), CHUNK):
                yield from _in_engine(chosen, running, places[first : first + CHUNK])


def solved(case: str, parameters: Any, solver: str) -> Ran:
    """Return what a solver of a case finds, or its error."""
    return _tried(lambda: get_case(case).solve(parameters, solver), f"dem-harness {__version__}")


def run_plan(
    chosen: SweepPlan,
    runner: Runner,
    *,
    progress: Progress = silent,
    partial_table: Callable[[Callable[[], Sequence[Row]]], None] = lambda _: None,
) -> Sweep:
    """Make the runs of a plan; ``partial_table`` gets a function of the rows after each run."""
    ran: dict[tuple[str, int], Ran] = {}
    missing: dict[str, str] = {}
    everything = ALL in chosen.request.engines.split(",")

    def rows() -> tuple[Row, ...]:
        kept = [engine for engine in chosen.engines if engine not in missing]
        pairs = [(engine, i) for engine in kept for i in range(len(chosen.points))]
        return tuple(row_of(chosen, engine, i, ran.get((engine, i))) for engine, i in pairs)

    count = len([point for point in chosen.points if not point.refused])
    for engine in chosen.engines:
        progress(engine, 0, count)
        try:
            for done, (place, outcome) in enumerate(runner.outcomes(chosen, engine), 1):
                ran[engine, place] = outcome
                progress(engine, done, count)
                partial_table(rows)
        except EngineMissingError as error:
            if not everything:
                raise
            missing[engine] = str(error)
    return Sweep(chosen, rows(), missing)


def row_of(chosen: SweepPlan, engine: str, place: int, ran: Ran | None) -> Row:
    """Return the row of a run; that of one that has not ended is pending."""
    point = chosen.points[place]
    row: dict[str, Any] = {"engine": engine, "engine_version": ran.version if ran else ""}
    if PRESET in chosen.request.over or PRESET in chosen.request.fixed:
        row[PRESET] = {**chosen.request.fixed, **point.swept}[PRESET]
    row |= _parameter_columns(chosen, point)
    for name, column in chosen.columns().items():
        value = ran.values.get(name) if ran else None
        row[column] = value.value if value else None
        uncertainty = chosen.uncertainty_column(name)
        if chosen.case.quantity(name).varies and uncertainty not in chosen.measured:
            row[uncertainty] = value.uncertainty if value else None
    status = REFUSED if point.refused else ran.status if ran else PENDING
    reason = point.refused or (str(ran.error) if ran and ran.error else "")
    seconds = ran.seconds if ran else None
    return {**row, "status": status, "reason": " ".join(reason.split()), "wall_time_s": seconds}


def as_frame(rows: Sequence[Row]) -> pd.DataFrame:
    """Return flat rows as a table; what a row does not have is NaN."""
    import pandas as pd

    return pd.DataFrame([{k: math.nan if v is None else v for k, v in r.items()} for r in rows])


@contextlib.contextmanager
def held_sweep(folder: Path, request: SweepRequest) -> Iterator[None]:
    """Lock a folder for a sweep until the block, or the process, ends.

    Raise RequestError for a folder that another process sweeps in, that has another sweep or other
    files, or that cannot be written.
    """
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--output {folder}: is a file; name a folder")
    check_writable(folder)
    folder.mkdir(parents=True, exist_ok=True)
    there = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    if there and REQUEST not in there:
        raise RequestError(f"--output {folder}: holds files of no sweep; name another")
    with contextlib.ExitStack() as stack:
        try:
            lock = stack.enter_context(lock_file(folder / LOCK))
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise RequestError(f"--output {folder}: another sweep runs in it") from None
        except OSError as error:
            raise RequestError(f"--output {folder}: {LOCK}: {error.strerror}") from None
        _write_request(folder, json.dumps(asdict(request), indent=2) + "\n")
        yield


def _write_request(folder: Path, text: str) -> None:
    file = folder / REQUEST
    if not file.is_file():
        write_files({("--output", file): text_writer(text)})
    elif file.read_text(encoding="utf-8", errors="replace") != text:
        raise RequestError(f"--output {folder}: has another sweep, see {REQUEST}; name another")


def _in_engine(
    chosen: SweepPlan, engine: Engine, places: Sequence[int]
) -> Iterator[tuple[int, Ran]]:
    version = engine.identify().engine_version
    jobs: dict[Any, tuple[Job, list[int]]] = {}
    for place in places:
        try:
            job = chosen.case.job(chosen.points[place].parameters)
            if reason := engine.refuses(job):
                raise RequestError(reason)
        except HarnessError as error:
            yield place, Ran(version=version, error=error)
        else:
            jobs.setdefault(job_key(job), (job, []))[1].append(place)
    same = list(jobs.values())
    for index, outcome in engine.outcomes([job for job, _ in same]) if same else ():
        for place in same[index][1]:
            if isinstance(outcome, EngineError):
                yield place, _undecided(Ran(version=version, error=outcome))
                continue
            measure = partial(chosen.case.measure, chosen.points[place].parameters, outcome)
            yield place, replace(_tried(measure, version), seconds=outcome.seconds)


def _searched(chosen: SweepPlan, engine: Engine, point: Point) -> Ran:
    case, version = chosen.case, engine.identify().engine_version
    parameters = point.parameters

    def search() -> Mapping[str, Value | float]:
        if reason := engine.refuses(case.job(parameters)):
            raise RequestError(reason)
        return case.search(chosen.measured, parameters, Bench(engine), **point.options)

    return _tried(search, version)


def _tried(measure: Callable[[], Mapping[str, Value | float]], version: str) -> Ran:
    """Return what a measurement finds, or its error: one value must not cost the others."""
    try:
        found = measure().items()
        return Ran({n: v if isinstance(v, Value) else Value(float(v)) for n, v in found}, version)
    except HarnessError as error:
        return _undecided(Ran(version=version, error=error))
    except Exception as error:  # a case of another package may raise anything
        text = f"{type(error).__name__}: {error}"
        return Ran(version=version, error=EngineOutputError(text))


def _undecided(ran: Ran) -> Ran:
    if not isinstance(ran.error, EngineUndecidedError):
        return ran
    return replace(ran, values={name: Value(value) for name, value in ran.error.values.items()})


def _parameter_columns(chosen: SweepPlan, point: Point) -> dict[str, Any]:
    """Return the parameters of a point; of a refused one, what was set and swept."""
    if point.parameters is not None:
        varied = {v for name in chosen.quantities for v in chosen.case.quantity(name).varies}
        values = {n: v for n, v in flat_values(point.parameters).items() if n not in varied}
        return values | dict(point.options)
    names = flat_values(chosen.case.default)
    settings = {**chosen.request.fixed, **point.swept}
    return dict.fromkeys(names) | {n: _number(t) for n, t in settings.items() if n != PRESET}


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
