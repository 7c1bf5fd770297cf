"""Make commands from functions that take their options as frozen dataclasses.

``def verify(asked: VerifyOptions, engine: EngineOptions, json: Json = False)`` becomes a command
with an option for each field of the two: what several commands share is written once, and a
function takes objects, not twenty parameters.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, field, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer


def option(default: Any, text: str, *names: str, panel: str | None = None, **more: Any) -> Any:
    """Return a field of a dataclass that is an option; ``text`` is its help.

    It is called ``--field-name`` unless names are given; ``more`` is what typer's options take.
    """
    made = {"help": text, "rich_help_panel": panel, **more}
    return field(default=default, metadata={"names": names, "made": made})


def argument(metavar: str, text: str) -> Any:
    """Return a field of a dataclass that is a required argument, not an option."""
    return field(kw_only=True, metadata={"made": {"metavar": metavar, "help": text}})


def add_command(
    app: typer.Typer, function: Callable[..., None], *examples: str, name: str | None = None
) -> None:
    """Add a function to an app; ``examples`` are lines of a shell, shown below its options."""
    shown = "\n\n".join(f"`{example}`" for example in examples)
    app.command(name, epilog=f"Examples:\n\n{shown}")(expanded(function))


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
        _check_paths({_called(one): values[one.name] for one in parameters})
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


def _check_paths(values: Mapping[str, Any]) -> None:
    """Raise RequestError for a path that no system call takes: too long, below what is locked."""
    for name, path in values.items():
        if isinstance(path, Path):
            try:
                path.stat()
            except (FileNotFoundError, NotADirectoryError):
                pass
            except OSError as error:
                from harness.errors import RequestError

                raise RequestError(f"{name} {path}: {error.strerror}") from None


def _called(parameter: inspect.Parameter) -> str:
    """Return the name of an option, or of what stands alone."""
    name = parameter.name.replace("_", "-")
    return name if parameter.default is inspect.Parameter.empty else f"--{name}"


def _fields_of(kind: Any) -> list[inspect.Parameter]:
    hints = get_type_hints(kind)
    return [_parameter(one, hints[one.name]) for one in fields(kind)]


def _parameter(one: Field[Any], kind: Any) -> inspect.Parameter:
    """Return the parameter of a field; a flag has one name, without ``--no-``."""
    made = one.metadata["made"]
    if one.default is MISSING:
        return _keyword(one.name, Annotated[kind, typer.Argument(**made)], inspect.Parameter.empty)
    names = one.metadata["names"] or (f"--{one.name.replace('_', '-')}",)
    return _keyword(one.name, Annotated[kind, typer.Option(*names, **made)], one.default)


def _keyword(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    if annotation.__origin__ is bool:
        (told,) = annotation.__metadata__
        told.metavar = told.metavar or " "  # a flag takes no value
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation
    )
