"""Sweep a case over its parameters and over engines: one tidy row a run.

The folder of a sweep is held by one process at a time, and the same sweep takes it up again. Runs
are made in the engine's own workers, or in a solver of the case.
"""

from __future__ import annotations

import contextlib
import fcntl
import inspect
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness import __version__
from harness.cases.contract import Case, Measured
from harness.cases.registry import get_case
from harness.engines.contract import Engine, Job, Output
from harness.engines.process import cores, parallel_each
from harness.engines.registry import engine_title
from harness.errors import (
    EngineError,
    EngineMissingError,
    EngineOutputError,
    EngineUndecidedError,
    HarnessError,
    RequestError,
)
from harness.files import cache_place, check_writable, held_folder, lock_file
from harness.observables.provenance import Provenance
from harness.parameters.base import Parameters
from harness.shown import Result
from harness.store.cache import opened
from harness.store.entries import (
    ROOT,
    Entries,
    digest_of_tree,
    key_of,
    machine,
    source_digest,
    versions,
)
from harness.workflows.case_runs import PRESET, is_solver, parameters_in
from harness.workflows.progress import Progress, silent
from harness.workflows.sweep_plan import (
    ALL,
    RefusedPoint,
    SweepPlan,
    SweepPoint,
    SweepRequest,
    as_text,
    column_of,
    names_in,
    parameter_columns,
    plan,
    quantity_columns,
    swept_columns,
)
from harness.workflows.verification import Open

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure as AnyFigure

    from harness.observables.reference import Points
    from harness.shown.figure import Figure


LOCK, REQUEST = ".lock", "sweep.json"


@contextlib.contextmanager
def held_sweep(folder: Path, request: SweepRequest) -> Iterator[None]:
    """Hold a folder for a sweep; the kernel lets go of it when the process ends, however it does.

    Raise RequestError for a folder that another process sweeps in, that holds another sweep or
    something else, or that cannot be written.
    """
    if folder.exists() and not folder.is_dir():
        raise RequestError(f"--output {folder}: is a file; name a folder")
    check_writable(folder)
    folder.mkdir(parents=True, exist_ok=True)
    there = {path.name for path in folder.iterdir() if not path.name.startswith(".")}
    if there and REQUEST not in there:
        raise RequestError(f"--output {folder}: holds files that are no sweep; name another")
    with contextlib.ExitStack() as held:
        try:
            lock = held.enter_context(lock_file(folder / LOCK))
        except OSError as error:
            raise RequestError(f"--output {folder}: {LOCK}: {error.strerror}") from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise RequestError(f"--output {folder}: another sweep runs in it") from None
        _check_same(folder, json.dumps(vars(request), indent=2) + "\n")
        yield


def _check_same(folder: Path, text: str) -> None:
    """Write down what is swept; raise RequestError where it is something else already."""
    file = folder / REQUEST
    if not file.is_file():
        with held_folder(folder) as aside:
            (aside / REQUEST).write_text(text, encoding="utf-8")
            (aside / REQUEST).replace(file)
    elif file.read_text(encoding="utf-8", errors="replace") != text:
        raise RequestError(
            f"--output {folder}: holds another sweep ({REQUEST} says which); name another"
        )


CHUNK = 512
"""Runs whose jobs are held at a time."""

Ran = Measured | HarnessError
"""What became of a run: RequestError where the engine cannot state it."""


@dataclass(frozen=True)
class Work:
    """Runs of one case in one engine, or one solver of the case."""

    case: Case[Any]
    engine: str
    parameters: Sequence[Parameters]


@dataclass(frozen=True)
class Runner:
    """Makes the runs of a sweep; ``entries`` keep what solvers found, nothing for None."""

    open_one: Open = opened
    entries: Entries | None = None
    fresh: bool = False

    def outcomes(self, work: Work) -> Iterator[tuple[int, Ran]]:
        """Yield the place and the outcome of each run as soon as it is over, in any order.

        Raise EngineError where the engine itself cannot be opened.
        """
        if is_solver(work.case, work.engine):
            for place, parameters in enumerate(work.parameters):
                yield place, self._solved(work, parameters)
            return
        with self.open_one(work.engine) as engine:
            if work.case.varied:
                run_parameters = partial(measured, work.case, engine=engine)
                yield from parallel_each(run_parameters, work.parameters, cores())
                return
            for first in range(0, len(work.parameters), CHUNK):
                yield from _in_engine(work, engine, range(first, first + CHUNK))

    def _solved(self, work: Work, parameters: Parameters) -> Ran:
        """Return what a solver finds, or found before."""
        key = self._key(work, parameters)
        kept = None if self.fresh or self.entries is None else self.entries.get(key)
        if kept is not None:
            return Measured(json.loads(kept), version_of_solver(work.engine), ranks=1)
        outcome = solved(work.case, parameters, work.engine)
        if isinstance(outcome, Measured) and self.entries is not None:
            self.entries.put(key, json.dumps(dict(outcome.values)).encode())
        return outcome

    def _key(self, work: Work, parameters: Parameters) -> str:
        return key_of(
            {
                "case": work.case.name,
                "quantities": [quantity.name for quantity in work.case.quantities],
                "solver": work.engine,
                "parameters": parameters.model_dump(mode="json"),
                "machine": machine(),
                "packages": versions("numba", "numpy", "scipy"),
                "source": [source_digest(), _beyond(work.case)],
            }
        )


