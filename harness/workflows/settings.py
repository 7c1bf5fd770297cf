"""Requests: engines, quantities, parameters of one run, points of a sweep, and measured points.

Settings are ``height=3``, ``contact.tail=clipped`` or ``preset=kharaz``. The values of a sweep are
lists such as ``1,2,5`` and ranges such as ``9:11:5`` and ``1e5:1e7:log5``.
"""

from __future__ import annotations

import itertools
import json
import math
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import numpy as np
from pydantic import BeforeValidator, Field

from harness.cases.base import Case
from harness.cases.registry import ALL, words_in
from harness.engines.registry import engine_class, engine_names
from harness.errors import CombinationError, RequestError
from harness.model.base import Parameters
from harness.model.scene import Floats

if TYPE_CHECKING:
    import pandas as pd

PRESET = "preset"
NONE = "none"  # text of an optional value that is not given
MOST_VALUES = 100_000  # of one parameter, and runs of one sweep: each is a row in memory
DIGITS = 15  # of the numbers of a range: 0.3, not 0.30000000000000004
GRAMMAR = "values as 1,2,5, or ranges as 9:11:5 (evenly spaced) and 1e5:1e7:log5 (in the logarithm)"


# ---- names


def selected_engines(engines: str | Iterable[str], solvers: Iterable[str] = ()) -> list[str]:
    """Return the names of engines and solvers; ``all`` is every one, in their order.

    Raise RequestError for an unknown name, and for none.
    """
    names, every = words_in(engines), [*engine_names(), *solvers]
    for name in names:
        if ":" in name:
            engine_class(name)  # module:Class, which raises where there is none
        elif name not in (ALL, *every):
            must = f"{ALL}, or one or more of {', '.join(every)}"
            raise RequestError(f"--engines {name!r} is not known: must be {must}")
    if not names:
        raise RequestError(f"--engines {engines!r}: names no engine")
    if ALL not in names:
        return names
    return list(dict.fromkeys([*every, *(name for name in names if name != ALL)]))


def quantity_names(case: Case[Any], text: str | Iterable[str]) -> list[str]:
    """Return the names of quantities in a text with commas; RequestError for an unknown one."""
    names = words_in(text)
    if len({bool(case.quantity(name).varies) for name in names}) > 1:
        raise RequestError(f"--quantity {','.join(names)}: a search is another run than the others")
    return names


# ---- the parameters of one run


@dataclass(frozen=True)
class Point:
    """The parameters of a run, and the options of a search; in a sweep with the swept values.

    ``columns`` are the cells of its row. A point of values that are not allowed together has no
    parameters, but a ``refusal``.
    """

    parameters: Any
    options: Mapping[str, Any] = field(default_factory=dict)
    columns: Mapping[str, Any] = field(default_factory=dict)
    swept: Mapping[str, str] = field(default_factory=dict)
    refusal: str = ""


def point_of(case: Case[Any], texts: Mapping[str, str], names: Sequence[str] = ()) -> Point:
    """Return the point of settings, on top of the default or a preset, to measure quantities at.

    Raise RequestError, naming setting, value and what is allowed, for a wrong name or value, for an
    option without a search, and for a parameter that a search varies; CombinationError for values
    that are not allowed together.
    """
    searched = [quantity for name in names if (quantity := case.quantity(name)).varies]
    fields = case.search_options.model_fields
    options = {name: text for name, text in texts.items() if name in fields}
    for quantity in searched:
        for name in quantity.varies:
            if name in texts:
                raise RequestError(f"--set {name}={texts[name]}: {quantity.name} varies it")
    if options and not searched:
        names = [quantity.name for quantity in case.quantities if quantity.varies]
        goes = f"goes with --quantity {', '.join(names)} only"
        raise RequestError(f"--set {next(iter(options))}: {goes}")
    preset = texts.get(PRESET)
    if preset is not None and preset not in case.presets:
        presets = ", ".join(case.presets)
        raise RequestError(f"--set preset={preset}: case {case.name!r} has the presets {presets}")
    base = case.default if preset is None else case.presets[preset]
    others = {name: text for name, text in texts.items() if name not in (PRESET, *options)}
    parameters, chosen = changed(base, others), dict(changed(case.search_options(), options))
    columns = {**({} if preset is None else {PRESET: preset}), **_cells(parameters), **chosen}
    for quantity in searched:
        for name in quantity.varies:
            columns.pop(name, None)
    return Point(parameters, chosen, columns)


