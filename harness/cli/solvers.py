"""The option ``--solver``: a solver of the harness, or an engine."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from harness.cli.engine_options import ProgramOptions
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.engines.contract import Engine

OWN = ("rk4", "exact")
"""Solvers of the harness, spelled out: --help must not wait for numba."""


@dataclass(frozen=True)
class SolverOptions(ProgramOptions):
    """What runs the towers."""

    solver: str = "rk4"

    @property
    def own(self) -> str | None:
        """Return the solver of the harness that is asked for, None for an engine."""
        return self.solver if self.solver in OWN else None

    @contextmanager
    def run(self) -> Iterator[Engine | None]:
        """Yield the engine that is asked for; None for a solver of the harness.

        Raise RequestError for a name that is not known, and for options of another engine.
        """
        from harness.engines.registry import engine_class

        for name, value in (("--lmp", self.lmp), ("--mpirun", self.mpirun)):
            if value is not None and self.solver != "lammps":
                raise RequestError(f"{name} {value!r}: goes with --solver lammps only")
        self.check_names({self.solver} - set(OWN), "--solver")
        if self.own:
            yield None
            return
        try:
            engine_class(self.solver)
        except RequestError as error:
            text = str(error).replace("--engine", "--solver", 1)
            raise RequestError(f"{text}; or a solver of the harness: {', '.join(OWN)}") from None
        with self.open(self.solver) as engine:
            yield engine

    @property
    def own_record(self) -> dict[str, str]:
        """Return what the history is told of a solver of the harness, which has its version."""
        from harness import __version__

        return {"engine": self.solver, "engine_version": __version__, "how": "solver"}
