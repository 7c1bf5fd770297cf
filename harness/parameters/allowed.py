"""What values are allowed, as the parameters declare it: for messages, and for scripts by hand."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pydantic import BaseModel

_BOUNDS = {
    "exclusiveMinimum": ("<=", "greater than"),
    "minimum": ("<", "greater than or equal to"),
    "exclusiveMaximum": (">=", "less than"),
    "maximum": (">", "less than or equal to"),
}
"""By their names in a JSON schema: how a number breaks a bound, and what is allowed."""


@dataclass(frozen=True)
class Allowed:
    """One of some ``words``; or a number within ``bounds``, perhaps a ``whole`` one.

    ``bounds`` have the names of a JSON schema (``minimum``, ``exclusiveMaximum``, ...); ``unit`` is
    empty for a pure number and a count.
    """

    words: tuple[str, ...] = ()
    whole: bool = False
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
        """Return the bounds in words, as ``greater than 0 and less than 5``; nothing without."""
        return " and ".join(f"{_BOUNDS[k][1]} {bound:.12g}" for k, bound in self.bounds.items())

    @property
    def text(self) -> str:
        """Return what is allowed, for an error."""
        if self.words:
            return f"must be one of {', '.join(self.words)}"
        kind = "a whole number, " if self.whole else ""
        return f"must be {kind}{self.range}"


COUNT = Allowed(whole=True, bounds={"minimum": 1})
"""A whole number, one at least."""


def allowed_in(kind: type[BaseModel]) -> dict[str, Allowed]:
    """Return what the fields of a class of parameters allow, of those with a range or words."""
    result = {}
    for name, schema in kind.model_json_schema()["properties"].items():
        limits = {**schema, **schema.get("anyOf", [{}])[0]}
        bounds = {key: limits[key] for key in _BOUNDS if key in limits}
        words = tuple(limits.get("enum", ()))
        if bounds or words:
            integer = limits.get("type") == "integer"
            unit = "" if integer else unit_in(limits.get("description", ""))
            result[name] = Allowed(words, integer, bounds, unit)
    return result


def unit_in(description: str) -> str:
    """Return the unit that opens a field's description in brackets, empty for ``[-]``."""
    unit = description[1:].partition("]")[0] if description.startswith("[") else ""
    return "" if unit == "-" else unit