def solved(case: Case[Any], parameters: Parameters, solver: str) -> Ran:
    """Return what a solver of a case finds, or the error that it raises."""
    try:
        result = case.solve(parameters, solver)
    except HarnessError as error:
        return error
    return Measured(result.values, version_of_solver(solver), result.seconds, 1)


def version_of_solver(solver: str) -> Provenance:
    """Return who a solver of this package is."""
    return Provenance(solver, f"dem-harness {__version__}", how="solver")


def jobs_of(
    work: Work, engine: Engine, places: Sequence[int]
) -> tuple[list[tuple[Job, list[int]]], dict[int, Ran]]:
    """Return the jobs that an engine can run, each once with its places, and why not the others.

    Each has the time that it is expected to need.
    """
    jobs: dict[tuple[Any, ...], tuple[Job, list[int]]] = {}
    refused: dict[int, Ran] = {}
    for place in places:
        try:
            job = work.case.timed_job(work.parameters[place], engine.traits)
            reason = engine.refuses(job)
        except HarnessError as error:
            refused[place] = error
            continue
        if reason:
            refused[place] = RequestError(reason)
        else:
            same = (job.variant, job.sampled, job.scene, *sorted(job.values.items()))
            jobs.setdefault(same, (job, []))[1].append(place)
    return list(jobs.values()), refused


def read(work: Work, engine: Engine, place: int, output: Output | EngineError) -> Ran:
    """Return the quantities of an output, or the error that it is or raises."""
    if isinstance(output, EngineError):
        return output
    try:
        return work.case.measured(work.parameters[place], output, engine.traits)
    except HarnessError as error:
        return error
    except Exception as error:  # a case that cannot read one output must not cost the others
        return EngineOutputError(f"{type(error).__name__}: {error}")


def measured(case: Case[Any], parameters: Parameters, engine: Engine) -> Ran:
    """Return what several runs in an engine lead to, or why they do not."""
    try:
        reason = engine.refuses(case.job(parameters))
        return RequestError(reason) if reason else case.measure(parameters, engine)
    except HarnessError as error:
        return error
    except Exception as error:  # one value must not cost the others
        return EngineOutputError(f"{type(error).__name__}: {error}")


def _in_engine(work: Work, engine: Engine, some: range) -> Iterator[tuple[int, Ran]]:
    jobs, refused = jobs_of(work, engine, some[: len(work.parameters) - some.start])
    yield from refused.items()
    for index, output in engine.outcomes([job for job, _ in jobs]) if jobs else ():
        for place in jobs[index][1]:
            yield place, read(work, engine, place, output)


def _beyond(case: Case[Any]) -> str:
    folder = Path(inspect.getfile(type(case))).resolve().parent
    return "" if folder.is_relative_to(ROOT) else digest_of_tree(folder)


DONE, FAILED, NOT_TESTED = "done", "failed", "not tested"
UNDECIDED, REFUSED, PENDING = "undecided", "refused", "pending"
"""A run that ended without the event it waits for; values that a case refuses together; a run that
has not ended, in the table of a sweep that has not either."""

STATUSES = (DONE, UNDECIDED, FAILED, NOT_TESTED, REFUSED, PENDING)

Row = Mapping[str, Any]


