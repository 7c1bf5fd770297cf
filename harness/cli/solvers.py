"""The option ``--solver``: a solver of the harness, or an engine."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import typer

from harness.cli.engine_options import ProgramOptions

if TYPE_CHECKING:
    from harness.engines.contract import Engine

OWN = ("rk4", "exact")
"""Solvers of the harness, spelled out: --help must not wait for numba."""


@dataclass(frozen=True)
class SolverOptions(ProgramOptions):
    """What runs the towers."""

    solver: Annotated[
        str,
        typer.Option(
            "--solver",
            metavar="NAME",
            help="`rk4`: fixed steps of fourth order. `exact`: modes, without a step. Or an "
            "engine that `dem-harness engines` lists, or `module:Class`: the overlap law; the "
            "deformable one in LAMMPS in-process.",
        ),
    ] = "rk4"

    def run(self) -> AbstractContextManager[Engine | None]:
        """Return the engine that is asked for, to be entered; None for a solver of the harness.

        Raise RequestError for a name that is not known, and for options of another engine.
        """
        from harness.engines.registry import engine_class
        from harness.errors import RequestError

        for option, value in (("--lmp", self.lmp), ("--mpirun", self.mpirun)):
            if value is not None and self.solver != "lammps":
                raise RequestError(f"{option} {value!r}: goes with --solver lammps only")
        self.check_names({self.solver} - set(OWN), "--solver")
        if self.solver in OWN:
            return nullcontext()
        try:
            engine_class(self.solver)
        except RequestError as error:
            own = ", ".join(OWN)
            text = str(error).replace("--engine", "--solver", 1)
            raise RequestError(f"{text}; or a solver of the harness: {own}") from None
        return self.open(self.solver)

    @property
    def own_record(self) -> dict[str, str]:
        """Return what the history is told of a solver of the harness, which has its version."""
        from harness import __version__

        return {"engine": self.solver, "engine_version": __version__, "how": "solver"}
