"""``dem-harness impulse``."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from harness.cli.options import Json, Reading
from harness.cli.solvers import OWN, SolverOptions

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from harness.engines.contract import Engine
    from harness.observables.reference import ReferencePoints
    from harness.observables.windows import Window
    from harness.parameters.tower import Law


class Laws(StrEnum):
    """Contact laws, one or both."""

    overlap = "overlap"
    deformable = "deformable"
    both = "both"


class Windows(StrEnum):
    """Windows of the impulse, one or all."""

    turnaround = "turnaround"
    structure = "structure"
    first_contact = "first-contact"
    all = "all"


@dataclass(frozen=True)
class TableOptions:
    """The rows of the table, and how an impulse ratio becomes an angle."""

    heights: Annotated[str, typer.Option(help="Heights, as `1-19` or `1,2,5`.")] = "1-19"
    stiffness: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NUMBERS",
            help="Normal stiffnesses [N/m], commas or repeated.  [default: 1e5,1e6,1e7]",
        ),
    ] = None
    speed: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NUMBERS", help="Speeds of the grain [m/s], commas or repeated.  [default: 2,4]"
        ),
    ] = None
    law: Annotated[
        Laws, typer.Option(help="Contact law: what DEM codes do, the source's, or both.")
    ] = Laws.both
    window: Annotated[
        Windows,
        typer.Option(
            help="Impulse until: `turnaround`, twice the time of closest approach (the source's); "
            "`structure`, the grain's chain swings from all contacts to one; `first-contact`, the "
            "grain first detaches."
        ),
    ] = Windows.turnaround
    gravity: Annotated[float, typer.Option(help="Gravity along the motion [m/s2].")] = 9.81
    mass: Annotated[float, typer.Option(help="Mass of each particle [kg].")] = 1.0
    reading: Annotated[
        Reading,
        typer.Option(
            help="Critical angle from alpha: `lost` rescales the velocity lost in the shock, "
            "sqrt(shock) = 1 - alpha/2, and falls with height; `kept` the velocity kept, alpha/2, "
            "and rises. The source prints both."
        ),
    ] = Reading.LOST

    def rows(self, solver: str | None, engine: Engine | None) -> pd.DataFrame:
        """Return the table; raise RequestError for lists that cannot be read."""
        from harness.cases.tower.impulse_angles import impulse_angles
        from harness.cases.tower.impulse_table import SPEEDS, STIFFNESSES
        from harness.cli.lists import heights, numbers
        from harness.observables.windows import WINDOWS
        from harness.parameters.tower import LAWS, Tower

        law, window = self.law, self.window
        return impulse_angles(
            heights=heights(self.heights),
            stiffnesses=numbers(self.stiffness, "--stiffness") if self.stiffness else STIFFNESSES,
            speeds=numbers(self.speed, "--speed") if self.speed else SPEEDS,
            laws=LAWS if law is Laws.both else (cast("Law", law.value),),
            windows=WINDOWS if window is Windows.all else (cast("Window", window.value),),
            solver=solver,
            case=Tower(mass=self.mass, gravity=self.gravity),
            reading=self.reading.value,
            engine=engine,
        )


@dataclass(frozen=True)
class FileOptions:
    """Files that are read and written."""

    reference: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Measured angles for the figure: CSV with the columns h_over_d and theta_deg.",
        ),
    ] = None
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Draw critical angle against height: .svg, .png or .pdf."
        ),
    ] = None
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write the table to this file.")
    ] = None

    def check(self) -> None:
        """Raise RequestError for files that cannot be written, and points that nothing shows."""
        from harness.cli.files import FORMATS, check_target
        from harness.errors import RequestError

        check_target(self.figure, "--figure", FORMATS)
        check_target(self.csv, "--csv")
        if self.figure and self.csv and self.figure.resolve() == self.csv.resolve():
            raise RequestError(f"--figure and --csv {self.csv}: must be two files")
        if self.reference is not None and self.figure is None:
            raise RequestError(
                f"--reference {self.reference}: is drawn in a figure only; add --figure FILE"
            )


def impulse(
    table: TableOptions, files: FileOptions, solver: SolverOptions, json: Json = False
) -> None:
    """Impulse on the grain and critical angle against the height of the tower.

    alpha(n) = J(n) / J(1): the impulse on a grain dropped on a tower of height n,
    over that on a rigid base. It rescales the shock in the well of the incline,
    hence the critical angle. Without options: the source's six runs, both laws.
    """
    from harness.cli.files import read_reference, save_figure, write_all
    from harness.cli.history_records import impulse_quantities
    from harness.cli.qualified import end_unqualified, qualification
    from harness.cli.recording import recorded

    files.check()
    points = read_reference(files.reference) if files.reference is not None else None
    name, reading = solver.solver, table.reading.value
    with recorded("impulse") as told, solver.run() as engine:
        found = table.rows(name if name in OWN else None, engine)
        told.engine = engine.identify().record() if engine else solver.own_record
        told.quantities = impulse_quantities(
            found.to_dict(orient="records"),
            name,
            {"mass_kg": table.mass, "gravity_m_per_s2": table.gravity},
        )
        more = qualification(engine, told)
    writers: dict[tuple[str, Path], Any] = {}
    if files.csv is not None:
        writers["--csv", files.csv] = lambda path: found.to_csv(path, index=False)
    if files.figure is not None:
        writers["--figure", files.figure] = save_figure(
            lambda: _draw(found, points, reading, name), files.figure.suffix
        )
    write_all(writers)
    if json:
        _print_json(found, points, {"solver": name, "reading": reading, **more})
    else:
        _print_tables(found, reading, name)
    end_unqualified(more, name)


def _draw(found: pd.DataFrame, points: ReferencePoints | None, reading: str, solver: str) -> Figure:
    from harness.cases.tower.figures.impulse import critical_angle_against_height
    from harness.observables.reference import PEYNEAU_ROUX

    return critical_angle_against_height(
        found, readings=(reading,), solver=solver, published=PEYNEAU_ROUX, reference=points
    )


def _print_json(
    found: pd.DataFrame, points: ReferencePoints | None, record: dict[str, Any]
) -> None:
    from harness.cli.output import print_json

    record["rows"] = found.to_dict(orient="records")
    if points is not None:
        pairs = zip(points.heights, points.angles_deg, strict=True)
        record["reference"] = [{"h_over_d": h, "theta_deg": angle} for h, angle in pairs]
    print_json(record)


def _print_tables(found: pd.DataFrame, reading: str, solver: str) -> None:
    """Print a table for each law and window: heights down, runs across."""
    from rich.console import Console
    from rich.table import Table

    console = Console(width=None if Console().is_terminal else 120, markup=False)
    for (law, window), part in found.groupby(["law", "window"], sort=False):
        title = f"{law} law, {window} window, {solver}; alpha and critical angle (deg) of each run"
        console.print(f"{title}, reading: velocity {reading}", soft_wrap=True, highlight=False)
        table = Table()
        table.add_column("height", justify="right")
        runs = list(part.groupby(["stiffness_N_per_m", "speed_m_per_s"], sort=False))
        for (stiffness, speed), _ in runs:
            name = f"k = {stiffness:.3g} N/m\nv0 = {speed:g} m/s"
            table.add_column(name, justify="right", no_wrap=True)
        columns = [_cells(run) for _, run in runs]
        for height, *cells in zip(runs[0][1]["height"], *columns, strict=True):
            table.add_row(str(height), *cells)
        console.print(table)


def _cells(run: pd.DataFrame) -> list[str]:
    pairs = zip(run["impulse_ratio"], run["critical_angle_deg"], strict=True)
    return [_cell(ratio, angle) for ratio, angle in pairs]


def _cell(ratio: float, angle: float) -> str:
    if ratio != ratio:  # the window does not exist
        return "-"
    return f"{ratio:.4f}  {'-' if angle != angle else format(angle, '6.3f')}"
