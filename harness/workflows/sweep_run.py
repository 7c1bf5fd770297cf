"""Sweep a case over its parameters and over engines: one tidy row a run."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from harness.cases.contract import Measured
from harness.errors import (
    EngineError,
    EngineMissingError,
    EngineUndecidedError,
    HarnessError,
    RequestError,
)
from harness.home import cache_place
from harness.observables.declared import Observable
from harness.parameters.base import Parameters
from harness.shown import Shown
from harness.store.entries import Entries
from harness.workflows.case_list import parameters_in
from harness.workflows.case_settings import PRESET
from harness.workflows.progress import Progress, silent
from harness.workflows.sweep_local import CheckedExecutor, Executor, Local, Ran, Work
from harness.workflows.sweep_plan import ALL, Asked, Plan, Point, RefusedPoint, plan
from harness.workflows.sweep_values import as_text

if TYPE_CHECKING:
    import pandas as pd

    from harness.observables.reference import Points
    from harness.shown.figure import Figure

DONE, FAILED, NOT_TESTED = "done", "failed", "not tested"
UNDECIDED, REFUSED, PENDING = "undecided", "refused", "pending"
"""A run that ended without the event it waits for; values that a case refuses together; a run that
has not ended, in the table of a sweep that has not either."""

STATUSES = (DONE, UNDECIDED, FAILED, NOT_TESTED, REFUSED, PENDING)

Row = Mapping[str, Any]


@dataclass(frozen=True, repr=False)
class Sweep(Shown):
    """The rows of a sweep, flat: engine, parameters and quantities with units in their names.

    ``over`` are the columns that were swept, ``quantities`` those that were measured; ``missing``
    says why an engine of ``all`` could not be opened.
    """

    case: str
    rows: tuple[Row, ...]
    over: tuple[str, ...]
    quantities: tuple[str, ...]
    quantity: str = ""
    missing: Mapping[str, str] = field(default_factory=dict)

    def count(self, status: str) -> int:
        """Return how many rows have a status, one of :data:`STATUSES`."""
        return sum(row["status"] == status for row in self.rows)

    def record(self) -> dict[str, Any]:
        """Return it as a JSON-ready mapping."""
        return {
            "case": self.case,
            "over": list(self.over),
            **{one.replace(" ", "_"): self.count(one) for one in STATUSES if one != PENDING},
            "missing_engines": dict(self.missing),
            "rows": [dict(row) for row in self.rows],
        }

    def frame(self) -> pd.DataFrame:
        """Return the rows as a table; what a run does not have is NaN."""
        return as_frame(self.rows)

    def told(self) -> dict[str, str]:
        """Return how many runs there are, over what, and in which engines."""
        counts = ((self.count(status), status) for status in STATUSES)
        return {
            "runs": ", ".join(f"{number} {status}" for number, status in counts if number),
            "case": f"{self.case} over {', '.join(self.over)}",
            "engines": ", ".join(dict.fromkeys(row["engine"] for row in self.rows)),
        }

    def drawn(self) -> Figure:
        """Draw the quantity that was asked for, or the first; RequestError where none is there."""
        figure = self.figure()
        if figure is None:
            raise RequestError(f"plot: no run of this sweep of {self.case} measured anything")
        return figure

    def figure(self, quantity: str = "", points: Points | None = None) -> Figure | None:
        """Return a quantity over the first two columns of ``over``; None where none was measured.

        Of further ones the first value is shown. Without a name, the one that was asked for or
        the first that was measured. ``points`` are drawn beside it.
        """
        from harness.report.figures.sweep import sweep_figure

        frame = self.frame()
        rest = {name: frame[name].iloc[0] for name in self.over[2:]}
        for name, value in rest.items():
            frame = frame[frame[name] == value]
        frame = frame[frame["status"] == DONE]
        named = quantity or self.quantity
        measured = [n for n in self.quantities if n in frame and frame[n].notna().any()]
        if named:
            measured = [name for name in measured if name in (named, self._column(named))]
        if not measured:
            return None
        shown = ", ".join([self.case, *(f"{name} = {value}" for name, value in rest.items())])
        return sweep_figure(frame, measured[0], list(self.over[:2]), shown, points)

    def _column(self, quantity: str) -> str:
        return next((name for name in self.quantities if name.startswith(f"{quantity}_")), quantity)

    def _repr_html_(self) -> str:
        """Return the table for a notebook, shortened in the middle."""
        html: str = self.frame().to_html(max_rows=20, index=False, na_rep="")
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
    executor: Executor | None = None,
    quantity: str = "",
    progress: Progress = silent,
) -> Sweep:
    """Run a case at every combination of the values of its parameters, in each engine.

    ``over`` maps the names of parameters (of nested ones with a dot) to values: a sequence, or a
    text as the command line takes it; ``fixed`` are set in every run. ``engines`` are names of
    engines and solvers, or ``all``; the usual one unless given. Runs are kept in the default
    place and not run twice; ``executor`` runs them elsewhere.

    Raise RequestError, before anything runs, for a name or value that is not allowed, and
    EngineError for a named engine that is not here; a run that fails is a row.
    """
    texts = {name: as_text(values) for name, values in over.items()}
    values = {name: as_text(value) for name, value in (fixed or {}).items()}
    asked = Asked(case, texts, values, as_text(engines), quantity)
    return run_plan(plan(asked), executor, progress)


Partial = Callable[[Callable[[], Sequence[Row]]], None]
"""Takes a function that returns the rows so far, whenever a run is over."""


def run_plan(
    chosen: Plan,
    executor: Executor | None = None,
    progress: Progress = silent,
    partial: Partial | None = None,
) -> Sweep:
    """Run a sweep that was checked; ``partial`` is given the rows as runs are over."""
    run = executor or Local(entries=Entries(cache_place().path))
    parameters = [point.parameters for point in chosen.points]
    ran: dict[str, dict[int, Ran]] = {engine: {} for engine in chosen.engines}
    missing: dict[str, str] = {}

    def rows() -> list[Row]:
        return [
            row for engine, outcomes in ran.items() if engine not in missing
            for row in _rows(chosen, engine, outcomes)
        ]  # fmt: skip

    works = [Work(chosen.case, engine, parameters) for engine in chosen.engines]
    if isinstance(run, CheckedExecutor):
        for work in works:
            run.check(work)
    # a cluster is given all of it before any is waited for
    streams = [_stream(run, work) for work in works]
    for engine, stream in zip(chosen.engines, streams, strict=True):
        own = ran[engine]
        progress(engine, 0, len(parameters))
        try:
            for place, outcome in stream:
                own[place] = outcome
                progress(engine, len(own), len(parameters))
                if partial is not None:
                    partial(rows)
        except EngineMissingError as error:
            if ALL not in chosen.asked.engines.split(","):
                raise
            missing[engine] = str(error)
        except EngineError as error:  # the engine died as a whole
            ran[engine] = {place: own.get(place, error) for place in range(len(parameters))}
    over = _columns(chosen.points[0], chosen.asked.over)
    quantities = tuple(quantity_key(quantity) for quantity in chosen.case.quantities)
    return Sweep(chosen.case.name, tuple(rows()), over, quantities, chosen.asked.quantity, missing)


def _rows(chosen: Plan, engine: str, ran: Mapping[int, Ran]) -> list[Row]:
    """Return a row for each point, in the order in which they were asked for."""
    rows = [_row(chosen, engine, one, ran.get(i)) for i, one in enumerate(chosen.points)]
    for place, refused in sorted(chosen.refused.items()):
        rows.insert(place, _refused_row(chosen, engine, refused))
    return rows


def _stream(run: Executor, work: Work) -> Iterator[tuple[int, Ran]]:
    """Return the outcomes of work; an engine that cannot be opened is told in its turn."""
    try:
        return run(work)
    except EngineError as error:
        return _raising(error)


def _raising(error: EngineError) -> Iterator[tuple[int, Ran]]:
    raise error
    yield


def _row(chosen: Plan, engine: str, point: Point, ran: Ran | None) -> Row:
    ended = ran if isinstance(ran, Measured | EngineUndecidedError) else None
    found: Mapping[str, float] = ended.values if ended else {}
    who = ended.provenance if ended else None
    preset = {PRESET: point.swept[PRESET]} if PRESET in point.swept else {}
    return {
        "engine": engine,
        "engine_version": who.engine_version if who else "",
        "ranks": ended.ranks if ended else None,
        **preset,
        **parameter_columns(point.parameters),
        **{quantity_key(q): found.get(q.name) for q in chosen.case.quantities},
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


def _refused_row(chosen: Plan, engine: str, refused: RefusedPoint) -> Row:
    """Return the row of values that are not allowed together: those that are known, and why."""
    same = [p for p in chosen.points if p.swept.get(PRESET) == refused.swept.get(PRESET)]
    example = (same or chosen.points)[0]
    row = dict(_row(chosen, engine, example, None))
    units = {name: info.unit for name, info in parameters_in(example.parameters)}
    for name, text in refused.settings.items():
        for column in [c for c in row if c.startswith(f"{name}.")]:
            row[column] = None
        parameter = f"{name}.name" if f"{name}.name" in units else name
        row[key_of(parameter, units.get(parameter, ""))] = _plain_value(text)
    if not same:  # of another preset
        known = {key_of(name, units.get(name, "")) for name in refused.settings}
        row |= {key_of(n, u): None for n, u in units.items() if key_of(n, u) not in known}
    return {**row, "status": REFUSED, "reason": " ".join(refused.reason.split())}


def _plain_value(text: str) -> float | int | str:
    for kind in (int, float):
        with contextlib.suppress(ValueError):
            return kind(text)
    return text


def parameter_columns(parameters: Parameters) -> dict[str, Any]:
    """Return every parameter under its name with its unit; lists of numbers as JSON text."""
    found: dict[str, Any] = {}
    for name, info in parameters_in(parameters):
        value = info.default
        plain = isinstance(value, (bool, int, float, str)) or value is None
        found[key_of(name, info.unit)] = value if plain else json.dumps(value)
    return found


def _columns(point: Point, names: Mapping[str, str]) -> tuple[str, ...]:
    """Return the columns of swept parameters; a nested one that is swept whole by its name."""
    units = {name: info.unit for name, info in parameters_in(point.parameters)}
    found: list[str] = []
    for name in names:
        if name in units or name == PRESET:
            found.append(key_of(name, units.get(name, "")))
        else:  # an object by its name
            found += [key_of(n, u) for n, u in units.items() if n == f"{name}.name"] or [name]
    return tuple(found)


def drawn_columns(chosen: Plan) -> tuple[str, str]:
    """Return the columns of a sweep's figure: the first that is swept, and what is asked for."""
    over = _columns(chosen.points[0], chosen.asked.over)
    units = {quantity.name: quantity.unit for quantity in chosen.case.quantities}
    return over[0], key_of(chosen.asked.quantity, units[chosen.asked.quantity])


def quantity_key(quantity: Observable) -> str:
    """Return the column of a quantity, its name with its unit."""
    return key_of(quantity.name, quantity.unit)


def key_of(name: str, unit: str) -> str:
    """Return a name with its unit, as ``stiffness_N_per_m``; one that ends in it stays."""
    spelled = unit.replace("/", "_per_").replace(" ", "").replace("^", "")
    if spelled in ("", "1", "-") or name.endswith(f"_{spelled}"):
        return name
    return f"{name}_{spelled}"
