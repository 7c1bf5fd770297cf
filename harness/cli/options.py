"""Options that several commands share."""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

Json = Annotated[
    bool, typer.Option("--json", help="Print one JSON object on stdout, and nothing else.")
]

EngineName = Annotated[
    str,
    typer.Option(
        "--engine",
        help="The engine to run. `lammps`; `reference`, the harness's own DEM of the incline; "
        "`liggghts`, `yade`, `kratos`, `esys` or `mfix`, where they are installed.",
        rich_help_panel="Engine",
    ),
]

Integrator = Annotated[
    str | None,
    typer.Option(
        "--integrator",
        help="Of the reference engine. `velocity-verlet`: as LAMMPS. `mfix-euler`, "
        "`mfix-adams-bashforth`: as MFiX-DEM (with --half-mass). `rk4`: fourth order. `adaptive`: "
        "high order, contact changes located; has no step, --steps-per-contact is ignored.  "
        "[default: velocity-verlet]",
        rich_help_panel="Engine",
    ),
]

Lmp = Annotated[
    str | None,
    typer.Option(
        "--lmp",
        metavar="PATH",
        help="A LAMMPS executable of your own. Without it, LAMMPS runs in-process.",
        rich_help_panel="Engine",
    ),
]

Mpirun = Annotated[
    str | None,
    typer.Option(
        "--mpirun",
        metavar="COMMAND",
        help='An MPI launcher with its options, as in `--mpirun "mpirun -np 4"`.',
        rich_help_panel="Engine",
    ),
]

_OTHER = "Other engines"

Liggghts = Annotated[
    str | None,
    typer.Option(
        "--liggghts",
        metavar="PATH",
        help="A LIGGGHTS executable of your own.",
        rich_help_panel=_OTHER,
    ),
]

Yade = Annotated[
    str | None,
    typer.Option(
        "--yade", metavar="PATH", help="A Yade executable of your own.", rich_help_panel=_OTHER
    ),
]

Kratos = Annotated[
    str | None,
    typer.Option(
        "--kratos",
        metavar="PYTHON",
        help="A Python that has KratosDEMApplication.",
        rich_help_panel=_OTHER,
    ),
]

Esys = Annotated[
    str | None,
    typer.Option(
        "--esys",
        metavar="PATH",
        help="An ESyS-Particle executable of your own.",
        rich_help_panel=_OTHER,
    ),
]

Mfix = Annotated[
    str | None,
    typer.Option(
        "--mfix",
        metavar="PATH",
        help="The MFiX solver that you built; without it, MFiX is what was recorded.",
        rich_help_panel=_OTHER,
    ),
]


def programs_of(
    asked: Iterable[str] | None,
    *,
    liggghts: str | None,
    yade: str | None,
    kratos: str | None,
    esys: str | None,
    mfix: str | None,
    option: str = "--engine",
    must_be_here: bool = True,
) -> dict[str, str]:
    """Return the programs that were given, by the engine's name.

    ``asked`` are the engines that will run, None for all; ``option`` is how one is asked
    for. Raise RequestError for a program whose engine is not asked for, and unless
    ``must_be_here`` is false for one that is not there.
    """
    from harness.engines.programs import find_program
    from harness.errors import RequestError

    given = {"liggghts": liggghts, "yade": yade, "kratos": kratos, "esys": esys, "mfix": mfix}
    programs = {name: program for name, program in given.items() if program is not None}
    chosen = None if asked is None else set(asked)
    for name, program in programs.items():
        if chosen is not None and name not in chosen:
            raise RequestError(f"--{name} {program!r}: goes with {option} {name} only")
        if must_be_here:
            find_program(name, program)
    return programs


Tolerances = Annotated[
    Path | None,
    typer.Option(
        "--tolerances",
        metavar="FILE",
        help="Named overrides of the regression tolerances, TOML.  "
        "[default: inputs/tolerances.toml]",
    ),
]


class Method(StrEnum):
    """The two routes to the critical angle."""

    PASSAGE = "passage"
    STEADY = "steady"


class Reading(StrEnum):
    """The two readings of the source's shock."""

    KEPT = "kept"
    LOST = "lost"


class ContactName(StrEnum):
    """The contacts that have a name."""

    SOURCE = "source"
    CLIPPED = "clipped"
    PLASTIC = "plastic"
