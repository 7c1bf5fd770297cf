"""Frozen parameter objects in SI units, validated when they are made."""

from __future__ import annotations

import re
from collections.abc import Iterable
from inspect import cleandoc
from typing import TYPE_CHECKING, Any, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from harness.errors import CombinationError, RequestError
from harness.parameters.allowed import allowed_in, unit_in


class Parameters(BaseModel):
    """Base of all parameter objects.

    A field's description opens with its unit in brackets. Raise
    :class:`~harness.errors.RequestError` for a value that is not allowed, in
    one line that names the field, the value and the range; CombinationError
    where a validator of the whole refuses values together.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    if not TYPE_CHECKING:  # the type checker shall see the fields, not **values

        def __init__(self, **values: Any) -> None:
            try:
                super().__init__(**values)
            except ValidationError as error:
                together = not error.errors(include_url=False)[0]["loc"]
                kind = CombinationError if together else RequestError
                raise kind(_one_line(type(self), error)) from None

    @classmethod
    def __pydantic_init_subclass__(cls, **kwargs: Any) -> None:
        """Add every field with its unit to the docstring."""
        super().__pydantic_init_subclass__(**kwargs)
        fields = "\n".join(
            f"{name}: {field.description}" for name, field in cls.model_fields.items()
        )
        cls.__doc__ = f"{cleandoc(cls.__doc__ or '')}\n\nFields, with their units:\n\n{fields}"

    def replace(self, **changes: Any) -> Self:
        """Return a copy with ``changes``, validated again."""
        return type(self)(**{**dict(self), **changes})


def _one_line(kind: type[BaseModel], error: ValidationError) -> str:
    """Return the first error of a field in one line: name, value, what is allowed."""
    first = error.errors(include_url=False)[0]
    message = str(first["msg"]).removeprefix("Value error, ")
    if not first["loc"]:
        return message
    name = str(first["loc"][0])
    if first["type"] == "extra_forbidden":
        return (
            f"{name}: no such parameter of {kind.__name__} (it has {', '.join(kind.model_fields)})"
        )
    if first["type"] == "missing":
        return f"{name}: must be given"
    message = re.sub("(Input|String) should", "must", message)
    message = message[0].lower() + message[1:]
    if first["type"] in _OUT_OF_RANGE:
        finite = ["a finite number"] if first["type"] == "finite_number" else []
        limits = allowed_in(kind).get(name)
        ranges = [limits.range] if limits and limits.range else []
        allowed = ", ".join([*finite, *ranges])
        message = f"must be {allowed}" if allowed else message
    field = kind.model_fields.get(name)
    unit = unit_in((field.description if field else None) or "")
    return f"{name} = {first['input']!r}{unit and ' '}{unit}: {message}"


_OUT_OF_RANGE = {
    "finite_number",
    "greater_than",
    "greater_than_equal",
    "less_than",
    "less_than_equal",
}


def nested(named: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    """Return values by name, those of dotted names (``contact.tail``) in mappings of their own.

    Raise ValueError, naming the part, where a name comes twice or is both a value and a mapping.
    """
    tree: dict[str, Any] = {}
    for name, value in named:
        *outer, last = name.split(".")
        inner = tree
        for key in outer:
            inner = inner.setdefault(key, {})
            if not isinstance(inner, dict):
                raise ValueError(f"{name}: {key} is set as a whole already")
        if last in inner:
            raise ValueError(f"{name}: {last} is set already, or parts of it are")
        inner[last] = value
    return tree
