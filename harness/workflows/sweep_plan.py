"""The runs of a sweep: every combination of the values of its parameters, in each engine.

Values are text: lists such as ``1,2,5`` and ranges such as ``9:11:5`` and ``1e5:1e7:log5``.
"""

from __future__ import annotations

import itertools
import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from harness.cases.base import Case
from harness.cases.registry import get_case
from harness.engines.registry import engine_class
from harness.errors import CombinationError, RequestError
from harness.model.base import Parameters
from harness.workflows.runs import is_solver, run_seconds, takes_job, usual_runner
from harness.workflows.selection import selected_engines, words_in
from harness.workflows.settings import (
    PRESET,
    as_text,
    flat,
    parameters_of,
    quantity_names,
    split_settings,
)

MOST_VALUES = 100_000  # of one parameter, and runs of one sweep: each is a row in memory
LARGEST_FILE = 1_000_000  # bytes of a sweep file
DIGITS = 15  # of the numbers of a range: 0.3, not 0.30000000000000004
GRAMMAR = "values as 1,2,5, or ranges as 9:11:5 (evenly spaced) and 1e5:1e7:log5 (in the logarithm)"
KEYS = ("case", "engines", "quantity", "set", "over")
ROW = ("engine", "engine_version", PRESET, "status", "reason", "wall_time_s")  # of every row
Grid = Mapping[str, str]  # values of parameters as text: all their combinations are run


@dataclass(frozen=True)
class SweepRequest:
    """A sweep as text. ``grids`` run one after the other, a point that two share once."""

    case: str
    grids: tuple[Grid, ...]
    fixed: Mapping[str, str]
    engines: str = ""
    quantity: str = ""

    @property
    def over(self) -> tuple[str, ...]:
        """Return the names of the swept parameters."""
        return tuple(dict.fromkeys(name for grid in self.grids for name in grid))

    def with_options(
        self, over: Grid, fixed: Mapping[str, str], engines: str, quantity: str
    ) -> SweepRequest:
        """Return the sweep with options of the command line, which win over a file."""
        grids = self.grids if self.grids or not over else ({},)
        return SweepRequest(
            self.case,
            tuple({**grid, **over} for grid in grids),
            {**self.fixed, **fixed},
            engines or self.engines,
            quantity or self.quantity,
        )


@dataclass(frozen=True)
class Point:
    """A combination: values that were swept, as text, and all parameters; or why it is refused.

    ``options`` are those of a search.
    """

    swept: Mapping[str, str]
    parameters: Parameters | None
    options: Mapping[str, Any] = field(default_factory=dict)
    refused: str = ""


@dataclass(frozen=True)
class SweepPlan:
    """All that a sweep runs, checked: its points, each in every engine or solver."""

    request: SweepRequest
    case: Case[Any]
    engines: tuple[str, ...]
    quantities: tuple[str, ...]
    points: tuple[Point, ...]

    def solves(self, engine: str) -> bool:
        """Return whether a name is that of a solver of the case."""
        return is_solver(self.case, engine)

    def seconds(self) -> float:
        """Return the expected time of all runs on one core [s], kept ones among them."""
        total = 0.0
        for engine in self.engines:
            traits = None if self.solves(engine) else engine_class(engine).traits
            for point in self.points:
                if point.parameters is not None:
                    total += run_seconds(self.case, point.parameters, traits, self.quantities)
        return total

    def columns(self) -> dict[str, str]:
        """Return the column of each quantity: its name, or ``measured_NAME`` where that is taken.

        Requested and measured values never share a column.
        """
        taken = {*ROW, *self.case.parameters.model_fields}
        return {n: f"measured_{n}" if n in taken else n for n in self.measured}

    @property
    def measured(self) -> tuple[str, ...]:
        """Return the measured quantities: the requested ones, and all of the same search."""
        requested = [self.case.quantity(name) for name in self.quantities]
        varies = requested[0].varies if requested else ()
        others = () if requested and not varies else self.case.quantities
        alike = [quantity.name for quantity in others if quantity.varies == varies]
        return tuple(dict.fromkeys([*self.quantities, *alike]))

    def uncertainty_column(self, name: str) -> str:
        """Return the column of a quantity's uncertainty: a quantity of the case, or its own."""
        shared = f"uncertainty_{self.case.quantity(name).unit}"
        return shared if shared in self.measured else f"uncertainty_{name}"


def values_of(name: str, text: str) -> list[str]:
    """Return the values of a text, each once and in order. Raise RequestError for bad grammar."""
    values: dict[str, None] = {}
    for item in text.split(","):
        values |= dict.fromkeys(_range(name, item) if ":" in item else [item.strip()])
        if "" in values:
            raise RequestError(f"--over {name}={text}: a value is empty; must be {GRAMMAR}")
    return list(values)


def request_in(file: Path) -> SweepRequest:
    """Return the sweep of a TOML file; raise RequestError, naming it, for one that is not sound.

    ``case`` is a name; ``engines`` and ``quantity`` are optional; ``[set]`` and ``[over]`` are
    tables of parameters. Several tables ``[[over]]`` run one after the other.
    """
    try:
        with file.open("rb") as stream:
            data = stream.read(LARGEST_FILE + 1)
        if len(data) > LARGEST_FILE:
            raise RequestError(f"{file}: is longer than {LARGEST_FILE} bytes")
        return _request(file, tomllib.loads(data.decode("utf-8")))
    except OSError as error:
        raise RequestError(f"{file}: {error.strerror or error}") from None
    except RecursionError:
        raise RequestError(f"{file}: is nested too deep; must be lists of values") from None
    except RequestError:
        raise
    except ValueError as error:  # of tomllib, of decoding, of a number with too many digits
        raise RequestError(f"{file}: is not TOML ({str(error)[:200]})") from None


