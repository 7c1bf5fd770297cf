"""The engines: those of this package, those of others, how to open one by name, with which options.

Another package names its engines under the entry point ``dem_harness.engines``; ``module:Class`` is
an engine's name as well, for a try.
"""

from __future__ import annotations

import inspect
import shlex
import sys
from collections.abc import Iterable, Mapping
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from harness.engines.base import Engine
from harness.engines.process import Limits
from harness.engines.programs import find_program
from harness.errors import RequestError

ENGINES: dict[str, str] = {
    "lammps": "harness.engines.lammps.engine:Lammps",
    "reference": "harness.engines.reference:Reference",
    "liggghts": "harness.engines.liggghts.engine:Liggghts",
    "yade": "harness.engines.yade.engine:Yade",
    "kratos": "harness.engines.kratos.engine:Kratos",
    "mfix": "harness.engines.mfix.engine:Mfix",
}
"""Where each engine's class is. Imported when it is asked for: none pays for another's imports."""

DEFAULT = "lammps"
"""The engine that is verified unless another is named."""

GROUP = "dem_harness.engines"
"""The entry point under which other packages name their engines."""

SPELLED = {"lmp": "--lmp", "launcher": "--mpirun", "integrator": "--integrator"}
"""Options that the command line has a word of its own for."""


def engine_names() -> list[str]:
    """Return the names of all engines, those of this package first; nothing is imported."""
    return [*ENGINES, *sorted(_plugins()[0])]


def refused_plugins() -> tuple[str, ...]:
    """Return one line for each engine of another package that is not listed."""
    return tuple(_plugins()[1])


def engine_class(name: str) -> type[Engine]:
    """Return the class of an engine, whose code need not be here.

    Raise RequestError for a name that is not known, or an engine of another package that cannot
    be imported or is none.
    """
    if name in ENGINES:
        engine: type[Engine] = _named(ENGINES[name])
        return engine
    plugin = _plugins()[0].get(name)
    if plugin is not None:
        return _class_at(plugin.value, f"engine {name!r} of package {_package(plugin)!r}")
    if ":" in name:
        if str(Path.cwd()) not in sys.path:
            sys.path.append(str(Path.cwd()))
        return _class_at(name, f"--engine {name!r}")
    raise RequestError(
        f"--engine {name!r} is not known: must be one of {', '.join(engine_names())}, "
        "or module:Class"
    )


def check_known(names: Iterable[str], option: str) -> None:
    """Raise RequestError for a name of no engine; ``option`` is the option that has it."""
    known = engine_names()
    for name in names:
        if name not in known and ":" not in name:
            raise RequestError(
                f"{option} {name}: is not known: must be one of {', '.join(known)}, or module:Class"
            )


def engine_title(name: str) -> str:
    """Return what tables and figures call an engine; any other name as it is."""
    if name not in engine_names() and ":" not in name:
        return name
    return engine_class(name).traits.title or name.upper()


def open_engine(
    name: str = DEFAULT,
    *,
    program: str | None = None,
    options: Mapping[str, Any] | None = None,
    **more: str | None,
) -> Engine:
    """Return an engine, ready to run; close it after use.

    ``program`` is its executable; ``options`` are the keyword arguments of its class, as text or as
    they are, and so are ``more`` that are not None (``lmp``, ``launcher``, ``integrator``).

    Raise RequestError for a name that is not known or an option that the engine does not take,
    EngineMissingError when the engine is not here.
    """
    return engine_class(name)(**chosen_options(name, program, options, **more))


def chosen_options(
    name: str,
    program: str | None = None,
    options: Mapping[str, Any] | None = None,
    **more: str | None,
) -> dict[str, Any]:
    """Return the arguments of an engine's class, checked; takes what ``open_engine`` takes."""
    values = {**(options or {}), **more, "program": program}
    values = {key: value for key, value in values.items() if value is not None}
    if not values:
        return {}
    kind = engine_class(name)
    taken = {key: hint for key, hint in _hints(kind).items() if key not in ("self", "return")}
    for key, value in values.items():
        if key not in taken:
            spelled = "--program" if key == "program" else SPELLED.get(key)
            option = f"{spelled} {value!r}" if spelled else f"--engine-option {name}.{key}={value}"
            allowed = ", ".join(sorted(taken)) or "none"
            raise RequestError(f"{option}: engine {name!r} takes the options: {allowed}")
    return {key: _read(f"{name}.{key}", value, taken[key]) for key, value in values.items()}


