"""What a sweep runs: every combination of the values of its parameters, in each engine.

Values are typed as text: lists such as ``1,2,5`` and ranges such as ``1e5:1e7:log5``. A figure of
a sweep has lines of what its quantity is expected to be.
"""

from __future__ import annotations

import itertools
import json
import math
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.cases.contract import Case, Reference
from harness.cases.registry import get_case
from harness.engines.registry import engine_class, engine_names, engine_title
from harness.engines.traits import Traits
from harness.errors import CombinationError, HarnessError, RequestError
from harness.parameters.allowed import unit_in
from harness.parameters.base import Parameters
from harness.store.baseline import bounded_text
from harness.workflows.case_runs import (
    NO_RULES,
    PRESET,
    is_solver,
    parameters_in,
    parameters_of,
    usual_engine,
)

if TYPE_CHECKING:
    from harness.report.figures import ReferenceLine

MOST_VALUES = 100_000
"""Of one parameter, and runs of one sweep: each is a row that is held in memory."""

GRAMMAR = "values as 1,2,5, or ranges as 9:11:5 (evenly spaced) and 1e5:1e7:log5 (in the logarithm)"

DIGITS = 15
"""Of the numbers of a range: 0.3, not 0.30000000000000004."""


def values_of(name: str, text: str) -> list[str]:
    """Return the values of a text, as ``--set`` takes them, each once and in the order given.

    Items stand between commas. An item with colons is a range ``FIRST:LAST:COUNT`` of so many
    numbers, evenly spaced with both ends, or ``FIRST:LAST:logCOUNT``, evenly spaced in the
    logarithm. Raise RequestError for what is neither.
    """
    values: dict[str, None] = {}
    for item in text.split(","):
        values |= dict.fromkeys(_range(name, item) if ":" in item else [item.strip()])
        if "" in values:
            raise RequestError(f"--over {name}={text}: a value is empty; must be {GRAMMAR}")
    return list(values)


def as_text(values: Any) -> str:
    """Return values of a TOML file or of Python as the text of the command line."""
    if isinstance(values, str):
        return values
    many = values if isinstance(values, Iterable) else [values]
    return ",".join(str(value) for value in many)


