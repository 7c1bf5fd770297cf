"""Dataclasses as JSON and back, by their own fields: there is no second description of a result.

Properties under ``computed_field`` are written too. A number that is not finite is null in JSON,
and NaN when it is read.
"""

from __future__ import annotations

import math
from functools import cache
from typing import Annotated, Any

from pydantic import BeforeValidator, TypeAdapter, WithJsonSchema


def _nan(value: Any) -> Any:
    return math.nan if value is None else value


Number = Annotated[
    float, BeforeValidator(_nan), WithJsonSchema({"anyOf": [{"type": "number"}, {"type": "null"}]})
]
"""A number that may be missing: null in JSON, NaN here."""


@cache
def adapter(kind: Any) -> TypeAdapter[Any]:
    """Return what reads and writes a dataclass."""
    return TypeAdapter(kind)


def published(value: Any) -> dict[str, Any]:
    """Return a dataclass as a mapping of JSON values; what is not finite stays so."""
    kind: Any = type(value)
    found: dict[str, Any] = adapter(kind).dump_python(value, mode="json")
    return found
