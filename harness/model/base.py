"""Frozen parameter objects in SI units, validated when they are made, and what they allow.

Ranges and words that a field allows are data (:class:`Allowed`): for messages, and for scripts that
are run by hand.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from harness.errors import CombinationError, RequestError

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)

Positive = Annotated[float, Field(ge=1e-30, le=1e30)]  # their products stay in double precision
NotNegative = Annotated[float, Field(ge=0.0, le=1e30)]
DIMENSIONS = {  # powers of length, mass and time of units
    "N/m": (0, 1, -2), "kg/s": (0, 1, -1), "Pa": (-1, 1, -2), "J/m2": (0, 1, -2), "m": (1, 0, 0),
    "N m": (2, 1, -2), "N m s": (2, 1, -1),
}  # fmt: skip
# keys of a JSON schema: the comparison that breaks a bound, and what is allowed
_BOUNDS = {
    "exclusiveMinimum": ("<=", "greater than"),
    "minimum": ("<", "greater than or equal to"),
    "exclusiveMaximum": (">=", "less than"),
    "maximum": (">", "less than or equal to"),
}


class Parameters(BaseModel):
    """Base of all parameter objects.

    The description of a field opens with its unit in brackets. Raise RequestError for a value
    that is not allowed, in one line that names the field, the value and what is allowed; raise
    CombinationError for values that are not allowed together.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
    __slots__ = ("_hash",)  # computed once: scenes are keys of all that is run; no copy takes it

    if not TYPE_CHECKING:  # type checkers see the fields in place of **values

        def __init__(self, **values: Any) -> None:
            try:
                super().__init__(**values)
            except ValidationError as error:
                together = not error.errors(include_url=False)[0]["loc"]
                kind = CombinationError if together else RequestError
                raise kind(_error_line(type(self), error)) from None

        def __hash__(self) -> int:
            try:
                return self._hash
            except AttributeError:
                values = tuple(map(self.__dict__.get, type(self).model_fields))
                object.__setattr__(self, "_hash", hash(values))
                return self._hash

    def replace(self, **changes: Any) -> Self:
        """Return a copy with changed fields, validated again.

        ``model_copy(update=...)`` validates nothing: for a known defect that is another law.
        """
        return type(self)(**{**dict(self), **changes})

    @property
    def changed(self) -> dict[str, Any]:
        """Return the fields that differ from their defaults."""
        fields = type(self).model_fields
        return {name: value for name, value in self if value != fields[name].default}


def unit_vector(value: Vector) -> Vector:
    """Return a vector with length 1; raise ValueError for one without a direction."""
    length = math.hypot(*value)
    if length == 0.0:
        raise ValueError("must have a direction: not (0, 0, 0)")
    return (value[0] / length, value[1] / length, value[2] / length)


Direction = Annotated[Vector, AfterValidator(unit_vector)]


# ---- units, descriptions, and what is allowed


def unit(kind: type[Parameters], name: str) -> str:
    """Return the unit of a field, empty for a pure number."""
    info = kind.model_fields.get(name)
    return unit_in((info and info.description) or "")


def unit_in(description: str) -> str:
    """Return the unit in brackets that opens a description, empty for ``[-]``."""
    symbol = description[1:].partition("]")[0] if description.startswith("[") else ""
    return "" if symbol == "-" else symbol


def unit_size(symbol: str, length: float, mass: float, time: float) -> float:
    """Return the size [SI] of a unit where length, mass and time have others [m, kg, s].

    1 of a pure number, and of a unit with none of the three.
    """
    x, y, z = DIMENSIONS.get(symbol, (0, 0, 0))
    return length**x * mass**y * time**z


def descriptions(kind: type[Parameters]) -> dict[str, str]:
    """Return the descriptions of the fields of a class, by name, without the unit of a number."""
    fields = kind.model_fields.items()
    return {name: (info.description or "").removeprefix("[-] ") for name, info in fields}


@dataclass(frozen=True)
class Allowed:
    """One of some ``words``, or a number within ``bounds``, perhaps a whole one.

    ``bounds`` have the keys of a JSON schema (``minimum``, ``exclusiveMaximum``, ...); ``unit`` is
    empty for a pure number and a count.
    """

    words: tuple[str, ...] = ()
    is_whole: bool = False
    bounds: Mapping[str, float] = field(default_factory=dict)
    unit: str = ""

    @property
    def broken(self) -> list[tuple[str, str]]:
        """Return the comparisons that hold for a number out of range: operator and bound."""
        return [
            (_BOUNDS[key][0], f"{bound:.12g}" if float(f"{bound:.12g}") == bound else repr(bound))
            for key, bound in self.bounds.items()
        ]

    @property
    def expression(self) -> str:
        """Return a Python expression that is true for an allowed ``value``, and false for NaN."""
        if self.words:
            return f"value in {json.dumps(self.words)}"
        broken = "".join(f"value {operator} {bound} or " for operator, bound in self.broken)
        return f"not ({broken}value != value)"

    @property
    def range(self) -> str:
        """Return the bounds in words, as ``greater than 0 and less than 5``; empty without."""
        return " and ".join(f"{_BOUNDS[k][1]} {bound:.12g}" for k, bound in self.bounds.items())

    @property
    def text(self) -> str:
        """Return what is allowed, for an error."""
        if self.words:
            return f"must be one of {', '.join(self.words)}"
        return f"must be {'a whole number, ' if self.is_whole else ''}{self.range}"


COUNT = Allowed(is_whole=True, bounds={"minimum": 1})


def allowed_in(kind: type[Parameters]) -> dict[str, Allowed]:
    """Return the allowed values of the fields of a class that have a range or words, by name."""
    fields = kind.model_json_schema()["properties"]
    ranges = {name: _allowed(schema) for name, schema in fields.items()}
    return {name: limits for name, limits in ranges.items() if limits.bounds or limits.words}


# ---- helpers


def _error_line(kind: type[Parameters], error: ValidationError) -> str:
    first = error.errors(include_url=False)[0]
    message = str(first["msg"]).removeprefix("Value error, ")
    if not first["loc"]:
        return message
    name = str(first["loc"][0])
    if first["type"] == "extra_forbidden":
        return f"{name}: no such parameter of {kind.__name__} ({', '.join(kind.model_fields)})"
    if first["type"] == "missing":
        return f"{name}: must be given"
    message = re.sub("(Input|String) should", "must", message)
    message = re.sub(r"\d+\.?\d{16,}", lambda number: repr(float(number[0])), message)  # 1e-30
    text = f"{name} = {first['input']!r} {unit(kind, name)}".rstrip()
    return f"{text}: {message[0].lower()}{message[1:]}"


def _allowed(schema: Mapping[str, object]) -> Allowed:
    choices = schema.get("anyOf")
    first = choices[0] if isinstance(choices, list) else {}
    limits = {**schema, **first}
    bounds = {key: limits[key] for key in _BOUNDS if key in limits}
    is_whole = limits.get("type") == "integer"
    symbol = "" if is_whole else unit_in(str(limits.get("description", "")))
    return Allowed(tuple(limits.get("enum", ())), is_whole, bounds, symbol)
