"""``dem-harness tower``."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from harness.cli.command import File, Json, options
from harness.cli.engine_options import CostOptions, SolverOptions, answer, completed
from harness.cli.files import check_target, write_all
from harness.cli.film import FilmOptions
from harness.report.plain import write_csv

if TYPE_CHECKING:
    from harness.engines.contract import Engine
    from harness.observables.tower import TowerRun
    from harness.parameters.tower import Tower
    from harness.report.film import Film

MOST_SHOWN = 20
"""Entries of a list that the table shows; JSON has them all."""


@options()
class TowerOptions:
    """The tower and the grain."""

    height: int = 1
    """Contacts; particles - 1."""
    stiffness: float = 1e6
    """Normal stiffness [N/m]."""
    mass: float = 1.0
    """Mass of each particle [kg]."""
    speed: float = 2.0
    """Speed of the grain at the start [m/s]."""
    gravity: float = 9.81
    """Gravity along the motion [m/s2]; 0 is the air hockey table."""
    law: Literal["overlap", "deformable"] = "deformable"
    """Contact law: what DEM codes do, or the source's."""
    base: Literal["fixed", "free"] = "fixed"
    """Whether the last particle moves."""

    def tower(self) -> Tower:
        """Return the parameters; raise RequestError for values out of range."""
        from harness.parameters.tower import Tower

        return Tower(**vars(self))


@options()
class RunOptions(CostOptions):
    """How long, how finely, and what is kept of it."""

    duration: float = 3.0
    """How long, in contact times t0 of grain and one fixed particle."""
    steps_per_contact: float | None = None
    """Steps in pi sqrt(m/k). [default: 4000 rk4, 1000 engines]"""
    window: Literal["turnaround", "structure", "first-contact"] = "turnaround"
    """What the impulse is summed over."""
    series: File = None
    """Write the series to this CSV file."""

    def check_cost(self, case: Tower, solver: str | None, engine: Engine | None) -> None:
        """State what a run costs; raise RequestError for one too long, unless it is forced."""
        from harness.cases.tower.case import tower_seconds
        from harness.engines.border import OWN_SECONDS

        seconds = tower_seconds(
            case,
            solver,
            engine.traits if engine else None,
            duration=self.duration,
            steps_per_contact=self.steps_per_contact,
        )
        work = f"--height {case.height} --duration {self.duration:g}, {solver or 'engine'}"
        self.agree(seconds, f"the tower ({work})", None if engine else OWN_SECONDS)


def tower(
    system: TowerOptions = TowerOptions(),
    run: RunOptions = RunOptions(),
    solver: SolverOptions = SolverOptions(),
    film: FilmOptions = FilmOptions(),
    *,
    json: Json = False,
) -> int:
    """Drop a grain on a tower of particles: force, impulse and contacts of the grain.

    The tower stands on a fixed base, at rest and just touching; the grain
    arrives with its speed, gravity along the motion. Times are in t0, the time
    that the grain would stay on one fixed particle.

    For example:

        dem-harness tower --height 4 --law overlap --solver lammps
        dem-harness tower --height 2 --window first-contact --series tower.csv
        dem-harness tower --height 9 --law overlap --duration 6 --film tower.gif
    """
    from harness.cases.tower.run import covering
    from harness.cases.tower.run import tower as run_tower
    from harness.cli.recording import recorded, tower_quantities
    from harness.observables.tower import summary

    check_target(run.series, "--series")
    film.check()
    case, window = system.tower(), run.window
    with recorded("tower", quiet=json) as recording, solver.run() as engine:
        run.check_cost(case, solver.own_solver, engine)
        tower_run = run_tower(
            case,
            solver=solver.own_solver,
            duration=run.duration,
            steps_per_contact=run.steps_per_contact,
            profiles=film.film is not None,
            engine=engine,
            progress=recording.progress,
        )
        covering_run = covering(tower_run, window, engine, recording.progress)
        record = completed(summary(tower_run, window, covering_run), engine, recording)
        recording.engine = {**solver.own_record, **record}
        recording.quantities = tower_quantities(record)
    if run.series is not None:
        write_all({("--series", run.series): lambda path: write_csv(tower_run.to_frame(), path)})
    film.write(partial(_film, tower_run))
    return answer(record, solver.solver, json, _print)


def _film(run: TowerRun, frames: int) -> Film:
    from harness.cases.tower.film import tower_film

    return tower_film(run, frames)


def _print(record: Mapping[str, Any]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table(show_header=False, box=None)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in record.items():
        if isinstance(value, list):
            text = " ".join(_short(item) for item in value[:MOST_SHOWN])
            value = text + (f" ... ({len(value)} in all)" if len(value) > MOST_SHOWN else "")
        table.add_row(name, value if isinstance(value, str) else _short(value))
    Console(markup=False).print(table)


def _short(value: object) -> str:
    if isinstance(value, list):
        return f"{value[1]} at {value[0]:.4g};"
    return f"{value:.8g}" if isinstance(value, float) else str(value)
