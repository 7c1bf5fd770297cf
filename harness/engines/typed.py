"""Options of engines as they are typed: pairs as ``NAME=VALUE``, and whose each one is."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Mapping
from typing import Any

from harness.engines.programs import find_program
from harness.errors import RequestError


def named_values(texts: Iterable[str], option: str) -> dict[str, str]:
    """Return the pairs of ``NAME=VALUE``; raise RequestError for what is none, or comes twice."""
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (name.strip() and equals and value):
            raise RequestError(f"{option} {text!r}: must be NAME=VALUE")
        if name.strip() in values:
            raise RequestError(f"{option} {text!r}: {name.strip()} is given twice")
        values[name.strip()] = value
    return values


def engine_settings(texts: Iterable[str]) -> dict[str, dict[str, str]]:
    """Return the options of each engine's class, by its name and theirs."""
    settings: dict[str, dict[str, str]] = {}
    for name, value in named_values(texts, "--engine-option").items():
        engine, dot, key = name.rpartition(".")
        if not (engine and dot and key.isidentifier()):
            raise RequestError(f"--engine-option '{name}={value}': must be NAME.KEY=VALUE")
        settings.setdefault(engine, {})[key] = value
    return settings


def check_names(
    programs: Mapping[str, str],
    settings: Mapping[str, Any],
    engines: Iterable[str],
    option: str = "--engine",
) -> None:
    """Raise RequestError for a program or option whose engine does not run.

    ``programs`` and ``settings`` are by the engines' names, ``engines`` are those that will run,
    ``option`` is the option that names them.
    """
    names = set(engines)
    for name, path in programs.items():
        if name not in names:
            raise RequestError(f"--program {name}={path}: goes with {option} {name} only")
        find_program(f"program {name}", path)
    for name in settings:
        if name not in names:
            raise RequestError(f"--engine-option {name}: goes with {option} {name} only")


def check_launcher(command: str | None) -> None:
    """Raise RequestError for a launcher of MPI that has no words, or cannot be split into them."""
    try:
        empty = command is not None and not shlex.split(command)
    except ValueError as error:
        raise RequestError(f"--mpirun {command!r}: {str(error).lower()}") from None
    if empty:
        raise RequestError(f"--mpirun {command!r}: must be a command, as in 'mpirun -np 4'")
