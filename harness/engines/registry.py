"""The engines that the harness knows, and how to open one by name."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

from harness.engines.contract import Engine
from harness.errors import RequestError

ENGINES: dict[str, str] = {
    "lammps": "harness.engines.lammps.engine:Lammps",
    "reference": "harness.engines.reference.engine:Reference",
    "liggghts": "harness.engines.liggghts.engine:Liggghts",
    "yade": "harness.engines.yade.engine:Yade",
    "kratos": "harness.engines.kratos.engine:Kratos",
    "esys": "harness.engines.esys.engine:Esys",
    "mfix": "harness.engines.mfix.engine:Mfix",
}
"""Where each engine's class is. Imported when it is asked for: none pays for another's imports."""

INPUTS: dict[str, str] = {
    "lammps": "harness.engines.lammps.scripts:input_files",
    "liggghts": "harness.engines.liggghts.scripts:input_files",
    "yade": "harness.engines.yade.scripts:input_files",
    "kratos": "harness.engines.kratos.scripts:input_files",
    "esys": "harness.engines.esys.scripts:input_files",
    "mfix": "harness.engines.mfix.scripts:input_files",
}
"""Where each engine's generated inputs are made: texts by their names below ``inputs``."""

OPTIONS = {
    "lmp": ("--lmp", "lammps"),
    "launcher": ("--mpirun", "lammps"),
    "integrator": ("--integrator", "reference"),
}
"""How the command line calls an option of an engine's class, and whose it is."""


def engine_class(name: str) -> type[Engine]:
    """Return the class of an engine, which need not be here; raise RequestError for no engine."""
    if name not in ENGINES:
        raise RequestError(f"--engine {name!r} is not known: must be one of {', '.join(ENGINES)}")
    found: type[Engine] = _named(ENGINES[name])
    return found


def open_engine(
    name: str = "lammps",
    *,
    lmp: str | None = None,
    launcher: str | None = None,
    integrator: str | None = None,
    programs: Mapping[str, str] | None = None,
) -> Engine:
    """Return an engine, ready to run; close it after use.

    ``lmp`` and ``launcher`` are LAMMPS's, ``integrator`` is the reference
    DEM's; ``programs`` are executables of other engines by the engine's name, of which only
    this one's is used. Raise RequestError for a name that is not known or an option of
    another engine, EngineMissingError when the engine is not here.
    """
    kind = engine_class(name)
    values = {"lmp": lmp, "launcher": launcher, "integrator": integrator}
    given = {key: value for key, value in values.items() if value is not None}
    for key, value in given.items():
        option, owner = OPTIONS[key]
        if owner != name:
            raise RequestError(
                f"{option} {value!r} is an option of --engine {owner}, not of {name!r}"
            )
    if programs and name in programs:
        given["program"] = programs[name]
    return kind(**given)


def input_files(*engines: str) -> dict[str, str]:
    """Return the generated inputs of some engines, or of all, by their names below ``inputs``."""
    some = [INPUTS[name] for name in engines or INPUTS if name in INPUTS]
    return {path: text for where in some for path, text in _named(where)().items()}


def _named(where: str) -> Any:
    module, _, name = where.partition(":")
    return getattr(import_module(module), name)
