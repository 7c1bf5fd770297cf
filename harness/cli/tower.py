"""``dem-harness tower`` and ``dem-harness impulse``: one run of a tower, a table over towers."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from harness.cli.command import File, Json, Reading, options
from harness.cli.engine_options import LongRunOptions, SolverOptions, answer, completed
from harness.cli.files import (
    FORMATS,
    Writer,
    check_target,
    print_wrapped,
    read_reference,
    save_figure,
    write_all,
)
from harness.errors import RequestError
from harness.report.plain import write_csv

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from rich.table import Table

    from harness.cases.tower.impulse import TableOptions as Over
    from harness.engines.contract import Engine
    from harness.observables.reference import ReferencePoints
    from harness.parameters.tower import Tower

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
class RunOptions(LongRunOptions):
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

        seconds = tower_seconds(
            case,
            solver,
            engine.traits if engine else None,
            duration=self.duration,
            steps_per_contact=self.steps_per_contact,
        )
        work = f"--height {case.height} --duration {self.duration:g}, {solver or 'engine'}"
        self.check_duration(seconds, f"the tower ({work})")


def tower(
    system: TowerOptions = TowerOptions(),
    run: RunOptions = RunOptions(),
    solver: SolverOptions = SolverOptions(),
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
    """
    from harness.cases.tower.run import covering
    from harness.cases.tower.run import tower as run_tower
    from harness.observables.tower import summary
    from harness.workflows import progress_bars

    check_target(run.series, "--series")
    case, window = system.tower(), run.window
    with progress_bars("tower", quiet=json) as progress, solver.run() as engine:
        run.check_cost(case, solver.own_solver, engine)
        tower_run = run_tower(
            case,
            solver=solver.own_solver,
            duration=run.duration,
            steps_per_contact=run.steps_per_contact,
            engine=engine,
            progress=progress,
        )
        covering_run = covering(tower_run, window, engine, progress)
        record = completed(summary(tower_run, window, covering_run), engine, progress)
    if run.series is not None:
        write_all({("--series", run.series): lambda path: write_csv(tower_run.to_frame(), path)})
    return answer(record, solver.solver, json, _print)


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


FIRST, ACROSS = 11, 17
"""Characters of a table's column of heights with its frame, and of each run."""

MOST_ESTIMATED = 20
"""Heights whose cost is estimated one by one."""


@options()
class ImpulseOptions(LongRunOptions):
    """The rows of the table, and how an impulse ratio becomes an angle."""

    heights: str = "1-19"
    """Heights, as `1-19` or `1,2,5`."""
    stiffness: Annotated[list[str] | None, Parameter(metavar="NUMBERS")] = None
    """Normal stiffnesses [N/m], commas or repeated. [default: 1e5,1e6,1e7]"""
    speed: Annotated[list[str] | None, Parameter(metavar="NUMBERS")] = None
    """Speeds of the grain [m/s], commas or repeated. [default: 2,4]"""
    law: Literal["overlap", "deformable", "both"] = "both"
    """Contact law: what DEM codes do, the source's, or both."""
    window: Literal["turnaround", "structure", "first-contact", "all"] = "turnaround"
    """Impulse until: `turnaround`, twice the time of closest approach (the source's);
    `structure`, the grain's chain swings from all contacts to one; `first-contact`, the grain
    first detaches."""
    gravity: float = 9.81
    """Gravity along the motion [m/s2]."""
    mass: float = 1.0
    """Mass of each particle [kg]."""
    reading: Reading = "lost"
    """Critical angle from alpha: `lost` rescales the velocity lost in the shock, sqrt(shock) = 1
    - alpha/2, and falls with height; `kept` the velocity kept, alpha/2, and rises. The source
    prints both."""

    def case(self) -> Tower:
        """Return what the towers have in common."""
        from harness.parameters.tower import Tower

        return Tower(mass=self.mass, gravity=self.gravity)

    def over(self) -> Over:
        """Return what the table runs over; raise RequestError for lists that cannot be read."""
        from harness.observables.tower import WINDOWS

        ranges: Over = {"heights": _heights(self.heights)}
        if self.stiffness:
            ranges["stiffnesses"] = _numbers(self.stiffness, "--stiffness")
        if self.speed:
            ranges["speeds"] = _numbers(self.speed, "--speed")
        if self.law != "both":
            ranges["laws"] = (self.law,)
        ranges["windows"] = WINDOWS if self.window == "all" else (self.window,)
        return ranges

    def check_cost(self, solver: str | None, engine: Engine | None) -> None:
        """State what a table costs; raise RequestError for one too long, unless it is forced."""
        from harness.cases.tower.case import tower_seconds
        from harness.cases.tower.impulse import families

        over, rules = self.over(), engine.traits if engine else None
        every = list(over["heights"])
        # some of many heights stand for all
        over["heights"] = some = every[:: math.ceil(len(every) / MOST_ESTIMATED)]
        seconds = sum(
            tower_seconds(case, solver, rules)
            for group in families(self.case(), **over)
            for case in group
        )
        work = f"the table (--heights {self.heights})"
        self.check_duration(seconds * len(every) / len(some), work)