def fingerprint_of(name: str, options: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return what identifies an engine and its twin by content, or None where that is not known.

    Nothing is opened. ``options`` are those of its class. Raise RequestError for a program that
    is not there.
    """
    kind = engine_class(name)
    identity, twin = kind.fingerprint_of(**options), kind.twin_options(**options)
    if identity is None or twin is None:
        return identity
    try:
        other = kind.fingerprint_of(**twin)
    except RequestError:
        other = {"how": "missing"}
    return None if other is None else {**identity, "twin": other}


@cache
def _plugins() -> tuple[dict[str, EntryPoint], list[str]]:
    """Return the engines of other packages by name, and why others are refused."""
    points: dict[str, EntryPoint] = {}
    refused: list[str] = []
    for point in entry_points(group=GROUP):
        package = _package(point)
        other = "this package" if point.name in ENGINES else ""
        if point.name in points:
            other = f"package {_package(points[point.name])!r}"
        if other:
            refused.append(
                f"engine {point.name!r} of package {package!r} is left out: {other} has one of "
                "that name"
            )
        else:
            points[point.name] = point
    return points, refused


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist is not None else point.value.partition(":")[0]


def _class_at(where: str, label: str) -> type[Engine]:
    """Return the engine's class at ``module:Class``; raise RequestError for anything else."""
    try:
        kind = _named(where)
    except (Exception, SystemExit) as error:
        reason = (str(error).splitlines() or [""])[0]
        raise RequestError(
            f"{label} cannot be imported from {where!r} ({type(error).__name__}: {reason})"
        ) from None
    if not (isinstance(kind, type) and issubclass(kind, Engine)):
        raise RequestError(f"{label}: {where!r} is no subclass of harness.engines.base.Engine")
    lacks = sorted(kind.__abstractmethods__)
    lacks += [name for name in ("name", "traits") if not hasattr(kind, name)]
    if lacks:
        raise RequestError(f"{label}: class {kind.__name__} has no {', '.join(lacks)}")
    return kind


def _named(where: str) -> Any:
    module, _, name = where.partition(":")
    return getattr(import_module(module), name)


def _hints(kind: type[Engine]) -> dict[str, Any]:
    return get_type_hints(inspect.unwrap(kind.__init__))


def _read(option: str, value: Any, hint: Any) -> Any:
    """Return an option's value as the type it is declared with; raise RequestError if it is not."""
    kinds = get_args(hint) if get_origin(hint) is not Literal else (hint,)
    for kind in [kind for kind in kinds or (hint,) if kind is not type(None)]:
        if get_origin(kind) is Literal:
            if value in get_args(kind):
                return value
            must = f"one of {', '.join(map(str, get_args(kind)))}"
        elif not isinstance(value, str) or kind is str:
            return value
        elif kind in _READERS:
            try:
                return _READERS[kind](value)
            except ValueError:
                must = _MUST[kind]
        else:
            return value
    raise RequestError(f"--engine-option {option}={value}: must be {must}")


def _limits(text: str) -> Limits:
    """Return limits with the seconds that any run may take; raise ValueError for a bad number."""
    seconds = float(text)
    if not 0.0 < seconds <= MOST_LIMIT:
        raise ValueError
    return Limits(seconds=seconds, patience=0.0)


MOST_LIMIT = 1e7
"""[s] that a run may be given; what waits for one takes no more than 300 years."""

_READERS: dict[Any, Any] = {int: int, float: float, Limits: _limits}
"""How options are read from text; of limits, the seconds that a run may take."""

_MUST = {
    int: "a whole number",
    float: "a number",
    Limits: f"a number of seconds greater than 0 and at most {MOST_LIMIT:g}",
}


# ---- options as they are typed: pairs as NAME=VALUE, and whose each one is


def named_values(texts: Iterable[str], option: str) -> dict[str, str]:
    """Return the pairs of ``NAME=VALUE``; raise RequestError for what is none, or comes twice."""
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise RequestError(f"{option} {text!r}: must be NAME=VALUE")
        if name in values:
            raise RequestError(f"{option} {text!r}: {name} is given twice")
        values[name] = value
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