def changed(parameters: Parameters, texts: Mapping[str, str], path: str = "") -> Parameters:
    """Return parameters with settings on top; ``path`` leads to parameters that are nested."""
    kind = type(parameters)
    values = {name: _value(kind, name, text) for name, text in texts.items() if "." not in name}
    parts: dict[str, dict[str, str]] = {}
    for name, text in texts.items():
        outer, dot, inner = name.partition(".")
        if dot:
            parts.setdefault(outer, {})[inner] = text
    for name, inner_texts in parts.items():
        nested = getattr(parameters, name, None)
        if name in values:
            raise RequestError(f"--set {path}{name}: is set as a whole already")
        if isinstance(nested, Parameters):
            values[name] = changed(nested, inner_texts, f"{path}{name}.")
        elif name in kind.model_fields:
            raise RequestError(f"--set {path}{name}.{min(inner_texts)}: {name} has no parts")
        else:
            values[name] = inner_texts  # refused by name, with the names that there are
    try:
        return parameters.replace(**values)
    except CombinationError as error:
        raise CombinationError(f"--set {error}") from None
    except RequestError as error:
        raise RequestError(f"--set {path}{error}") from None


def _value(kind: type[Parameters], name: str, text: str) -> Any:
    field = kind.model_fields.get(name)
    types = () if field is None else (field.annotation, *get_args(field.annotation))
    if text == NONE and type(None) in types:
        return None
    if int in types:
        with suppress(ValueError):
            return int(text)
    if types and text[:1] in "[(":
        with suppress(ValueError):
            return json.loads(text.replace("(", "[").replace(")", "]"))
    return text


