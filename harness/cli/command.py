"""Make commands from functions that take their options as frozen dataclasses.

What several commands share: types of options, and texts.

Names are spelled out, not imported: --help must not wait for numba.

Options of several values: numbers as ``1-19`` or ``1,2,5``.

``def verify(asked: VerifyOptions, engine: EngineOptions, json: Json = False)`` becomes a command
with an option for each field of the two: what several commands share is written once, and a
function takes objects, not twenty parameters. A field without a default is a required argument.
Help and metavars stand in ``options.toml``.
"""

from __future__ import annotations

import functools
import inspect
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_type_hints

import typer
from typer.core import TyperArgument, TyperCommand

from harness.errors import RequestError

Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout, and nothing else.")
]

ContactName = Literal["source", "clipped", "plastic"]
Level = Literal["quick", "default", "full"]
Reading = Literal["kept", "lost"]


_MOST = 10_000


def heights(text: str) -> list[int]:
    """Return the heights of ``1-19,30``, each once, in the order given.

    Raise RequestError for what is not one, and for heights outside 1 to 10000.
    """
    found: dict[int, None] = {}
    for part in text.split(","):
        ends = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", part.strip(), re.ASCII)
        if ends is None:
            raise RequestError(
                f"--heights {text!r}: {part.strip()!r} must be a whole number or a range, as 1-19"
            )
        first, last = int(ends[1]), int(ends[2] or ends[1])
        if not 1 <= first <= last <= _MOST:
            raise RequestError(f"--heights {text!r}: {part.strip()} must rise within 1 to {_MOST}")
        found |= dict.fromkeys(range(first, last + 1))
    return list(found)


def numbers(texts: Iterable[str], option: str) -> list[float]:
    """Return the numbers of ``["1e5,1e6", "1e7"]``, each once, in the order given.

    Raise RequestError for what is not one; its range is for the parameters to judge.
    """
    found: dict[float, None] = {}
    for text in texts:
        for part in text.split(","):
            try:
                found[float(part)] = None
            except ValueError:
                raise RequestError(f"{option} {text!r}: {part!r} is not a number") from None
    return list(found)


OPTIONS = tomllib.loads(Path(__file__).with_name("options.toml").read_text("utf-8"))
"""Examples of the commands, and help of the options by module, class and field."""


KINDS = {bool: " ", float: "NUMBER", int: "INTEGER", str: "TEXT", Path: "PATH"}
"""Metavars of options that have none in ``options.toml``, by type; a flag takes no value."""


class Command(TyperCommand):
    """A command whose help names values by their metavars, and no types of Python."""

    def __init__(self, *positional: Any, **named: Any) -> None:
        super().__init__(*positional, **named)
        for parameter in self.params:
            if isinstance(parameter, TyperArgument):  # its name stands beside it
                setattr(parameter, "display_type_rich", lambda ctx: None)  # noqa: B010, ARG005

    def get_help_option(self, ctx: Any) -> Any:
        """Return ``--help``, a flag that takes no value."""
        option = super().get_help_option(ctx)
        if option is not None:
            option.metavar = " "
        return option


def add_command(app: typer.Typer, function: Callable[..., None]) -> None:
    """Add a function to an app, with its examples below its options."""
    shown = "\n\n".join(f"`{example}`" for example in OPTIONS["examples"][function.__name__])
    app.command(cls=Command, epilog=f"Examples:\n\n{shown}")(expanded(function))


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
                raise RequestError(f"{name} {path}: {error.strerror}") from None


def _called(parameter: inspect.Parameter) -> str:
    """Return the name of an option, or of what stands alone."""
    name = parameter.name.replace("_", "-")
    return name if parameter.default is inspect.Parameter.empty else f"--{name}"


def _fields_of(kind: Any) -> list[inspect.Parameter]:
    hints = get_type_hints(kind)
    return [_parameter(one, hints[one.name], _told(kind, one.name)) for one in fields(kind)]


def _told(kind: Any, name: str) -> dict[str, Any]:
    """Return what ``options.toml`` says of a field, of the class that declares it."""
    owner = next(base for base in kind.__mro__ if name in vars(base).get("__annotations__", {}))
    section = OPTIONS.get(owner.__module__.rpartition(".")[2], {}).get(owner.__name__, {})
    return {"panel": section.get("panel"), **(section.get(name) or OPTIONS["every"][name])}


def _parameter(one: Field[Any], kind: Any, told: dict[str, Any]) -> inspect.Parameter:
    """Return the parameter of a field; a flag has one name, without ``--no-``."""
    made = {"rich_help_panel" if key == "panel" else key: value for key, value in told.items()}
    names = made.pop("names", [f"--{one.name.replace('_', '-')}"])
    if one.default is MISSING:
        return _keyword(one.name, Annotated[kind, typer.Argument(**made)], inspect.Parameter.empty)
    kinds = [KINDS[each] for each in (kind, *get_args(kind)) if each in KINDS]
    made.setdefault("metavar", kinds[0] if kinds else None)
    return _keyword(one.name, Annotated[kind, typer.Option(*names, **made)], one.default)


def _keyword(name: str, annotation: Any, default: Any) -> inspect.Parameter:
    if annotation.__origin__ is bool:
        (told,) = annotation.__metadata__
        told.metavar = told.metavar or " "  # a flag takes no value
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation
    )
