"""Sweep a case over its parameters and over engines: one tidy row a run, and a figure.

The cache is the memory: a run that is done is not made again, and a sweep that was killed goes on.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Executor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from harness import __version__
from harness.cases.base import Case, Value
from harness.cases.bench import Bench
from harness.cases.registry import ALL, get_case, words_in
from harness.engines.base import Engine, Job
from harness.engines.process import cores, parallel_each
from harness.engines.registry import engine_class, engine_title
from harness.errors import (
    EngineError,
    EngineMissingError,
    EngineOutputError,
    EngineUndecidedError,
    HarnessError,
    RequestError,
)
from harness.files import Writer, check_writable, made_folder, text_writer, write_files
from harness.model.base import unit
from harness.report.content import Plottable
from harness.report.figures import Figure, axis, figure_writer, label
from harness.store.cache import opened
from harness.workflows import Progress, silent
from harness.workflows.executors import completed, opened_on
from harness.workflows.runs import (
    OpenEngine,
    is_search,
    is_solver,
    run_seconds,
    takes_job,
    usual_runner,
)
from harness.workflows.settings import (
    NONE,
    PRESET,
    Point,
    Points,
    SweepRequest,
    as_text,
    points_of,
    quantity_names,
    read_points,
    request_in,
    selected_engines,
    swept_texts,
    texts_of,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

CHUNK = 512  # runs whose jobs are in memory at a time
SEARCHES = 64  # that wait for the runs of an executor at a time
REQUEST, ROWS = "sweep.json", "rows.csv"
DONE, FAILED, NOT_TESTED = "done", "failed", "not tested"
UNDECIDED, REFUSED, PENDING = "undecided", "refused", "pending"
STATUSES = (DONE, UNDECIDED, FAILED, NOT_TESTED, REFUSED)  # of runs that are over
FIXED_COLUMNS = ("engine", "engine_version", PRESET, "status", "reason", "wall_time_s")
LOGARITHMIC = 20.0  # ratio of largest to smallest value from which an axis is logarithmic
MARKERS = "osD^v<>p*h"
Row = dict[str, Any]
Outcome = Mapping[str, Value | float] | HarnessError


@dataclass(frozen=True, repr=False)
class Sweep(Plottable):
    """A sweep as a table: a row for each point in each engine or solver, pending until it is run.

    ``table`` has the rows by engine, in the order of the points; ``missing`` are engines of ``all``
    that could not be opened, with the reason.
    """

    request: SweepRequest
    case: Case[Any]
    engines: tuple[str, ...]
    quantities: tuple[str, ...]
    points: tuple[Point, ...]
    table: dict[str, list[Row]] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        values = dict.fromkeys(self.columns.values())
        for engine in self.engines:
            self.table[engine] = [
                {
                    **{"engine": engine, "engine_version": "", **point.columns, **values},
                    "status": REFUSED if point.refusal else PENDING,
                    "reason": point.refusal,
                    "wall_time_s": None,
                }
                for point in self.points
            ]

    @property
    def rows(self) -> list[Row]:
        """Return the rows of all engines that are not missing."""
        engines = [rows for name, rows in self.table.items() if name not in self.missing]
        return list(chain.from_iterable(engines))

    @cached_property
    def columns(self) -> dict[str, str]:
        """Return the column of each quantity: its name, or ``measured_NAME`` where that is taken.

        The requested quantities come first; all others of the same search join them, and without
        a request all that one run measures. A value that is uncertain has a column
        ``uncertainty_NAME`` too.
        """
        requested = [self.case.quantity(name) for name in self.quantities]
        varies = requested[0].varies if requested else ()
        alike = [q for q in self.case.quantities if q.varies == varies]
        measured = requested if requested and not varies else [*requested, *alike]
        taken = {*FIXED_COLUMNS, *self.case.parameters.model_fields}
        names = dict.fromkeys(quantity.name for quantity in measured)
        return {name: f"measured_{name}" if name in taken else name for name in names}

    def seconds(self) -> float:
        """Return the expected time of all runs on one core [s], cached ones among them.

        A run that the case refuses takes none; raise RequestError where it refuses all.
        """
        runs, total = [point.parameters for point in self.points if not point.refusal], 0.0
        refusal: RequestError | None = None
        for name in self.engines:
            with suppress(EngineMissingError):  # of another package: it makes no run
                traits = None if is_solver(self.case, name) else engine_class(name).traits
                for run in runs:
                    try:
                        total += run_seconds(self.case, run, traits, self.quantities)
                    except RequestError as error:  # of which its row has the reason
                        refusal = error
        if refusal is not None and not total:
            raise refusal
        return total

    def count(self, status: str) -> int:
        """Return how many rows have a status: one of :data:`STATUSES`, or ``pending``."""
        return sum(row["status"] == status for row in self.rows)

    def to_json(self) -> dict[str, Any]:
        """Return the sweep as a JSON-ready mapping."""
        counts = {status.replace(" ", "_"): self.count(status) for status in STATUSES}
        record = {"case": self.case.name, "over": list(self.request.swept), **counts}
        return {**record, "missing_engines": self.missing, "rows": self.rows}

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a table; what a run does not have is NaN."""
        rows = [{k: math.nan if v is None else v for k, v in row.items()} for row in self.rows]
        return pd.DataFrame(rows, columns=None if rows else FIXED_COLUMNS)

    def summary(self) -> dict[str, str]:
        """Return the number of runs, the case and the engines."""
        counts = ((self.count(status), status) for status in STATUSES)
        return {
            "runs": ", ".join(f"{number} {status}" for number, status in counts if number),
            "case": f"{self.case.name} over {', '.join(self.request.swept)}",
            "engines": ", ".join(self.engines),
        }

    def points_in(self, file: Path) -> Points:
        """Return measured points of a file for the figure; raise RequestError for a bad one."""
        name, column = next(iter(self.columns.items()))
        errors = (f"uncertainty_{name}", f"uncertainty_{self.case.quantity(name).unit}")
        return read_points(file, self.request.swept[0], column, errors)

    def draw(self) -> Figure:
        """Draw the first quantity over the first parameters; RequestError where there is none."""
        if (figure := self.figure()) is None:
            raise RequestError(f"no run of this sweep of {self.case.name} measured anything")
        return figure

    def figure(self, points: Points | None = None) -> Figure | None:
        """Draw the first quantity, and the user's points; None where nothing was measured."""
        over, (name, column) = self.request.swept, next(iter(self.columns.items()))
        frame, across = self.to_frame(), over[0]
        done = frame[frame["status"] == DONE]
        if across not in done or done[column].isna().all():
            return None
        figure = Figure(layout="constrained")
        axes = figure.add_subplot()
        second = [parameter for parameter in over[1:2] if parameter in done]
        groups = done.groupby(["engine", *second], sort=False, dropna=False)
        for place, (key, rows) in enumerate(groups):
            rows = rows.drop_duplicates(across).sort_values(across)
            engine, *values = (NONE if value != value else value for value in key)  # NaN
            others = [self._value_text(n, v) for n, v in zip(second, values, strict=True)]
            axes.errorbar(rows[across], rows[column], yerr=rows.get(f"uncertainty_{name}"),
                          ls=":", ms=5, capsize=2, marker=MARKERS[place % len(MARKERS)],
                          label=", ".join([engine_title(str(engine)), *others]))  # fmt: skip
        self._draw_exact(axes, name, across)
        if points is not None:
            axes.errorbar(points.x, points.y, yerr=points.uncertainty, fmt="kx", label=points.name)
        numbers = pd.to_numeric(done[across], errors="coerce")
        if (numbers > 0).all() and numbers.max() >= LOGARITHMIC * numbers.min():
            axes.set_xscale("log")
        units = unit(type(self.case.default), across), self.case.quantity(name).unit
        label(axes, axis(across, units[0]), axis(column, units[1]), self.case.name)
        axes.legend()
        return figure

    def _value_text(self, name: str, value: Any) -> str:
        text = f"{value:g}" if isinstance(value, float) else str(value)
        return f"{name} = {text} {unit(type(self.case.default), name)}".rstrip()

    def _draw_exact(self, axes: Axes, name: str, across: str) -> None:
        curves: dict[tuple[str, ...], dict[float, float]] = {}
        for point in self.points:
            try:
                value = _tried(self.case.exact, point.parameters).get(name, math.nan)
                x = float(point.swept[across])
            except (AttributeError, KeyError, ValueError):  # an error, refused, or a word
                continue
            others = tuple(text for key, text in point.swept.items() if key != across)
            if math.isfinite(value):
                curves.setdefault(others, {})[x] = value
        for place, curve in enumerate(curves.values()):
            line, legend = zip(*sorted(curve.items()), strict=True), self.case.exact_by
            axes.plot(*line, "k-", lw=1, zorder=0, label=None if place else legend)


