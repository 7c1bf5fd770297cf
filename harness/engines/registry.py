"""Names of engines, of their options and of programs: what they open.

Another package names its engines under the entry point ``dem_harness.engines``; ``module:Class`` is
an engine's name as well, for a try.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Annotated, Any, get_args, get_type_hints

from harness.engines.base import ContractError, Engine, contract
from harness.engines.process import LONGEST_SECONDS, Limits
from harness.errors import EngineMissingError, RequestError

ENGINES: dict[str, str] = {  # imported when one is opened: none pays for another's imports
    "lammps": "harness.engines.lammps.engine:Lammps",
    "reference": "harness.engines.reference:Reference",
    "liggghts": "harness.engines.liggghts.engine:Liggghts",
    "yade": "harness.engines.yade.engine:Yade",
    "kratos": "harness.engines.kratos.engine:Kratos",
    "mfix": "harness.engines.mfix.engine:Mfix",
}
DEFAULT = "lammps"  # the engine that is verified unless another is named
GROUP = "dem_harness.engines"
LOADER_SECONDS = 10.0
# variables that decide which code runs, and likewise in a program that imports modules
ENVIRONMENT = ("LD_LIBRARY_PATH", "LD_PRELOAD", "DYLD_LIBRARY_PATH")
OF_PYTHON = (*ENVIRONMENT, "PYTHONPATH", "PYTHONHOME", "PYTHONUSERBASE")


# ---- engines by name


def engine_names() -> list[str]:
    """Return the names of all engines, those of this package first; nothing is imported."""
    return [*ENGINES, *sorted(_plugins())]


def engine_class(name: str) -> type[Engine]:
    """Return the class of an engine, whose code need not be installed.

    Raise RequestError for an unknown name, or a ``module:Class`` that cannot be imported or is
    none; EngineMissingError for such an engine of another package.
    """
    if name in ENGINES:
        return _class_at(ENGINES[name], f"engine {name!r}")
    if plugin := _plugins().get(name):
        package = plugin.dist.name if plugin.dist else plugin.value.partition(":")[0]
        try:
            return _class_at(plugin.value, f"engine {name!r} of package {package!r}")
        except RequestError as error:  # the request is right, the package is not
            raise EngineMissingError(str(error)) from None
    _check_name(name, f"--engine {name!r}")
    if str(Path.cwd()) not in sys.path:
        sys.path.append(str(Path.cwd()))
    return _class_at(name, f"--engine {name!r}")


def engine_title(name: str) -> str:
    """Return the name of an engine in tables and figures; any other name as it is."""
    with suppress(RequestError, EngineMissingError):
        return engine_class(name).traits.title or name.upper()
    return name


def open_engine(
    name: str = DEFAULT, *, options: Mapping[str, Any] | None = None, **more: Any
) -> Engine:
    """Return an engine, ready to run; close it after use.

    ``options`` and ``more`` are the keyword arguments of its class, as text or as they are; those
    that are None are omitted. ``program`` is the executable of an engine that has one.

    Raise RequestError for an unknown name or an option that the engine does not take,
    EngineMissingError when the engine is not installed or its package is broken, ContractError for
    any other exception of a class of another package.
    """
    chosen = chosen_options(name, {**(options or {}), **more})
    kind = engine_class(name)
    with contract(kind, "__init__"):
        return kind(**chosen)


def fingerprint_of(name: str, options: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Return the identity of an engine by content, None where it is missing or not known.

    ``options`` are those of its class. Raise RequestError for a program that is not there.
    """
    try:
        with open_engine(name, options=options) as engine:
            return engine.fingerprint()
    except (EngineMissingError, ContractError):
        return None


@cache
def _plugins() -> dict[str, EntryPoint]:
    """Return the engines of other packages by name, the first of a name.

    Those of this package keep their names.
    """
    points = {point.name: point for point in reversed(list(entry_points(group=GROUP)))}
    return {name: point for name, point in points.items() if name not in ENGINES}


