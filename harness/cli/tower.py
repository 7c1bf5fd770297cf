"""``dem-harness tower``."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from harness.cli.cached_engines import Cache, Chosen, Fresh
from harness.cli.options import (
    Esys,
    Json,
    Kratos,
    Liggghts,
    Lmp,
    Mfix,
    Mpirun,
    Yade,
    programs_of,
)

if TYPE_CHECKING:
    from harness.engines.contract import Engine

MOST_SHOWN = 20
"""Entries of a list that the table shows; JSON has them all."""

# The names are spelled out here, not imported: --help must not wait for numba.


class Law(StrEnum):
    """Contact laws."""

    overlap = "overlap"
    deformable = "deformable"


class Base(StrEnum):
    """What the last particle does."""

    fixed = "fixed"
    free = "free"


class Window(StrEnum):
    """Windows of the impulse."""

    turnaround = "turnaround"
    structure = "structure"
    first_contact = "first-contact"


class Solver(StrEnum):
    """Solvers of the tower: the harness's own, then engines."""

    rk4 = "rk4"
    exact = "exact"
    lammps = "lammps"
    liggghts = "liggghts"
    yade = "yade"
    kratos = "kratos"
    esys = "esys"
    mfix = "mfix"

    @property
    def is_engine(self) -> bool:
        """Return whether it is an engine, which may have to be installed."""
        return self not in (Solver.rk4, Solver.exact)


def tower(
    height: Annotated[int, typer.Option(help="Contacts; particles - 1.")] = 1,
    stiffness: Annotated[float, typer.Option(help="Normal stiffness [N/m].")] = 1e6,
    mass: Annotated[float, typer.Option(help="Mass of each particle [kg].")] = 1.0,
    speed: Annotated[float, typer.Option(help="Speed of the grain at the start [m/s].")] = 2.0,
    gravity: Annotated[
        float, typer.Option(help="Gravity along the motion [m/s2]; 0 is the air hockey table.")
    ] = 9.81,
    law: Annotated[
        Law, typer.Option(help="Contact law: what DEM codes do, or the source's.")
    ] = Law.deformable,
    solver: Annotated[
        Solver,
        typer.Option(
            help="`rk4`: fixed steps of fourth order. `exact`: modes, without a step. "
            "`lammps`: the generated script; the deformable law in-process only. Other engines: "
            "the overlap law, where they are installed."
        ),
    ] = Solver.rk4,
    base: Annotated[Base, typer.Option(help="Whether the last particle moves.")] = Base.fixed,
    duration: Annotated[
        float, typer.Option(help="How long, in contact times t0 of grain and one fixed particle.")
    ] = 3.0,
    steps_per_contact: Annotated[
        float | None,
        typer.Option(help="Steps in pi sqrt(m/k).  [default: 4000 rk4, 1000 engines]"),
    ] = None,
    window: Annotated[
        Window, typer.Option(help="What the impulse is summed over.")
    ] = Window.turnaround,
    series: Annotated[
        Path | None, typer.Option(help="Write the series to this CSV file.", dir_okay=False)
    ] = None,
    lmp: Lmp = None,
    mpirun: Mpirun = None,
    liggghts: Liggghts = None,
    yade: Yade = None,
    kratos: Kratos = None,
    esys: Esys = None,
    mfix: Mfix = None,
    cache: Cache = None,
    fresh: Fresh = False,
    json: Json = False,
) -> None:
    """Drop a grain on a tower of particles: force, impulse and contacts of the grain.

    The tower stands on a fixed base, at rest and just touching; the grain
    arrives with its speed, gravity along the motion. Times are in t0, the time
    that the grain would stay on one fixed particle.
    """
    from harness.cases.tower.run import covering
    from harness.cases.tower.run import tower as run_tower
    from harness.cli.cached_engines import runs_made
    from harness.cli.files import check_target, write_all
    from harness.cli.history_records import tower_quantities
    from harness.cli.output import print_json
    from harness.cli.recording import recorded
    from harness.observables.summary import summary
    from harness.parameters.tower import Tower

    check_target(series, "--series")
    programs = programs_of(
        [solver.value],
        liggghts=liggghts,
        yade=yade,
        kratos=kratos,
        esys=esys,
        mfix=mfix,
        option="--solver",
    )
    case = Tower(
        height=height,
        stiffness=stiffness,
        mass=mass,
        speed=speed,
        gravity=gravity,
        law=law.value,
        base=base.value,
    )
    with (
        recorded("tower") as told,
        engine_of(solver, lmp, mpirun, cache, fresh, programs) as engine,
    ):
        run = run_tower(
            case,
            solver=solver.value,
            duration=duration,
            steps_per_contact=steps_per_contact,
            engine=engine,
        )
        record = summary(run, window.value, covering(run, window.value, engine))
        record |= runs_made(engine)
        told.engine, told.quantities = {**own_solver(solver), **record}, tower_quantities(record)
    if series is not None:
        write_all({("--series", series): lambda path: run.frame().to_csv(path, index=False)})
    if json:
        print_json(record)
    else:
        _print(record)


def engine_of(
    solver: Solver,
    lmp: str | None,
    mpirun: str | None,
    cache: Path | None,
    fresh: bool,
    programs: Mapping[str, str] | None = None,
) -> AbstractContextManager[Engine | None]:
    """Return the engine that is asked for, remembering its runs, to be closed after use.

    Raise RequestError for an executable of LAMMPS without it.
    """
    from harness.cli.cached_engines import open_cached_engine, open_entries
    from harness.errors import RequestError

    if (lmp or mpirun) and solver is not Solver.lammps:
        raise RequestError(f"--{'lmp' if lmp else 'mpirun'}: goes with --solver lammps only")
    if not solver.is_engine:
        return nullcontext()
    chosen = Chosen(solver.value, lmp, mpirun, programs=programs)
    return open_cached_engine(chosen, open_entries(cache), fresh)


def own_solver(solver: Solver) -> dict[str, str]:
    """Return what the history is told of a solver of the harness: it has the harness's version."""
    from harness import __version__

    return {"engine": solver.value, "engine_version": __version__, "how": "solver"}


def _print(record: dict[str, object]) -> None:
    """Print the summary as a table."""
    from rich.console import Console
    from rich.table import Table

    table = Table(show_header=False, box=None)
    for name, value in record.items():
        if isinstance(value, list):
            shown = " ".join(_short(item) for item in value[:MOST_SHOWN])
            value = shown + (f" ... ({len(value)} in all)" if len(value) > MOST_SHOWN else "")
        table.add_row(name, value if isinstance(value, str) else _short(value))
    Console().print(table)


def _short(value: object) -> str:
    if isinstance(value, list):
        return f"{value[1]} at {value[0]:.4g};"
    return f"{value:.8g}" if isinstance(value, float) else str(value)