@dataclass(frozen=True, repr=False)
class Sweep(Result):
    """The rows of a sweep, flat: engine, parameters and quantities with units in their names.

    ``over`` are the columns that were swept, ``quantities`` those that were measured; one of a
    quantity with the name of a parameter is ``measured_NAME``. ``quantity`` are the names of the
    quantities that were asked for; ``missing`` says why an engine of ``all`` could not be opened.
    """

    case: str
    rows: tuple[Row, ...]
    over: tuple[str, ...]
    quantities: tuple[str, ...]
    quantity: str = ""
    missing: Mapping[str, str] = field(default_factory=dict)
    plan: SweepPlan | None = field(default=None, compare=False)

    @property
    def selected(self) -> tuple[str, ...]:
        """Return the columns of the quantities that were asked for; all unless some were."""
        return tuple(map(self._column, names_in(self.quantity))) or self.quantities

    def count(self, status: str) -> int:
        """Return how many rows have a status, one of :data:`STATUSES`."""
        return sum(row["status"] == status for row in self.rows)

    def to_json(self) -> dict[str, Any]:
        """Return it as a JSON-ready mapping."""
        return {
            "case": self.case,
            "over": list(self.over),
            **{
                status.replace(" ", "_"): self.count(status)
                for status in STATUSES
                if status != PENDING
            },
            "missing_engines": dict(self.missing),
            "rows": [dict(row) for row in self.rows],
        }

    def to_frame(self) -> pd.DataFrame:
        """Return the rows as a table; what a run does not have is NaN."""
        return as_frame(self.rows)

    def summary(self) -> dict[str, str]:
        """Return how many runs there are, over what, and in which engines."""
        counts = ((self.count(status), status) for status in STATUSES)
        return {
            "runs": ", ".join(f"{number} {status}" for number, status in counts if number),
            "case": f"{self.case} over {', '.join(self.over)}",
            "engines": ", ".join(dict.fromkeys(row["engine"] for row in self.rows)),
        }

    def draw(self) -> Figure:
        """Draw the quantity that was asked for, or the first; RequestError where none is there."""
        figure = self.figure()
        if figure is None:
            raise RequestError(f"plot: no run of this sweep of {self.case} measured anything")
        return figure

    def figure(self, quantity: str = "", points: Points | None = None) -> Figure | None:
        """Return a quantity over the first two columns of ``over``; None where none was measured.

        Of rows that are equal in these the first is shown. Without a name, the one that was asked
        for or the first that was measured. What it is expected to be is a line, ``points`` are
        drawn beside it.
        """
        from harness.report.figures import sweep_figure
        from harness.workflows.sweep_plan import reference_lines

        frame = self.to_frame()
        frame = frame.drop_duplicates(["engine", *self.over[:2]])
        frame = frame.loc[frame["status"] == DONE, ["engine", *self.over, *self.quantities]]
        wanted = [self._column(quantity)] if quantity else self.selected
        measured = [n for n in wanted if n in frame and frame[n].notna().any()]
        if not measured:
            return None
        lines = () if self.plan is None else reference_lines(self.plan, measured[0], self.over)
        titles = {name: engine_title(name) for name in frame["engine"].unique()}
        frame = frame.replace({"engine": titles})
        return sweep_figure(frame, measured[0], self.over, self.case, lines, points)

    def own_figures(self) -> Mapping[str, Callable[[], AnyFigure]]:
        """Return what draws the figures that the case has of such rows, by their names."""
        frame = self.to_frame()
        return get_case(self.case).display.figures(frame[frame["status"] == DONE])

    def _column(self, quantity: str) -> str:
        columns = {} if self.plan is None else quantity_columns(self.plan.case)
        return columns.get(quantity, quantity)

    def _repr_html_(self) -> str:
        html: str = self.to_frame().to_html(max_rows=20, index=False, na_rep="")
        return html


def as_frame(rows: Sequence[Row]) -> pd.DataFrame:
    """Return flat rows as a table; what a row does not have is NaN."""
    import pandas as pd

    frame = pd.DataFrame([{k: math.nan if v is None else v for k, v in r.items()} for r in rows])
    if "ranks" in frame and frame["ranks"].isna().any():  # whole numbers also where a run has none
        frame = frame.astype({"ranks": "Int64"})
    return frame


def sweep(
    case: str,
    over: Mapping[str, Any],
    *,
    fixed: Mapping[str, Any] | None = None,
    engines: str | Sequence[str] = "",
    runner: Runner | None = None,
    quantities: str | Sequence[str] = "",
    quantity: str = "",
    progress: Progress = silent,
) -> Sweep:
    """Run a case at every combination of the values of its parameters, in each engine.

    ``over`` maps the names of parameters (of nested ones with a dot) to values: a sequence, or a
    text as the command line takes it; ``fixed`` are set in every run. ``engines`` are names of
    engines and solvers, or ``all``; the usual one unless given. ``quantities`` are names of those
    to measure and show, of a derived one such as ``critical_angle_deg`` several runs for a value;
    those of a run unless given; ``quantity`` is one of them. Runs are kept in the default place
    and not run twice, unless ``runner`` makes them.

    Raise RequestError, before anything runs, for a name or value that is not allowed, and
    EngineError for a named engine that is not here; a run that fails is a row.
    """
    texts = {name: as_text(values) for name, values in over.items()}
    values = {name: as_text(value) for name, value in (fixed or {}).items()}
    asked = as_text(quantities) or quantity
    request = SweepRequest(case, (texts,), values, as_text(engines), asked)
    return run_plan(plan(request), runner, progress)