def leaves(tree: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of nested parameters or tables, with dots in their names."""
    if not isinstance(tree, Mapping | Parameters):
        raise RequestError("must be a table")
    for name, value in tree.items() if isinstance(tree, Mapping) else tree:
        if isinstance(value, Mapping | Parameters):
            yield from leaves(value, f"{path}{name}.")
        else:
            yield path + name, value


def as_text(values: Any) -> str:
    """Return values of a TOML file or of Python as the text of the command line."""
    many = values if isinstance(values, Iterable) and not isinstance(values, str) else [values]
    return ",".join(NONE if value is None else str(value) for value in many)


def texts_of(settings: Any) -> dict[str, str]:
    """Return settings as the text of the command line, of nested ones with dots in the names."""
    return {name: _setting(value) for name, value in leaves(settings)}


def _setting(value: Any) -> str:
    if isinstance(value, Iterable) and not isinstance(value, str):
        return json.dumps([*value], default=float)
    return as_text(value)


def swept_texts(tree: Any) -> dict[str, str]:
    """Return the values of swept parameters as the text of the command line, by name."""
    return {name: as_text(value) for name, value in leaves(tree)}


def _cells(values: Parameters) -> dict[str, Any]:
    """Return all values by name; lists as JSON text."""

    def cell(value: Any) -> Any:
        if value is None or isinstance(value, bool | int | float | str):
            return value
        return json.dumps(value, default=lambda part: part.model_dump(mode="json"))

    return {name: cell(value) for name, value in leaves(values)}


# ---- the points of a sweep


def _grids(value: Any) -> tuple[dict[str, str], ...]:
    return tuple(map(swept_texts, value if isinstance(value, list | tuple) else [value]))


class SweepRequest(Parameters):
    """A sweep as text, with the names of its file."""

    # fmt: off
    case: str = Field(description="[-] name of a case")
    over: Annotated[tuple[dict[str, str], ...], BeforeValidator(_grids)] = Field(
        (), description="[-] values by parameter, all combinations; of several tables in turn")
    set: Annotated[dict[str, str], BeforeValidator(texts_of)] = Field(
        {}, description="[-] parameters that are the same in every run")
    engines: Annotated[str, BeforeValidator(as_text)] = Field(
        "", description="[-] engines and solvers of the case")
    quantity: Annotated[str, BeforeValidator(as_text)] = Field(
        "", description="[-] measured quantities")
    # fmt: on

    @property
    def swept(self) -> tuple[str, ...]:
        """Return the names of the swept parameters."""
        return tuple(dict.fromkeys(name for grid in self.over for name in grid))


def request_in(file: Path) -> SweepRequest:
    """Return the sweep of a TOML file; raise RequestError, naming it, for one that is not sound."""
    try:
        record = tomllib.loads(file.read_text(encoding="utf-8"))
        return SweepRequest(**record)
    except OSError as error:
        raise RequestError(f"{file}: {error.strerror or error}") from None
    except RequestError as error:
        raise RequestError(f"{file}: {error}") from None
    except (ValueError, RecursionError) as error:  # of tomllib, of decoding, of digits or nesting
        raise RequestError(f"{file}: is not TOML ({str(error)[:200]})") from None


def points_of(case: Case[Any], request: SweepRequest, names: Sequence[str]) -> list[Point]:
    """Return the points at which a sweep measures quantities, each once.

    Values that are not allowed together are a refused point. Raise RequestError for a name or a
    value that is not allowed by itself, and where every point is refused.
    """
    if not request.over or not all(request.over):
        raise RequestError("--over: must be given, a parameter with its values: NAME=VALUES")
    for name, value in request.set.items():
        if name in request.swept:
            raise RequestError(f"--over {name}: is set by --set {name}={value} already")
    grids = [{name: values_of(name, text) for name, text in grid.items()} for grid in request.over]
    if (count := sum(math.prod(map(len, grid.values())) for grid in grids)) > MOST_VALUES:
        raise RequestError(f"--over: {count} points are requested: must be at most {MOST_VALUES}")
    points: dict[str, Point] = {}
    for swept in _combinations(grids):
        point = _swept_point(case, request.set, swept, names)
        points.setdefault(str(swept if point.refusal else point.columns), point)
    if all(point.refusal for point in points.values()):
        first = next(iter(points.values()))
        raise RequestError(f"--over {_text(first.swept)}: {first.refusal}")
    return list(points.values())


def values_of(name: str, text: str) -> list[str]:
    """Return the values of a text, each once and in order. Raise RequestError for bad grammar."""
    values: dict[str, None] = {}
    for item in text.split(","):
        values |= dict.fromkeys(_range(name, item) if ":" in item else [item.strip()])
    if "" in values:
        raise RequestError(f"--over {name}={text}: a value is empty; must be {GRAMMAR}")
    return list(values)


def _range(name: str, item: str) -> list[str]:
    option = f"--over {name}={item}"
    *ends, last = (part.strip() for part in item.split(":"))
    count = re.fullmatch(r"(log)?(\d{1,9})", last, re.ASCII)
    try:
        first, end = map(float, ends)
    except ValueError:
        first = end = math.nan
    if count is None or not math.isfinite(end - first):
        raise RequestError(f"{option}: must be {GRAMMAR}")
    if not 2 <= int(count[2]) <= MOST_VALUES:
        raise RequestError(f"{option}: a range has from 2 to {MOST_VALUES} values")
    if count[1] and not (first > 0.0 and end > 0.0):
        raise RequestError(f"{option}: the ends of a range in the logarithm must be greater than 0")
    numbers = (np.geomspace if count[1] else np.linspace)(first, end, int(count[2]))
    return [f"{number:.{DIGITS}g}" for number in numbers]


def _combinations(grids: Iterable[Mapping[str, Sequence[str]]]) -> Iterator[dict[str, str]]:
    for grid in grids:
        for values in itertools.product(*grid.values()):
            yield dict(zip(grid, values, strict=True))


def _swept_point(
    case: Case[Any], fixed: Mapping[str, str], swept: Mapping[str, str], names: Sequence[str]
) -> Point:
    texts = {**fixed, **swept}
    try:
        return replace(point_of(case, texts, names), swept=swept)
    except CombinationError as error:
        columns = dict.fromkeys(_cells(case.default)) | {n: _number(t) for n, t in texts.items()}
        return Point(None, {}, columns, swept, refusal=str(error).removeprefix("--set "))
    except RequestError as error:
        text = str(error).removeprefix("--set ")
        if any(text.startswith(f"{name} =") for name in fixed):  # not of what is swept
            raise
        raise RequestError(f"--over {_text(swept)}: {text}") from None


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text


def _text(swept: Mapping[str, str]) -> str:
    return ", ".join(f"{name}={value}" for name, value in swept.items())


# ---- measured points of a user


@dataclass(frozen=True)
class Points:
    """Measured points of a user, with the name of their file."""

    name: str
    x: Floats
    y: Floats
    uncertainty: Floats | None = None


def read_points(path: Path, x: str, y: str, uncertainties: Sequence[str] = ()) -> Points:
    """Return the points of columns ``x`` and ``y``; their errors from the first such column.

    Raise RequestError in a line for a bad file.
    """
    numbers = read_numbers(path, (x, y), uncertainties)
    return Points(path.name, *(numbers[name].to_numpy() for name in numbers))


def read_numbers(
    path: Path, columns: Sequence[str], uncertainties: Sequence[str] = ()
) -> pd.DataFrame:
    """Return columns of a file of measured points, and the first of ``uncertainties`` it has.

    Raise RequestError in a line for a bad file.
    """
    import pandas as pd  # slow to load

    option = f"--reference {path}"
    try:
        frame = pd.read_csv(path, comment="#", skipinitialspace=True, encoding="utf-8-sig")
    except OSError as error:
        raise RequestError(f"{option}: {error.strerror or error}") from None
    except ValueError as error:  # also of pandas, and of text that is not UTF-8
        raise RequestError(f"{option}: is no CSV table ({' '.join(str(error).split())})") from None
    names = [*columns, *[name for name in uncertainties if name in frame][:1]]
    for name in names:
        if name not in frame:
            others = ", ".join(map(str, frame.columns))
            raise RequestError(f"{option}: has no column {name!r}, but {others}")
    numbers: pd.DataFrame = frame[names].apply(pd.to_numeric, errors="coerce").astype(float)
    for row, column in np.argwhere(~np.isfinite(numbers.to_numpy())):
        text = f"{names[column]} = {str(frame[names[column]].iloc[row])!r}: must be a number"
        raise RequestError(f"{option}, row {row + 2}: {text}")
    if frame.empty or (numbers.iloc[:, len(columns) :] < 0.0).any(axis=None):
        raise RequestError(f"{option}: must have rows, whose errors are not negative")
    return numbers
