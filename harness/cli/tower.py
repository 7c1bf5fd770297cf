"""``dem-harness tower``."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from harness.cli.options import Json
from harness.cli.solvers import OWN, SolverOptions

if TYPE_CHECKING:
    from harness.parameters.tower import Tower

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


@dataclass(frozen=True)
class SystemOptions:
    """The tower and the grain."""

    height: Annotated[int, typer.Option(help="Contacts; particles - 1.")] = 1
    stiffness: Annotated[float, typer.Option(help="Normal stiffness [N/m].")] = 1e6
    mass: Annotated[float, typer.Option(help="Mass of each particle [kg].")] = 1.0
    speed: Annotated[float, typer.Option(help="Speed of the grain at the start [m/s].")] = 2.0
    gravity: Annotated[
        float, typer.Option(help="Gravity along the motion [m/s2]; 0 is the air hockey table.")
    ] = 9.81
    law: Annotated[Law, typer.Option(help="Contact law: what DEM codes do, or the source's.")] = (
        Law.deformable
    )
    base: Annotated[Base, typer.Option(help="Whether the last particle moves.")] = Base.fixed

    def tower(self) -> Tower:
        """Return the parameters; raise RequestError for values out of range."""
        from harness.parameters.tower import Tower

        return Tower(
            height=self.height,
            stiffness=self.stiffness,
            mass=self.mass,
            speed=self.speed,
            gravity=self.gravity,
            law=self.law.value,
            base=self.base.value,
        )


@dataclass(frozen=True)
class RunOptions:
    """How long, how finely, and what is kept of it."""

    duration: Annotated[
        float, typer.Option(help="How long, in contact times t0 of grain and one fixed particle.")
    ] = 3.0
    steps_per_contact: Annotated[
        float | None,
        typer.Option(help="Steps in pi sqrt(m/k).  [default: 4000 rk4, 1000 engines]"),
    ] = None
    window: Annotated[Window, typer.Option(help="What the impulse is summed over.")] = (
        Window.turnaround
    )
    series: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the series to this CSV file.", dir_okay=False),
    ] = None


def tower(
    system: SystemOptions, run: RunOptions, solver: SolverOptions, json: Json = False
) -> None:
    """Drop a grain on a tower of particles: force, impulse and contacts of the grain.

    The tower stands on a fixed base, at rest and just touching; the grain
    arrives with its speed, gravity along the motion. Times are in t0, the time
    that the grain would stay on one fixed particle.
    """
    from harness.cases.tower.run import covering
    from harness.cases.tower.run import tower as run_tower
    from harness.cli.engine_options import runs_made
    from harness.cli.files import check_target, write_all
    from harness.cli.history_records import tower_quantities
    from harness.cli.output import print_json
    from harness.cli.qualified import end_unqualified, qualification
    from harness.cli.recording import recorded
    from harness.observables.summary import summary

    check_target(run.series, "--series")
    case = system.tower()
    with recorded("tower") as told, solver.run() as engine:
        found = run_tower(
            case,
            solver=solver.solver if solver.solver in OWN else None,
            duration=run.duration,
            steps_per_contact=run.steps_per_contact,
            engine=engine,
        )
        record = summary(found, run.window.value, covering(found, run.window.value, engine))
        record |= qualification(engine, told)
        record |= runs_made(engine)
        told.engine, told.quantities = {**solver.own_record, **record}, tower_quantities(record)
    if run.series is not None:
        write_all({("--series", run.series): lambda path: found.frame().to_csv(path, index=False)})
    if json:
        print_json(record)
    else:
        _print(record)
    end_unqualified(record, solver.solver)


def _print(record: dict[str, object]) -> None:
    """Print the summary as a table."""
    from rich.console import Console
    from rich.table import Table

    table = Table(show_header=False, box=None)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in record.items():
        if isinstance(value, list):
            shown = " ".join(_short(item) for item in value[:MOST_SHOWN])
            value = shown + (f" ... ({len(value)} in all)" if len(value) > MOST_SHOWN else "")
        table.add_row(name, value if isinstance(value, str) else _short(value))
    Console(markup=False).print(table)


def _short(value: object) -> str:
    if isinstance(value, list):
        return f"{value[1]} at {value[0]:.4g};"
    return f"{value:.8g}" if isinstance(value, float) else str(value)