def flat(tree: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested tables with dots in their names, as ``--set`` takes them."""
    columns: dict[str, Any] = {}
    for name, value in tree.items():
        inner = isinstance(value, Mapping)
        columns |= flat(value, f"{prefix}{name}.") if inner else {prefix + name: value}
    return columns


def _range(name: str, item: str) -> list[str]:
    parts = [part.strip() for part in item.split(":")]
    option = f"--over {name}={item}"
    count = re.fullmatch(r"(log)?(\d{1,9})", parts[-1], re.ASCII)
    try:
        first, last = (float(part) for part in parts[:-1])
    except ValueError:
        raise RequestError(f"{option}: must be {GRAMMAR}") from None
    if count is None or not (math.isfinite(first) and math.isfinite(last)):
        raise RequestError(f"{option}: must be {GRAMMAR}")
    if not 2 <= int(count[2]) <= MOST_VALUES:
        raise RequestError(f"{option}: a range has from 2 to {MOST_VALUES} values")
    if count[1] and not (first > 0.0 and last > 0.0):
        raise RequestError(f"{option}: the ends of a range in the logarithm must be greater than 0")
    numbers = (np.geomspace if count[1] else np.linspace)(first, last, int(count[2]))
    return [f"{number:.{DIGITS}g}" for number in numbers]


ALL = "all"
LARGEST_FILE = 1_000_000
"""Bytes of a sweep file."""

KEYS = ("case", "engines", "quantity", "set", "over")


Grid = Mapping[str, str]
"""Values of parameters as text: all their combinations are run."""


@dataclass(frozen=True)
class SweepRequest:
    """A sweep as it is requested, with texts as on the command line.

    ``grids`` are run one after the other, a combination that two of them share once. ``quantity``
    names the quantities to measure and show; the first is drawn.
    """

    case: str
    grids: tuple[Grid, ...]
    fixed: Mapping[str, str]
    engines: str = ""
    quantity: str = ""

    @property
    def over(self) -> tuple[str, ...]:
        """Return the names of the swept parameters."""
        return tuple(dict.fromkeys(name for grid in self.grids for name in grid))


@dataclass(frozen=True)
class SweepPoint:
    """One combination: the values that were swept, as text, and all parameters."""

    swept: Mapping[str, str]
    parameters: Parameters


@dataclass(frozen=True)
class RefusedPoint:
    """A combination that the case refuses: what was swept and set, as text, and why."""

    swept: Mapping[str, str]
    settings: Mapping[str, str]
    reason: str


@dataclass(frozen=True)
class SweepPlan:
    """All that a sweep runs, checked: the points, each in every engine or solver.

    ``refused`` are combinations that are not run, by their places among all.
    """

    request: SweepRequest
    case: Case[Any]
    engines: tuple[str, ...]
    points: tuple[SweepPoint, ...]
    refused: Mapping[int, RefusedPoint] = field(default_factory=dict)

    def solves(self, engine: str) -> bool:
        """Return whether this is a solver of the case, of this package."""
        return is_solver(self.case, engine)

    @property
    def runs(self) -> int:
        """Return how many runs there are, without what is refused."""
        return len(self.points) * len(self.engines)

    def seconds(self) -> float:
        """Return what all runs are expected to take on one core [s], kept ones among them."""
        return sum(self.run_seconds(e, point) for e in self.engines for point in self.points)

    def run_seconds(self, engine: str, point: SweepPoint) -> float:
        """Return what a run is expected to take on one core [s], 0 where it is not run."""
        rules = None if self.solves(engine) else engine_class(engine).traits
        try:
            return self.case.seconds(point.parameters, rules, engine if rules is None else "")
        except RequestError:  # a row that says why it is not run
            return 0.0


def request_in(file: Path) -> SweepRequest:
    """Return the sweep of a TOML file; raise RequestError for one that is not sound.

    ``case`` is a name, ``engines`` and ``quantity`` may be left out, ``[set]`` and ``[over]`` are
    tables of parameters. Several tables ``[[over]]`` are run one after the other.
    """
    try:
        return _request(file, tomllib.loads(bounded_text(file, LARGEST_FILE)))
    except OSError as error:
        raise RequestError(f"{file}: {error.strerror or error}") from None
    except RecursionError:
        raise RequestError(f"{file}: is nested too deep; must be lists of values") from None
    except RequestError:
        raise
    except ValueError as error:  # of tomllib, of decoding, of a number with too many digits
        raise RequestError(f"{file}: is not TOML ({str(error)[:200]})") from None


def _request(file: Path, contents: Mapping[str, Any]) -> SweepRequest:
    for key, value in contents.items():
        if key not in KEYS:
            raise RequestError(f"{file}: {key!r} is not known: must be one of {', '.join(KEYS)}")
        table = key in ("set", "over")
        tables = value if key == "over" and isinstance(value, list) else [value]
        if not all(isinstance(one, Mapping) == table for one in tables):
            form = f"a table [{key}]" if table else "a text or a list of texts"
            raise RequestError(f"{file}: {key}: must be {form}")
    if not isinstance(contents.get("case"), str):
        raise RequestError(f"{file}: case: must be given, the name of a case")
    over = contents.get("over", [])
    return SweepRequest(
        contents["case"],
        tuple(_texts(grid) for grid in (over if isinstance(over, list) else [over])),
        _texts(contents.get("set", {})),
        as_text(contents.get("engines", "")),
        as_text(contents.get("quantity", "")),
    )


def _texts(table: Mapping[str, Any]) -> Grid:
    return {name: as_text(values) for name, values in flat(table).items()}


def plan(request: SweepRequest) -> SweepPlan:
    """Return the runs of a sweep; nothing is run.

    Values that are not allowed together are a point that is refused; raise RequestError for a name
    or a value that is not allowed by itself, and where every point is refused.
    """
    case = get_case(request.case).measuring(names_in(request.quantity))
    for name in ROW:
        if name in case.parameters.model_fields:
            raise RequestError(f"case {case.name!r}: parameter {name!r}: is a column of every row")
    if not all(request.grids) or not request.over:
        raise RequestError("--over: must be given, a parameter with its values: NAME=VALUES")
    for name in request.over:
        if name in request.fixed:
            raise RequestError(
                f"--over {name}: is set by --set {name}={request.fixed[name]} already"
            )
    grids = [{name: values_of(name, text) for name, text in grid.items()} for grid in request.grids]
    engines = _engines(case, request.engines)
    runs = sum(math.prod(map(len, grid.values())) for grid in grids) * len(engines)
    if runs > MOST_VALUES:
        raise RequestError(f"--over: {runs} runs are asked for: must be at most {MOST_VALUES}")
    points, refused = _points(case, request.fixed, grids)
    if not points:
        where = ", ".join(f"{name}={value}" for name, value in refused[0].swept.items())
        every = f" (so are all {len(refused)} points)" if len(refused) > 1 else ""
        raise RequestError(f"--over {where}: {refused[0].reason}{every}")
    return SweepPlan(request, case, engines, tuple(points), refused)


def _points(
    case: Case[Any], fixed: Mapping[str, str], grids: Iterable[Mapping[str, Sequence[str]]]
) -> tuple[list[SweepPoint], dict[int, RefusedPoint]]:
    """Return the combinations of all grids, and by their places those that the case refuses.

    A combination with the parameters of one in an earlier grid is left out.
    """
    points: list[SweepPoint] = []
    refused: dict[int, RefusedPoint] = {}
    earlier: set[tuple[str, str]] = set()
    for grid in grids:
        planned = set()
        for combination in itertools.product(*grid.values()):
            swept = dict(zip(grid, combination, strict=True))
            try:
                point = SweepPoint(swept, _parameters(case, fixed, swept))
            except CombinationError as error:
                place = len(points) + len(refused)
                refused[place] = RefusedPoint(swept, {**fixed, **swept}, str(error))
                continue
            key = swept.get(PRESET, ""), point.parameters.model_dump_json()
            if key not in earlier:
                points.append(point)
                planned.add(key)
        earlier |= planned
    return points, refused


def _parameters(case: Case[Any], fixed: Mapping[str, str], swept: Mapping[str, str]) -> Parameters:
    try:
        return parameters_of(case, {**fixed, **swept})
    except CombinationError as error:
        raise CombinationError(str(error).removeprefix("--set: ")) from None
    except RequestError as error:
        if str(error) == _fault(case, fixed):  # not of what is swept
            raise
        where = ", ".join(f"{name}={value}" for name, value in swept.items())
        raise RequestError(f"--over {where}: {str(error).removeprefix('--set: ')}") from None


def _fault(case: Case[Any], fixed: Mapping[str, str]) -> str:
    """Return what is wrong with settings by themselves; empty where nothing is."""
    try:
        parameters_of(case, fixed)
    except RequestError as error:
        return str(error)
    return ""


def _engines(case: Case[Any], text: str) -> tuple[str, ...]:
    """Return the engines and solvers of a text such as ``one,two``; the usual one for none."""
    names = names_in(text)
    if text and not names:
        raise RequestError(f"--engines {text!r}: names no engine")
    available = [*engine_names(), *case.solvers]
    for name in names:
        if ":" in name:
            engine_class(name)  # module:Class, which raises where there is none
        elif name not in (ALL, *available):
            must = f"{ALL}, or one or more of {', '.join(available)}"
            raise RequestError(f"--engines {name!r} is not known: must be {must}")
    if ALL in names:
        stating = [name for name in engine_names() if engine_class(name).states(case.template)]
        names = [*stating, *case.solvers, *(name for name in names if name != ALL)]
    return tuple(dict.fromkeys(names or [usual_engine(case)]))


def names_in(text: str) -> list[str]:
    """Return the names in a text such as ``one,two``."""
    return [name.strip() for name in text.split(",") if name.strip()]


def with_options(
    base: SweepRequest, over: Grid, fixed: Mapping[str, str], engines: str, quantity: str
) -> SweepRequest:
    """Return a sweep with the options of the command line, which win over the file."""
    grids = base.grids if base.grids or not over else ({},)
    return SweepRequest(
        base.case,
        tuple({**grid, **over} for grid in grids),
        {**base.fixed, **fixed},
        engines or base.engines,
        quantity or base.quantity,
    )


def parameter_columns(parameters: Parameters, without: Sequence[str] = ()) -> dict[str, Any]:
    """Return every parameter under its name with its unit; lists of numbers as JSON text.

    Those of the names ``without`` are left out.
    """
    columns: dict[str, Any] = {}
    for name, info in parameters_in(parameters):
        if name in without:
            continue
        value = info.default
        plain = isinstance(value, (bool, int, float, str)) or value is None
        columns[column_of(name, info.unit)] = value if plain else json.dumps(value)
    return columns


def swept_columns(point: SweepPoint, names: Iterable[str]) -> tuple[str, ...]:
    """Return the columns of swept parameters; a nested one that is swept whole by its name."""
    units = {name: info.unit for name, info in parameters_in(point.parameters)}
    columns: list[str] = []
    for name in names:
        if name in units or name == PRESET:
            columns.append(column_of(name, units.get(name, "")))
        else:  # an object by its name
            columns += [column_of(n, u) for n, u in units.items() if n == f"{name}.name"] or [name]
    return tuple(columns)


def drawn_columns(chosen: SweepPlan) -> tuple[str, str, str]:
    """Return the columns of a sweep's figure: the first that is swept, and what is asked for.

    The third is that of the uncertainty of what is asked for.
    """
    over = swept_columns(chosen.points[0], chosen.request.over)
    name = names_in(chosen.request.quantity)[0]
    unit = next(q.unit for q in chosen.case.quantities if q.name == name)
    return over[0], quantity_columns(chosen.case)[name], column_of("uncertainty", unit)


MEASURED = "measured_"
ROW = ("engine", "engine_version", "ranks", PRESET, "status", "reason", "wall_time_s")
"""Columns of every row, beside parameters and quantities."""


def quantity_columns(case: Case[Any]) -> dict[str, str]:
    """Return the columns of the quantities of a case by their names, each its name with its unit.

    One with the name or the column of a parameter is ``measured_NAME``, as one with the name of a
    column that every row has: what was asked for and what was measured never share a column.
    """
    fields = case.parameters.model_fields
    units = {name: unit_in(declared.description or "") for name, declared in fields.items()}
    asked = {*ROW, *units, *(column_of(name, unit) for name, unit in units.items())}
    own = {q.name: column_of(q.name, q.unit) for q in case.quantities}
    clashing = {name for name, column in own.items() if asked & {name, column}}
    taken = asked | {column for name, column in own.items() if name not in clashing}
    columns: dict[str, str] = {}
    for name, column in own.items():
        if name in clashing:
            column = MEASURED + column
            while column in taken:
                column = MEASURED + column
            taken.add(column)
        columns[name] = column
    return columns


def column_of(name: str, unit: str) -> str:
    """Return a name with its unit, as ``stiffness_N_per_m``; one that ends in it stays."""
    spelled = unit.removeprefix("1").replace("/", "_per_").replace(" ", "").replace("^", "")
    spelled = spelled.removeprefix("_")  # of 1/s
    if spelled in ("", "-") or name.endswith(f"_{spelled}"):
        return name
    return f"{name}_{spelled}"


def reference_lines(
    chosen: SweepPlan, column: str, over: Sequence[str]
) -> tuple[ReferenceLine, ...]:
    """Return the lines of the quantity in a column, over the first of the columns ``over``.

    One for each value of the second and each engine where they differ, between the points too
    where a reference costs little; none where a case knows no reference.
    """
    name = next(n for n, own in quantity_columns(chosen.case).items() if own == column)
    drawn = _first_of_each(chosen.points, over)
    engines: dict[ReferenceLine, list[str]] = {}
    for engine in chosen.engines:
        rules = NO_RULES if chosen.solves(engine) else engine_class(engine).traits
        for second, points in _by_second(drawn, over):
            line = _line(chosen, name, over[0], points, rules)
            if line is not None:
                engines.setdefault(replace(line, second=second), []).append(engine_title(engine))
    lines = [
        replace(line, engines=() if len(those) == len(chosen.engines) else tuple(those))
        for line, those in engines.items()
    ]
    # lines that are the same for every value of the second parameter are one
    seconds = len(_by_second(drawn, over))
    groups: dict[ReferenceLine, list[ReferenceLine]] = {}
    for line in lines:
        groups.setdefault(replace(line, second=None), []).append(line)
    return tuple(
        line
        for merged, some in groups.items()
        for line in ([merged] if len(some) == seconds else some)
    )


def _first_of_each(points: Sequence[SweepPoint], over: Sequence[str]) -> list[SweepPoint]:
    """Return the first point of each combination of the first two columns that are swept."""
    drawn: dict[tuple[Any, ...], SweepPoint] = {}
    for point in points:
        drawn.setdefault(tuple(_value(point, column) for column in over[:2]), point)
    return list(drawn.values())


def _by_second(
    points: Sequence[SweepPoint], over: Sequence[str]
) -> list[tuple[Any, list[SweepPoint]]]:
    """Return each value of the second parameter, None without one, and its points."""
    groups: dict[Any, list[SweepPoint]] = {}
    for point in points:
        second = None if len(over) < 2 else _value(point, over[1])
        groups.setdefault(second, []).append(point)
    return list(groups.items())


def _value(point: SweepPoint, column: str) -> Any:
    return parameter_columns(point.parameters).get(column, point.swept.get(column))


def _line(
    chosen: SweepPlan, name: str, across: str, points: Sequence[SweepPoint], rules: Traits
) -> ReferenceLine | None:
    from harness.report.figures import DENSE, ReferenceLine, is_logarithmic

    x: list[Any] = [_value(point, across) for point in points]
    references = _references(chosen.case, name, [p.parameters for p in points], rules)
    present = [reference for reference in references if reference is not None]
    if not present:
        return None
    kinds = dict.fromkeys(reference.kind for reference in present)
    kind = next((kind for kind in kinds if kind != "closed form"), "closed form")
    cheap = all(ref.kind == "closed form" or ref.quick for ref in present)
    numbers = all(isinstance(at, (int, float)) and not isinstance(at, bool) for at in x)
    if cheap and numbers and len(set(x)) > 1:
        between = np.geomspace if is_logarithmic(x) else np.linspace
        many = [float(f"{at:.12g}") for at in between(min(x), max(x), DENSE)]
        with suppress(HarnessError):  # whole numbers, or values that a case refuses
            x, references = many, _dense(chosen, name, points[0], many, rules)
    there = [place for place, ref in enumerate(references) if ref is not None]
    # to 12 digits: round-off makes no other line
    y = tuple(float(f"{ref.value:.12g}") for ref in references if ref is not None)
    return ReferenceLine(kind, tuple(x[place] for place in there), y)


def _dense(
    chosen: SweepPlan, name: str, point: SweepPoint, x: Sequence[float], rules: Traits
) -> list[Reference | None]:
    swept: Mapping[str, str] = point.swept
    first = chosen.request.over[0]
    settings = {**chosen.request.fixed, **swept}
    parameters = [parameters_of(chosen.case, {**settings, first: repr(at)}) for at in x]
    return _references(chosen.case, name, parameters, rules)


def _references(
    case: Case[Any], name: str, parameters: Sequence[Parameters], rules: Traits
) -> list[Reference | None]:
    """Return what is expected at each; None where that is not known."""
    references: list[Reference | None] = []
    for values in parameters:
        try:
            references.append(case.references(values, rules).get(name))
        except HarnessError:
            references.append(None)
    return references
