"""Options that several commands share."""

from __future__ import annotations

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
        help="The engine to run. `lammps`, or `reference`: the harness's own DEM of the incline.",
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
