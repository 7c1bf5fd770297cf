"""The app and its commands, functions of which cyclopts makes options and help.

Options that several commands share are fields of a frozen dataclass that :func:`options` marks; a
command takes it as one parameter, and each field is an option. Whole numbers and paths are checked
here, because cyclopts would cut 1.5 to 1 and hand a path on that no system call takes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar, dataclass_transform, get_args, get_type_hints

from cyclopts import (
    App,
    CoercionError,
    CycloptsError,
    Group,
    MissingArgumentError,
    Parameter,
    Token,
    UnusedCliTokensError,
    convert,
)

from harness import __version__
from harness.errors import RequestError

Json = Annotated[bool, Parameter(help="Print one JSON object on stdout, and nothing else.")]
Folder = Annotated[Path | None, Parameter(metavar="DIR")]
File = Annotated[Path | None, Parameter(metavar="FILE")]
Name = Annotated[str | None, Parameter(metavar="NAME")]
Settings = Annotated[list[str] | None, Parameter(name="--set", metavar="NAME=VALUE")]

ContactName = Literal["source", "clipped", "plastic"]
Level = Literal["quick", "default", "full"]
Reading = Literal["kept", "lost"]

Class = TypeVar("Class")


@cache
def panel(name: str) -> Group:
    """Return a panel of the help, the same one for the same name; the plain options first."""
    return Group(name, sort_key=name != "Options")


@dataclass_transform(frozen_default=True, kw_only_default=True)
def options(title: str = "Options") -> Callable[[type[Class]], type[Class]]:
    """Return a decorator: a frozen dataclass whose fields are options in a panel of the help."""

    def decorate(kind: type[Class]) -> type[Class]:
        hints = get_type_hints(kind, include_extras=True)
        for name in kind.__annotations__:
            plain, *more = get_args(Annotated[hints[name], ""])
            # in place of strings: an inherited one would be looked up in the heir's module
            kind.__annotations__[name] = Annotated[
                plain, Parameter(group=panel(title)), *(extra for extra in more if extra)
            ]
        return Parameter(name="*")(dataclass(frozen=True, kw_only=True)(kind))

    return decorate


def converted(kind: Any, tokens: Sequence[Token]) -> Any:
    """Return the value of an option; raise RequestError for what is not of its type."""
    kinds, text, name = {kind, *get_args(kind)}, tokens[0].value, tokens[0].keyword
    if int in kinds:
        try:
            return int(text)
        except ValueError:
            raise RequestError(f"{name} {text!r}: must be a whole number") from None
    if Path in kinds:
        _check_path(Path(text), name)
    return convert(kind, tokens)


def default_text(value: Any) -> str | None:
    """Return the text of a default in the help; None for a flag or an empty default."""
    if value is None or value is False or value in ("", ()):
        return None
    return f"{value:g}" if isinstance(value, float) else str(value)


def _check_path(path: Path, option: str | None) -> None:
    """Raise RequestError for a path that no system call takes: too long, below what is locked."""
    try:
        path.stat()
    except (FileNotFoundError, NotADirectoryError):
        pass
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise RequestError(f"{option or ''} {path}: {reason}".strip()) from None


def with_options(message: str, words: Sequence[str]) -> str:
    """Return an error of a parameter with the option's name, where that is on the command line."""
    name, equals, rest = message.partition(" = ")
    option = f"--{name.replace('_', '-')}"
    is_typed = any(word.partition("=")[0] == option for word in words)
    return f"{option} {rest}" if equals and is_typed else message


def usage_message(error: CycloptsError) -> str:
    """Return an error of parsing in two lines: option, value and what is allowed; the help."""
    error.verbose = False
    message = " ".join(str(error).split())
    argument, token = error.argument, getattr(error, "token", None)
    if isinstance(error.__cause__, RequestError):
        message = str(error.__cause__)
    elif isinstance(error, UnusedCliTokensError):
        message = f"{' '.join(error.unused_tokens or ())!r}: is more than the command takes"
    elif isinstance(error, MissingArgumentError) and argument is not None:
        message = f"{argument.name}: must be given a value"
    elif isinstance(error, CoercionError) and argument is not None and token is not None:
        choices = argument.get_choices() or ()
        flag = bool in {argument.hint, *get_args(argument.hint)}
        allowed = f"one of {', '.join(choices)}" if choices else "a flag" if flag else "a number"
        message = f"{token.keyword or argument.name} {token.value!r}: must be {allowed}"
        for near in get_close_matches(token.value, choices, n=1):
            message += f"; did you mean {near}?"
    command = " ".join(["dem-harness", *(error.command_chain or ())])
    return f"{message}\nsee {command} --help"


app = App(
    name="dem-harness",
    help="""Check discrete element (DEM) codes against theory.

    The frictionless incline (critical angle 10.2078 deg), the tower hit by a dropped grain,
    contacts with friction and layers, in closed form, in solvers of this package and in DEM codes.

    Exit status: 0 all verdicts hold; 1 a verdict failed; 2 the request was
    wrong; 3 an engine could not be run, died or does not qualify; 4 internal error;
    130 interrupted; 143 terminated.
    """,
    version=f"dem-harness {__version__}",
    version_flags="--version",
    group_parameters=panel("Options"),
    default_parameter=Parameter(
        negative=(), converter=converted, allow_repeating=True, show_default=default_text
    ),
    help_format="markdown",
    suppress_keyboard_interrupt=False,
)

COMMANDS = """
    verify:verify publish:reproduce incline:theory incline:critical_angle tower:tower tower:impulse
    cases:cases cases:run sweep:sweep publish:inputs cases:engines releases:releases
    releases:upstream releases:defect baseline:diff publish:site cache:cache
    baseline:baseline
"""
"""Module and function of each command, in the order of the help; imported when it is run."""

for place, command in enumerate(COMMANDS.split()):
    app.command(f"harness.cli.{command}", sort_key=place)
app.register_install_completion_command()


@app.command(name="--show-completion")
def show_completion() -> int:
    """Show completion for the current shell, to copy it or customize the installation."""
    print(app.generate_completion())
    return 0