def sweep(  # noqa: PLR0913 - the options of a user
    case: str,
    over: Mapping[str, Any] | None = None,
    *,
    fixed: Mapping[str, Any] | None = None,
    engines: str | Iterable[str] = "",
    quantities: str | Iterable[str] = "",
    output: str | Path | None = None,
    reference: str | Path | None = None,
    open_engine: OpenEngine | None = None,
    executor: Executor | None = None,
    check: Callable[[Sweep], None] = lambda _: None,
    progress: Progress = silent,
) -> Sweep:
    """Run a case at every combination of the values of its parameters, in each engine.

    ``case`` is a name, or a file ``*.toml`` with a sweep. ``over`` maps names of parameters, of
    nested ones with a dot, to sequences of values or to text such as ``1e5:1e7:log5``; ``fixed``
    are values of all runs. ``engines`` are engines and solvers of the case. With an ``executor``
    its workers make the runs, but those of engines that ``open_engine`` opens. ``output`` is a
    folder for table and figure, where the same sweep goes on, and which no other may have;
    ``reference`` a table of measured points for the figure. ``check`` is called with the sweep
    before anything runs, and may raise. A run that fails is a row. Raise RequestError for a name or
    value that is not allowed; EngineMissingError for an engine that is named and not here.
    """
    planned = plan(case, over, fixed, engines, quantities)
    points = None if reference is None else planned.points_in(Path(reference))
    check(planned)
    opening = open_engine or (opened if executor is None else partial(opened_on, executor))
    if output is None:
        _make_runs(planned, opening, executor, progress)
        return planned
    folder = Path(output)
    with _taken_folder(folder, planned.request):
        _make_runs(planned, opening, executor, progress)
        files: dict[tuple[str, Path], Writer] = {
            ("--output", folder / ROWS): partial(planned.to_frame().to_csv, index=False)
        }
        figure = planned.figure(points)
        for name in ("figure.svg", "figure.png"):
            if figure is None:
                (folder / name).unlink(missing_ok=True)  # of runs that were made before
            else:
                files["--output", folder / name] = figure_writer(lambda: figure)
        write_files(files)
    return planned


