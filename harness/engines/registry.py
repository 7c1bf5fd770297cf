"""The engines that the harness knows, and how to open one by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from harness.engines.contract import Engine
from harness.errors import RequestError

Options = Mapping[str, str]


def _lammps(options: Options) -> Engine:
    from harness.engines.lammps.engine import Lammps

    return Lammps(lmp=options.get("lmp"), launcher=options.get("launcher"))


def _reference(options: Options) -> Engine:
    from harness.engines.reference.engine import DEFAULT_INTEGRATOR, Reference

    return Reference(options.get("integrator", DEFAULT_INTEGRATOR))


ENGINES: dict[str, Callable[[Options], Engine]] = {
    "lammps": _lammps,
    "reference": _reference,
}
"""Opened when they are asked for: none pays for the imports of another."""

OPTIONS = {
    "lmp": ("--lmp", "lammps"),
    "launcher": ("--mpirun", "lammps"),
    "integrator": ("--integrator", "reference"),
}
"""How the command line calls an option, and whose it is."""


def open_engine(
    name: str = "lammps",
    *,
    lmp: str | None = None,
    launcher: str | None = None,
    integrator: str | None = None,
) -> Engine:
    """Return an engine, ready to run; close it after use.

    ``lmp`` and ``launcher`` are LAMMPS's, ``integrator`` is the reference
    DEM's. Raise RequestError for a name that is not known or an option of
    another engine, EngineMissingError when the engine is not here.
    """
    if name not in ENGINES:
        raise RequestError(f"--engine {name!r} is not known: must be one of {', '.join(ENGINES)}")
    values = {"lmp": lmp, "launcher": launcher, "integrator": integrator}
    given = {key: value for key, value in values.items() if value is not None}
    for key, value in given.items():
        option, owner = OPTIONS[key]
        if owner != name:
            raise RequestError(
                f"{option} {value!r} is an option of --engine {owner}, not of {name!r}"
            )
    return ENGINES[name](given)