Partial = Callable[[Callable[[], Sequence[Row]]], None]
"""Takes a function that returns the rows so far, whenever a run is over."""


def run_plan(
    chosen: SweepPlan,
    runner: Runner | None = None,
    progress: Progress = silent,
    partial: Partial | None = None,
) -> Sweep:
    """Run a sweep that was checked; ``partial`` is given the rows as runs are over."""
    runner = runner or Runner(entries=Entries(cache_place().path))
    parameters = [point.parameters for point in chosen.points]
    ran: dict[str, dict[int, Ran]] = {engine: {} for engine in chosen.engines}
    missing: dict[str, str] = {}

    def rows() -> list[Row]:
        return [
            row for engine, outcomes in ran.items() if engine not in missing
            for row in _rows(chosen, engine, outcomes)
        ]  # fmt: skip

    for engine in chosen.engines:
        of_engine = ran[engine]
        progress(engine, 0, len(parameters))
        try:
            for place, outcome in runner.outcomes(Work(chosen.case, engine, parameters)):
                of_engine[place] = outcome
                progress(engine, len(of_engine), len(parameters))
                if partial is not None:
                    partial(rows)
        except EngineMissingError as error:
            if ALL not in chosen.request.engines.split(","):
                raise
            missing[engine] = str(error)
        except EngineError as error:  # the engine died as a whole
            ran[engine] = {place: of_engine.get(place, error) for place in range(len(parameters))}
    over = swept_columns(chosen.points[0], chosen.request.over)
    quantities = tuple(quantity_columns(chosen.case).values())
    return Sweep(
        chosen.case.name, tuple(rows()), over, quantities, chosen.request.quantity, missing, chosen
    )


def _rows(chosen: SweepPlan, engine: str, ran: Mapping[int, Ran]) -> list[Row]:
    rows = [_row(chosen, engine, point, ran.get(i)) for i, point in enumerate(chosen.points)]
    for place, refused in sorted(chosen.refused.items()):
        rows.insert(place, _refused_row(chosen, engine, refused))
    return rows


def _row(chosen: SweepPlan, engine: str, point: SweepPoint, ran: Ran | None) -> Row:
    ended = ran if isinstance(ran, Measured | EngineUndecidedError) else None
    values: Mapping[str, float] = ended.values if ended else {}
    provenance = ended.provenance if ended else None
    preset = {PRESET: point.swept[PRESET]} if PRESET in point.swept else {}
    return {
        "engine": engine,
        "engine_version": provenance.engine_version if provenance else "",
        "ranks": ended.ranks if ended else None,
        **preset,
        **parameter_columns(point.parameters, chosen.case.varied),
        **{column: values.get(name) for name, column in quantity_columns(chosen.case).items()},
        "status": _status(ran),
        "reason": " ".join(str(ran).split()) if isinstance(ran, HarnessError) else "",
        "wall_time_s": ended.seconds if ended else None,
    }


def _status(ran: Ran | None) -> str:
    if ran is None:
        return PENDING
    if isinstance(ran, Measured):
        return DONE
    if isinstance(ran, EngineUndecidedError):
        return UNDECIDED
    return NOT_TESTED if isinstance(ran, RequestError) else FAILED


def _refused_row(chosen: SweepPlan, engine: str, refused: RefusedPoint) -> Row:
    same = [
        point
        for point in chosen.points
        if point.swept.get(PRESET) == refused.swept.get(PRESET)
        and point.swept.keys() <= refused.settings.keys()
    ]
    example = (same or chosen.points)[0]
    row = dict(_row(chosen, engine, example, None))
    units = {name: info.unit for name, info in parameters_in(example.parameters)}
    for name, text in refused.settings.items():
        for column in [c for c in row if c.startswith(f"{name}.")]:
            row[column] = None
        parameter = f"{name}.name" if f"{name}.name" in units else name
        row[column_of(parameter, units.get(parameter, ""))] = _plain_value(text)
    if not same:  # of another preset or grid
        columns = {column_of(name, units.get(name, "")) for name in refused.settings}
        row |= {column_of(n, u): None for n, u in units.items() if column_of(n, u) not in columns}
    return {**row, "status": REFUSED, "reason": " ".join(refused.reason.split())}


def _plain_value(text: str) -> float | int | str:
    for kind in (int, float):
        with contextlib.suppress(ValueError):
            return kind(text)
    return text