def plan(
    case: str,
    over: Mapping[str, Any] | None = None,
    fixed: Mapping[str, Any] | None = None,
    engines: str | Iterable[str] = "",
    quantities: str | Iterable[str] = "",
) -> Sweep:
    """Return a sweep whose rows are pending; takes and raises what :func:`sweep` does.

    What is given here wins over the file.
    """
    file = Path(case) if str(case).endswith(".toml") else None
    base = SweepRequest(case=case) if file is None else request_in(file)
    swept, same = swept_texts(over or {}), texts_of(fixed or {})
    grids = base.over or (({},) if swept else ())
    request = base.replace(
        over=tuple({**grid, **swept} for grid in grids),
        set={**base.set, **same},
        engines=as_text(engines) or base.engines,
        quantity=as_text(quantities) or base.quantity,
    )
    try:
        chosen = get_case(request.case)
        names = tuple(quantity_names(chosen, request.quantity))
        points = points_of(chosen, request, names)
        return Sweep(request, chosen, _engines(chosen, request.engines), names, tuple(points))
    except RequestError as error:
        if file is None:
            raise
        raise RequestError(f"{file}: {error}") from None


def _engines(case: Case[Any], text: str) -> tuple[str, ...]:
    """Return engines and solvers; of ``all`` those that can run the case."""
    if not text:
        return (usual_runner(case),)
    always = {*words_in(text), *case.solvers}

    def can_run(name: str) -> bool:
        try:
            return name in always or takes_job(engine_class(name), case)
        except EngineMissingError:  # of another package: the reason is that of opening it
            return True

    return tuple(filter(can_run, selected_engines(text, case.solvers)))


# ---- runs


def _make_runs(
    planned: Sweep, open_engine: OpenEngine, executor: Executor | None, progress: Progress
) -> None:
    """Fill the table. Raise EngineMissingError for an engine that is named and not here."""
    count = sum(not point.refusal for point in planned.points)
    for engine in planned.engines:
        progress(engine, 0, count)
        try:
            runs = _runs(planned, engine, open_engine, executor)
            for done, (place, outcome, facts) in enumerate(runs, 1):
                planned.table[engine][place] |= {**_cells(outcome, planned.columns), **facts}
                progress(engine, done, count)
        except EngineMissingError as error:
            if ALL not in words_in(planned.request.engines):
                raise
            planned.missing[engine] = str(error)