def plan(request: SweepRequest) -> SweepPlan:
    """Return the runs of a sweep; nothing is run.

    Values that are not allowed together are a refused point. Raise RequestError for a name or a
    value that is not allowed by itself, and where every point is refused.
    """
    case = get_case(request.case)
    names = tuple(quantity_names(case, request.quantity))
    if not request.over or not all(request.grids):
        raise RequestError("--over: must be given, a parameter with its values: NAME=VALUES")
    for name in request.over:
        if name in request.fixed:
            value = request.fixed[name]
            raise RequestError(f"--over {name}: is set by --set {name}={value} already")
    grids = [{name: values_of(name, text) for name, text in grid.items()} for grid in request.grids]
    engines = _engines(case, request.engines)
    runs = sum(math.prod(map(len, grid.values())) for grid in grids) * len(engines)
    if runs > MOST_VALUES:
        raise RequestError(f"--over: {runs} runs are requested: must be at most {MOST_VALUES}")
    points = _points(case, request.fixed, grids, names)
    if all(point.refused for point in points):
        every = f" (so are all {len(points)} points)" if len(points) > 1 else ""
        raise RequestError(f"--over {_swept(points[0].swept)}: {points[0].refused}{every}")
    return SweepPlan(request, case, engines, names, tuple(points))


def _range(name: str, item: str) -> list[str]:
    option = f"--over {name}={item}"
    *ends, last = (part.strip() for part in item.split(":"))
    count = re.fullmatch(r"(log)?(\d{1,9})", last, re.ASCII)
    try:
        first, end = map(float, ends)
    except ValueError:
        raise RequestError(f"{option}: must be {GRAMMAR}") from None
    if count is None or not (math.isfinite(first) and math.isfinite(end)):
        raise RequestError(f"{option}: must be {GRAMMAR}")
    if not 2 <= int(count[2]) <= MOST_VALUES:
        raise RequestError(f"{option}: a range has from 2 to {MOST_VALUES} values")
    if count[1] and not (first > 0.0 and end > 0.0):
        raise RequestError(f"{option}: the ends of a range in the logarithm must be greater than 0")
    numbers = (np.geomspace if count[1] else np.linspace)(first, end, int(count[2]))
    return [f"{number:.{DIGITS}g}" for number in numbers]


def _request(file: Path, contents: Mapping[str, Any]) -> SweepRequest:
    for key, value in contents.items():
        if key not in KEYS:
            raise RequestError(f"{file}: {key!r} is not known: must be one of {', '.join(KEYS)}")
        is_table = key in ("set", "over")
        tables = value if key == "over" and isinstance(value, list) else [value]
        if not all(isinstance(one, Mapping) == is_table for one in tables):
            form = f"a table [{key}]" if is_table else "a text or a list of texts"
            raise RequestError(f"{file}: {key}: must be {form}")
    if not isinstance(contents.get("case"), str):
        raise RequestError(f"{file}: case: must be given, the name of a case")
    over = contents.get("over", [])
    grids = over if isinstance(over, list) else [over]
    return SweepRequest(
        contents["case"],
        tuple(flat(grid) for grid in grids),
        flat(contents.get("set", {})),
        as_text(contents.get("engines", "")),
        as_text(contents.get("quantity", "")),
    )


def _points(
    case: Case[Any],
    fixed: Mapping[str, str],
    grids: Iterable[Mapping[str, Sequence[str]]],
    names: Sequence[str],
) -> list[Point]:
    """Return the combinations of all grids; one with the parameters of an earlier grid once."""
    points: list[Point] = []
    earlier: set[tuple[str, str]] = set()
    for grid in grids:
        planned = set()
        for combination in itertools.product(*grid.values()):
            swept = dict(zip(grid, combination, strict=True))
            point = _point(case, fixed, swept, names)
            if point.parameters is not None:
                options = repr(sorted(point.options.items()))
                key = swept.get(PRESET, ""), point.parameters.model_dump_json() + options
                if key in earlier:
                    continue
                planned.add(key)
            points.append(point)
        earlier |= planned
    return points


def _point(
    case: Case[Any], fixed: Mapping[str, str], swept: Mapping[str, str], names: Sequence[str]
) -> Point:
    try:
        texts, options = split_settings(case, {**fixed, **swept}, names)
        return Point(swept, parameters_of(case, texts), options)
    except CombinationError as error:
        return Point(swept, None, refused=str(error).removeprefix("--set "))
    except RequestError as error:
        text = str(error).removeprefix("--set ")
        if any(text.startswith(f"{name} =") for name in fixed):  # not of what is swept
            raise
        raise RequestError(f"--over {_swept(swept)}: {text}") from None


def _swept(swept: Mapping[str, str]) -> str:
    return ", ".join(f"{name}={value}" for name, value in swept.items())


def _engines(case: Case[Any], text: str) -> tuple[str, ...]:
    """Return engines and solvers; ``all`` are those that can run the case."""
    if not text:
        return (usual_runner(case),)
    named = words_in(text)
    return tuple(
        name
        for name in selected_engines(text, case.solvers)
        if name in named or name in case.solvers or takes_job(engine_class(name), case)
    )
