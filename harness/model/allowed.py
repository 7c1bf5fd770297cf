"""Ranges and words that parameters allow, as data: for messages, and for scripts run by hand."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # scripts need what is allowed, and workers of LAMMPS start without pydantic
    from pydantic import BaseModel

# keys of a JSON schema: the comparison that breaks a bound, and what is allowed
_BOUNDS = {
    "exclusiveMinimum": ("<=", "greater than"),
    "minimum": ("<", "greater than or equal to"),
    "exclusiveMaximum": (">=", "less than"),
    "maximum": (">", "less than or equal to"),
}


@dataclass(frozen=True)
class Allowed:
    """One of some ``words``, or a number within ``bounds``, perhaps a ``whole`` one.

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
        """Return a Python expression that holds for an allowed ``value``, and for no NaN."""
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


def allowed_in(kind: type[BaseModel]) -> dict[str, Allowed]:
    """Return the allowed values of the fields of a class that have a range or words, by name."""
    fields = kind.model_json_schema()["properties"]
    ranges = {name: _allowed(schema) for name, schema in fields.items()}
    return {name: limits for name, limits in ranges.items() if limits.bounds or limits.words}


def descriptions(kind: type[BaseModel]) -> dict[str, str]:
    """Return the descriptions of the fields of a class, by name, without the unit of a number."""
    fields = kind.model_fields.items()
    return {name: (field.description or "").removeprefix("[-] ") for name, field in fields}


def unit_in(description: str) -> str:
    """Return the unit in brackets that opens a description, empty for ``[-]``."""
    symbol = description[1:].partition("]")[0] if description.startswith("[") else ""
    return "" if symbol == "-" else symbol


def _allowed(schema: Mapping[str, object]) -> Allowed:
    choices = schema.get("anyOf")
    first = choices[0] if isinstance(choices, list) else {}
    limits = {**schema, **first}
    bounds = {key: limits[key] for key in _BOUNDS if key in limits}
    is_whole = limits.get("type") == "integer"
    unit = "" if is_whole else unit_in(str(limits.get("description", "")))
    return Allowed(tuple(limits.get("enum", ())), is_whole, bounds, unit)
