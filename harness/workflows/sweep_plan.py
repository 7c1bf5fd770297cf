"""The points of a sweep: every combination of the values of its parameters.

Values are text: lists such as ``1,2,5`` and ranges such as ``9:11:5`` and ``1e5:1e7:log5``.
"""

from __future__ import annotations

import itertools
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from harness.cases.base import Case
from harness.errors import CombinationError, RequestError
from harness.model.base import Parameters
from harness.workflows.settings import (
    PRESET,
    as_text,
    flat,
    flat_values,
    parameters_of,
    split_settings,
)

MOST_VALUES = 100_000  # of one parameter, and runs of one sweep: each is a row in memory
DIGITS = 15  # of the numbers of a range: 0.3, not 0.30000000000000004
GRAMMAR = "values as 1,2,5, or ranges as 9:11:5 (evenly spaced) and 1e5:1e7:log5 (in the logarithm)"


def _table(value: Any) -> dict[str, str]:
    if not isinstance(value, Mapping):
        raise ValueError("must be a table")
    return flat(value)


def _tables(value: Any) -> tuple[dict[str, str], ...]:
    return tuple(_table(table) for table in (value if isinstance(value, list | tuple) else [value]))


class SweepRequest(Parameters):
    """A sweep as text, with the names of its file."""

    # fmt: off
    case: str = Field(description="[-] name of a case")
    over: Annotated[tuple[dict[str, str], ...], BeforeValidator(_tables)] = Field(
        (), description="[-] values by parameter, all combinations; of several tables in turn")
    set: Annotated[dict[str, str], BeforeValidator(_table)] = Field(
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


@dataclass(frozen=True)
class Point:
    """A combination: swept values as text, and all parameters; or why it is refused.

    ``columns`` are the parameters in its rows, ``options`` those of a search.
    """

    swept: Mapping[str, str]
    columns: Mapping[str, Any]
    parameters: Parameters | None = None
    options: Mapping[str, Any] = field(default_factory=dict)
    refusal: str = ""

    def __str__(self) -> str:
        return ", ".join(f"{name}={value}" for name, value in self.swept.items())


def request_in(file: Path) -> SweepRequest:
    """Return the sweep of a TOML file; raise RequestError, naming it, for one that is not sound."""
    try:
        record = tomllib.loads(file.read_text(encoding="utf-8"))
        if unknown := sorted(record.keys() - SweepRequest.model_fields.keys()):
            keys = ", ".join(SweepRequest.model_fields)
            raise RequestError(f"{unknown[0]!r} is not known: must be one of {keys}")
        return SweepRequest(**record)
    except OSError as error:
        raise RequestError(f"{file}: {error.strerror or error}") from None
    except RecursionError:
        raise RequestError(f"{file}: is nested too deep; must be lists of values") from None
    except RequestError as error:
        raise RequestError(f"{file}: {error}") from None
    except ValueError as error:  # of tomllib, of decoding, of a number with too many digits
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
    for grid in grids:
        for values in itertools.product(*grid.values()):
            point = _point(case, request.set, dict(zip(grid, values, strict=True)), names)
            points.setdefault(f"{dict(point.columns)} {point.refusal and point}", point)
    first = next(iter(points.values()))
    if all(point.refusal for point in points.values()):
        every = f" (so are all {len(points)} points)" if len(points) > 1 else ""
        raise RequestError(f"--over {first}: {first.refusal}{every}")
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
    if count is None or not (math.isfinite(first) and math.isfinite(end)):
        raise RequestError(f"{option}: must be {GRAMMAR}")
    if not 2 <= int(count[2]) <= MOST_VALUES:
        raise RequestError(f"{option}: a range has from 2 to {MOST_VALUES} values")
    if count[1] and not (first > 0.0 and end > 0.0):
        raise RequestError(f"{option}: the ends of a range in the logarithm must be greater than 0")
    numbers = (np.geomspace if count[1] else np.linspace)(first, end, int(count[2]))
    return [f"{number:.{DIGITS}g}" for number in numbers]


def _point(
    case: Case[Any], fixed: Mapping[str, str], swept: Mapping[str, str], names: Sequence[str]
) -> Point:
    texts = {**fixed, **swept}
    columns: dict[str, Any] = {PRESET: texts[PRESET]} if PRESET in texts else {}
    try:
        settings, options = split_settings(case, texts, names)
        parameters = parameters_of(case, settings)
    except CombinationError as error:
        columns |= dict.fromkeys(flat_values(case.default))
        columns |= {name: _number(text) for name, text in texts.items() if name != PRESET}
        return Point(swept, columns, refusal=str(error).removeprefix("--set "))
    except RequestError as error:
        text = str(error).removeprefix("--set ")
        if any(text.startswith(f"{name} =") for name in fixed):  # not of what is swept
            raise
        raise RequestError(f"--over {Point(swept, {})}: {text}") from None
    varied = {parameter for name in names for parameter in case.quantity(name).varies}
    values = {n: v for n, v in flat_values(parameters).items() if n not in varied}
    return Point(swept, {**columns, **values, **options}, parameters, options)


def _number(text: str) -> float | str:
    try:
        return float(text)
    except ValueError:
        return text
