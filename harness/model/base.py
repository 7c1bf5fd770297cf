"""Frozen parameter objects in SI units, validated when they are made."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from harness.errors import CombinationError, RequestError
from harness.model.allowed import unit_in

Vector = tuple[float, float, float]
ZERO: Vector = (0.0, 0.0, 0.0)

Positive = Annotated[float, Field(ge=1e-30, le=1e30)]  # their products stay in double precision
NotNegative = Annotated[float, Field(ge=0.0, le=1e30)]


class Parameters(BaseModel):
    """Base of all parameter objects.

    The description of a field opens with its unit in brackets. Raise RequestError for a value
    that is not allowed, in one line that names the field, the value and what is allowed; raise
    CombinationError for values that are not allowed together.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    if not TYPE_CHECKING:  # type checkers see the fields in place of **values

        def __init__(self, **values: Any) -> None:
            try:
                super().__init__(**values)
            except ValidationError as error:
                together = not error.errors(include_url=False)[0]["loc"]
                kind = CombinationError if together else RequestError
                raise kind(_error_line(type(self), error)) from None

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


def unit(kind: type[Parameters], name: str) -> str:
    """Return the unit of a field, empty for a pure number."""
    field = kind.model_fields.get(name)
    return unit_in((field and field.description) or "")


def unit_vector(value: Vector) -> Vector:
    """Return a vector with length 1; raise ValueError for one without a direction."""
    length = math.hypot(*value)
    if length == 0.0:
        raise ValueError("must have a direction: not (0, 0, 0)")
    return (value[0] / length, value[1] / length, value[2] / length)


Direction = Annotated[Vector, AfterValidator(unit_vector)]


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
    text = f"{name} = {first['input']!r} {unit(kind, name)}".rstrip()
    return f"{text}: {message[0].lower()}{message[1:]}"
