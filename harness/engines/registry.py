"""The engines that the harness knows, and how to open one by name."""

from __future__ import annotations

from collections.abc import Callable

from harness.engines.contract import Engine
from harness.engines.lammps.engine import Lammps
from harness.errors import RequestError

ENGINES: dict[str, Callable[..., Engine]] = {"lammps": Lammps}


def open_engine(
    name: str = "lammps", *, lmp: str | None = None, launcher: str | None = None
) -> Engine:
    """Return an engine, ready to run; close it after use.

    Raise RequestError for a name that is not known, EngineMissingError when it
    is not here.
    """
    if name not in ENGINES:
        raise RequestError(f"--engine {name!r} is not known: must be one of {', '.join(ENGINES)}")
    return ENGINES[name](lmp=lmp, launcher=launcher)