def _class_at(where: str, label: str) -> type[Engine]:
    """Return the engine's class at ``module:Class``; raise RequestError for anything else."""
    module, _, name = where.partition(":")
    try:
        kind = getattr(import_module(module), name)
    except (Exception, SystemExit) as error:
        reason = (str(error).splitlines() or [""])[0]
        raise RequestError(
            f"{label} cannot be imported from {where!r} ({type(error).__name__}: {reason})"
        ) from None
    if not (isinstance(kind, type) and issubclass(kind, Engine)):
        raise RequestError(f"{label}: {where!r} is no subclass of harness.engines.base.Engine")
    missing = sorted(kind.__abstractmethods__)
    missing += [name for name in ("name", "traits") if not hasattr(kind, name)]
    if missing:
        raise RequestError(f"{label}: class {kind.__name__} has no {', '.join(missing)}")
    return kind


def _check_name(name: str, label: str) -> None:
    """Raise RequestError for the name of no engine."""
    if name not in engine_names() and ":" not in str(name):
        names = ", ".join(engine_names())
        raise RequestError(f"{label} is not known: must be one of {names}, or module:Class")


# ---- options of an engine's class


def chosen_options(
    name: str, options: Mapping[str, Any], own_words: Mapping[str, str] | None = None
) -> dict[str, Any]:
    """Return the arguments of an engine's class, read from text as their types, without None.

    ``own_words`` are the words by which errors name options, where those have one of their own.
    """
    values = {key: value for key, value in options.items() if value is not None}
    if not values:
        return {}
    hints = get_type_hints(inspect.unwrap(engine_class(name).__init__))
    hints.pop("return", None)
    for key, value in values.items():
        word = f"--program {name}" if key == "program" else f"--engine-option {name}.{key}"
        if key not in hints:
            allowed = ", ".join(sorted(hints)) or "none"
            raise RequestError(f"{word}={value}: engine {name!r} takes the options: {allowed}")
        if isinstance(value, str):
            own_word = (own_words or {}).get(key)
            label = f"{own_word} {value!r}" if own_word else f"{word}={value}"
            values[key] = _read(label, value, hints[key])
    return values


def _read(option: str, text: str, kind: Any) -> Any:
    """Return the value of an option from its text; raise RequestError for a wrong one.

    Limits are the seconds that any run may take.
    """
    from pydantic import ConfigDict, Field, TypeAdapter, ValidationError

    is_limits = Limits in (kind, *get_args(kind))
    if is_limits:
        kind = Annotated[float, Field(gt=0.0, le=LONGEST_SECONDS, allow_inf_nan=False)]
    reader: TypeAdapter[Any] = TypeAdapter(kind, config=ConfigDict(arbitrary_types_allowed=True))
    try:
        value = reader.validate_python(text)
    except ValidationError as error:
        reason = str(error.errors()[0]["msg"]).removeprefix("Input should be ")
        raise RequestError(f"{option}: must be {reason}") from None
    return Limits(seconds=value, patience=0.0) if is_limits else value


# ---- options as they are typed: pairs as NAME=VALUE, each of an engine


def named_values(texts: Iterable[str], option: str) -> dict[str, str]:
    """Return the pairs of ``NAME=VALUE``; raise RequestError for another form, or a name twice."""
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


def check_options(
    programs: Mapping[str, str],
    settings: Mapping[str, Any],
    engines: Collection[str],
    option: str = "--engine",
) -> None:
    """Raise RequestError for a program or option of an engine that is unknown or does not run.

    ``programs`` and ``settings`` are by the engines' names, ``engines`` are those that will run,
    ``option`` is the option that names them.
    """
    words = {name: f"--engine-option {name}" for name in settings}
    words |= {name: f"--program {name}={path}" for name, path in programs.items()}
    for name, word in words.items():
        _check_name(name, f"{word}:")
        if name not in engines:
            raise RequestError(f"{word}: goes with {option} {name} only")
    for name, path in programs.items():
        find_program(f"program {name}", path)