def _runs(
    planned: Sweep, name: str, open_engine: OpenEngine, executor: Executor | None
) -> Iterator[tuple[int, Outcome, Row]]:
    """Yield place, outcome and other cells of each run as soon as it is over, in any order."""
    case, points = planned.case, planned.points
    places = [place for place, point in enumerate(points) if not point.refusal]
    if is_solver(case, name):
        calls = [(case.name, points[place].parameters, name) for place in places]
        local = ((index, solved(*call)) for index, call in enumerate(calls))
        for index, outcome in local if executor is None else completed(executor, solved, calls):
            yield places[index], outcome, {"engine_version": f"dem-harness {__version__}"}
        return
    with open_engine(name) as engine:
        facts: Row = {"engine_version": engine.identify().engine_version}
        if is_search(case, planned.quantities):
            search = partial(_searched, planned, engine)
            at_once = SEARCHES if executor else cores()
            for index, outcome in parallel_each(search, [points[i] for i in places], at_once):
                yield places[index], outcome, facts
            return
        for first in range(0, len(places), CHUNK):
            tried = {i: _job(case, points[i], engine) for i in places[first : first + CHUNK]}
            yield from ((i, job, facts) for i, job in tried.items() if not isinstance(job, Job))
            jobs = [(i, job) for i, job in tried.items() if isinstance(job, Job)]
            for index, output in engine.outcomes([job for _, job in jobs]) if jobs else ():
                place = jobs[index][0]
                if isinstance(output, EngineError):
                    yield place, output, facts
                else:
                    outcome = _values(case.measure, points[place].parameters, output)
                    yield place, outcome, {**facts, "wall_time_s": output.seconds}


def solved(case: str, parameters: Any, solver: str) -> Outcome:
    """Return what a solver of a case returns, or its error."""
    return _values(get_case(case).solve, parameters, solver)


def _searched(planned: Sweep, engine: Engine, point: Point) -> Outcome:
    job = _job(planned.case, point, engine)
    if not isinstance(job, Job):
        return job
    search, names = planned.case.search, [*planned.columns]
    return _values(search, names, point.parameters, Bench(engine), **point.options)


def _job(case: Case[Any], point: Point, engine: Engine) -> Job | HarnessError:
    job = _tried(case.job, point.parameters)
    reason = engine.refuses(job) if isinstance(job, Job) else ""
    return RequestError(reason) if reason else job


def _values(call: Callable[..., Mapping[str, Any]], *arguments: Any, **options: Any) -> Outcome:
    """Return the values of a run, or its error."""
    outcome: Outcome = _tried(lambda: dict(call(*arguments, **options)))
    return outcome


def _tried(call: Callable[..., Any], *arguments: Any, **options: Any) -> Any:
    """Return the result of a call or its error: one run must not cost the others."""
    try:
        return call(*arguments, **options)
    except HarnessError as error:
        return error
    except Exception as error:  # of a solver that overflows, of a case of another package
        return EngineOutputError(f"{type(error).__name__}: {error}")


def _cells(outcome: Outcome, columns: Mapping[str, str]) -> Row:
    """Return the cells of a run that is over: values, status and the reason of an error."""
    values: Mapping[str, Value | float] = {}
    match outcome:
        case EngineUndecidedError():
            values, status = outcome.values, UNDECIDED
        case EngineError():
            status = FAILED
        case HarnessError():
            status = NOT_TESTED
        case _:
            values, status = outcome, DONE
    cells: Row = {"status": status}
    if isinstance(outcome, HarnessError):
        cells["reason"] = " ".join(str(outcome).split())
    for name in (name for name in columns if name in values):
        value = Value.of(values[name])
        cells[columns[name]] = value.value
        if value.uncertainty:
            cells[f"uncertainty_{name}"] = value.uncertainty
    return cells


# ---- files


@contextmanager
def _taken_folder(folder: Path, request: SweepRequest) -> Iterator[None]:
    """Write the request; take back what was made here on any exception.

    Raise RequestError for a folder with another sweep or other files.
    """
    file, text = folder / REQUEST, json.dumps(request.model_dump(), indent=2) + "\n"
    is_new = not file.exists()
    check_writable(folder)
    if file.is_file() and file.read_text(encoding="utf-8", errors="replace") != text:
        raise RequestError(f"--output {folder}: has another sweep, see {REQUEST}; name another")
    if not file.is_file() and any(path.name[0] != "." for path in folder.glob("*")):
        raise RequestError(f"--output {folder}: holds files of no sweep; name another")
    with made_folder(folder):
        write_files({("--output", file): text_writer(text)})
        try:
            yield
        except BaseException:
            if is_new:
                file.unlink(missing_ok=True)
            raise
