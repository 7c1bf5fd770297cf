"""Make commands from functions that take their options as frozen dataclasses.

``def verify(asked: Asked, engine: EngineOptions, json: Json = False)`` becomes a command with
an option for each field of ``Asked`` and ``EngineOptions``: what several commands share is
written once, and a function takes objects, not twenty parameters.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, get_type_hints

import typer


def add_command(
    app: typer.Typer, function: Callable[..., None], *examples: str, name: str | None = None
) -> None:
    """Add a function to an app; ``examples`` are lines of a shell, shown below its options."""
    shown = "\n\n".join(f"`{example}`" for example in examples)
    app.command(name, epilog=f"Examples:\n\n{shown}" if examples else None)(expanded(function))


def expanded(function: Callable[..., None]) -> Callable[..., None]:
    """Return a function with a parameter for each field of the dataclasses that it takes."""
    hints = get_type_hints(function, include_extras=True)
    groups: dict[str, Any] = {n: hint for n, hint in hints.items() if is_dataclass(hint)}
    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(function).parameters.values():
        if parameter.name in groups:
            parameters += _fields_of(groups[parameter.name])
        else:
            parameters.append(_keyword(parameter.name, hints[parameter.name], parameter.default))
    # arguments have no default and must come first in a signature
    parameters.sort(key=lambda one: one.default is not inspect.Parameter.empty)

    @functools.wraps(function)
    def command(**values: Any) -> None:
        grouped = {
            name: kind(**{field.name: values.pop(field.name) for field in fields(kind)})
            for name, kind in groups.items()
        }
        function(**grouped, **values)

    signature = inspect.Signature(parameters)
    command.__signature__ = signature  # type: ignore[attr-defined]
    command.__annotations__ = {one.name: one.annotation for one in parameters}
    del command.__wrapped__
    return command


def _fields_of(kind: Any) -> list[inspect.Parameter]:
    hints = get_type_hints(kind, include_extras=True)
    return [_keyword(field.name, hints[field.name], _default(field)) for field in fields(kind)]


def _default(field: Field[Any]) -> Any:
    return inspect.Parameter.empty if field.default is MISSING else field.default


def _keyword(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    if annotation.__origin__ is bool:
        (option,) = annotation.__metadata__
        option.metavar = option.metavar or " "  # a flag takes no value
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation
    )