# ---- programs by name


def find_program(option: str, name: str) -> str:
    """Return the absolute path of a program, on PATH or next to this Python.

    Raise RequestError naming the option, such as ``lmp`` or ``program NAME=``.
    """
    path = shutil.which(name) or shutil.which(name, path=str(Path(sys.executable).parent))
    if path is None:
        option += "" if option.endswith("=") else " "
        raise RequestError(
            f"--{option}{name!r}: no such executable; give a path, or a name found on PATH"
        )
    return str(Path(path).absolute())


def program_of_python(name: str) -> str:
    """Return the path of a program next to this Python, else its name, to be found on PATH."""
    path = Path(sys.executable).with_name(name)
    return str(path) if path.exists() else name


def program_words(option: str, command: str) -> list[str]:
    """Return the words of a command: the absolute path of its program, then its arguments.

    A file that exists, or a name on PATH, is taken whole, blanks included. Raise RequestError for
    a command that cannot be split into words, or whose program is not there.
    """
    with suppress(RequestError):
        return [find_program(option, command)]
    try:
        program, *arguments = shlex.split(command) or [""]
    except ValueError as error:
        raise RequestError(f"--{option} {command!r} cannot be read: {error}") from None
    return [find_program(option, program), *arguments]


# ---- programs by content


def facts(
    engine: str,
    how: str,
    files: Sequence[Path],
    environment: Sequence[str] = ENVIRONMENT,
    options: Mapping[str, str] | None = None,
) -> dict[str, Any]:
    """Return the identity of an engine, JSON-ready, by the contents of its files, program first.

    ``options`` are those of the engine that no job has and that decide a result.
    """
    return {
        "engine": engine,
        "how": how,
        "program": str(files[0]),
        "files": sorted({f"{digest(path)} {path.name}" for path in files}),
        "options": dict(options or {}),
        "environment": {name: os.environ[name] for name in environment if name in os.environ},
    }


def tree_files(folder: Path) -> list[Path]:
    """Return the files below a folder, in order, but for byte code, which follows from them."""
    paths = (path for path in folder.rglob("*") if "__pycache__" not in path.parts)
    return sorted(path for path in paths if path.is_file())


def program_files(program: Path) -> list[Path]:
    """Return a program and all that the loader gives it; nothing for a script."""
    with program.open("rb") as stream:
        if stream.read(2) == b"#!":
            return []
    libraries = with_libraries(program.resolve())
    return [program, *libraries] if libraries else []


@cache  # the fingerprint of an engine is needed with every batch of runs
def with_libraries(program: Path, *more: Path) -> list[Path]:
    """Return a program or library, what the loader gives it, and ``more``; nothing on failure."""
    done = ask_program(["ldd", str(program)], LOADER_SECONDS)
    if done is None or (
        done.returncode and "not a dynamic executable" not in done.stderr + done.stdout
    ):
        return []
    # as in "libm.so.6 => /lib/libm.so.6 (0x7f...)"
    lines = [line.split() for line in done.stdout.splitlines()]
    paths = [Path(next((w for w in words if w.startswith("/")), "")) for words in lines]
    return [program, *(path for path in paths if path.is_file()), *more]


def ask_program(words: Sequence[str], seconds: float) -> subprocess.CompletedProcess[str] | None:
    """Return the output and exit status of a program within so many seconds of wall time.

    None where it cannot be started or takes longer. It has no input.
    """
    with suppress(OSError, subprocess.TimeoutExpired):
        return subprocess.run(  # surrogates as in the names of files
            words, stdin=subprocess.DEVNULL, capture_output=True, text=True,
            errors="surrogateescape", timeout=seconds, check=False,
        )  # fmt: skip
    return None


@cache
def digest(path: Path) -> str:
    """Return the BLAKE2 digest of a file, half the time of SHA-256 for 40 MB of library."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, lambda: hashlib.blake2b(digest_size=32)).hexdigest()