@options()
class FigureOptions:
    """Files that are read and written."""

    reference: File = None
    """Measured angles for the figure: CSV with the columns h_over_d and theta_deg."""
    figure: File = None
    """Draw critical angle against height: .svg, .png or .pdf."""
    csv: File = None
    """Write the table to this file."""

    def points(self) -> ReferencePoints | None:
        """Return the measured angles, if there are any.

        Raise RequestError for files that cannot be read or written, and points that nothing shows.
        """
        check_target(self.figure, "--figure", FORMATS)
        check_target(self.csv, "--csv")
        if self.figure and self.csv and self.figure.resolve() == self.csv.resolve():
            raise RequestError(f"--figure and --csv {self.csv}: must be two files")
        if self.reference is None:
            return None
        if self.figure is None:
            raise RequestError(
                f"--reference {self.reference}: is drawn in a figure only; add --figure FILE"
            )
        return read_reference(self.reference)

    def write(
        self, frame: pd.DataFrame, points: ReferencePoints | None, reading: Reading, solver: str
    ) -> None:
        """Write the table and the figure, where they are requested."""

        def draw() -> Figure:
            from harness.cases.tower.figures import critical_angle_against_height
            from harness.observables.reference import PEYNEAU_ROUX

            return critical_angle_against_height(
                frame, readings=(reading,), solver=solver, published=PEYNEAU_ROUX, reference=points
            )

        writers: dict[tuple[str, Path], Writer] = {}
        if self.csv is not None:
            writers["--csv", self.csv] = lambda path: write_csv(frame, path)
        if self.figure is not None:
            writers["--figure", self.figure] = save_figure(draw, self.figure.suffix)
        write_all(writers)


def impulse(
    table: ImpulseOptions = ImpulseOptions(),
    files: FigureOptions = FigureOptions(),
    solver: SolverOptions = SolverOptions(),
    *,
    json: Json = False,
) -> int:
    """Impulse on the grain and critical angle against the height of the tower.

    alpha(n) = J(n) / J(1): the impulse on a grain dropped on a tower of height n,
    over that on a rigid base. It rescales the shock in the well of the incline,
    hence the critical angle. Without options: the source's six runs, both laws.

    For example:

        dem-harness impulse --heights 1-4 --stiffness 1e6 --speed 2
        dem-harness impulse --law overlap --figure angles.svg --reference measured.csv
    """
    from harness.cases.tower.impulse import impulse_angles
    from harness.workflows import progress_bars

    points, name, case = files.points(), solver.solver, table.case()
    with progress_bars("impulse", quiet=json) as progress, solver.run() as engine:
        table.check_cost(solver.own_solver, engine)
        frame = impulse_angles(
            case=case,
            solver=solver.own_solver,
            reading=table.reading,
            engine=engine,
            progress=progress,
            **table.over(),
        )
        record = completed({"solver": name, "reading": table.reading}, engine, progress)
        record["rows"] = frame.to_dict(orient="records")
    files.write(frame, points, table.reading, name)
    if points is not None:
        pairs = zip(points.heights, points.angles_deg, strict=True)
        record["reference"] = [{"h_over_d": h, "theta_deg": angle} for h, angle in pairs]
    return answer(record, name, json, lambda record: _print_tables(frame, record))


_MOST = 10_000


def _heights(text: str) -> list[int]:
    """Return the heights of ``1-19,30``, each once, in the order given.

    Raise RequestError for what is not one, and for heights outside 1 to 10000.
    """
    numbers: dict[int, None] = {}
    for part in text.split(","):
        ends = re.fullmatch(r"(\d{1,9})(?:-(\d{1,9}))?", part.strip(), re.ASCII)
        if ends is None:
            raise RequestError(
                f"--heights {text!r}: {part.strip()!r} must be a whole number or a range, as 1-19"
            )
        first, last = int(ends[1]), int(ends[2] or ends[1])
        if not 1 <= first <= last <= _MOST:
            raise RequestError(f"--heights {text!r}: {part.strip()} must rise within 1 to {_MOST}")
        numbers |= dict.fromkeys(range(first, last + 1))
    return list(numbers)


def _numbers(texts: Iterable[str], option: str) -> list[float]:
    """Return the numbers of ``["1e5,1e6", "1e7"]``, each once, in the order given.

    Raise RequestError for what is not one; its range is for the parameters to judge.
    """
    numbers: dict[float, None] = {}
    for text in texts:
        for part in text.split(","):
            try:
                numbers[float(part)] = None
            except ValueError:
                raise RequestError(f"{option} {text!r}: {part!r} is not a number") from None
    return list(numbers)


def _print_tables(frame: pd.DataFrame, record: Mapping[str, Any]) -> None:
    from rich.console import Console

    console = Console(width=None if Console().is_terminal else 120, markup=False)
    for (law, window), part in frame.groupby(["law", "window"], sort=False):
        title = f"{law} law, {window} window, {record['solver']}; alpha and critical angle (deg)"
        print_wrapped(f"{title} of each run, reading: velocity {record['reading']}")
        runs = list(part.groupby(["stiffness_N_per_m", "speed_m_per_s"], sort=False))
        tables = math.ceil(len(runs) / max(1, (console.width - FIRST) // ACROSS))
        each = math.ceil(len(runs) / tables)
        for first in range(0, len(runs), each):
            console.print(_table(runs[first : first + each]))


def _table(runs: Sequence[tuple[Any, pd.DataFrame]]) -> Table:
    from rich.table import Table

    table = Table()
    table.add_column("height", justify="right")
    for (stiffness, speed), _ in runs:
        name = f"k = {stiffness:.3g} N/m\nv0 = {speed:g} m/s"
        table.add_column(name, justify="right", no_wrap=True)
    columns = [_cells(run) for _, run in runs]
    for height, *cells in zip(runs[0][1]["height"], *columns, strict=True):
        table.add_row(str(height), *cells)
    return table


def _cells(run: pd.DataFrame) -> Iterable[str]:
    """Yield impulse ratio and angle of each height; - where the window does not exist."""
    for ratio, angle in zip(run["impulse_ratio"], run["critical_angle_deg"], strict=True):
        degrees = "-" if angle != angle else format(angle, "6.3f")
        yield "-" if ratio != ratio else f"{ratio:.4f}  {degrees}"
