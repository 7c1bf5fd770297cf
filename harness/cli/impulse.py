"""``dem-harness impulse``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from harness.cli.cached_engines import Cache, Fresh
from harness.cli.options import Json, Lmp, Mpirun, Reading
from harness.cli.tower import Solver, engine_of, own_solver

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

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


def impulse(
    heights: Annotated[str, typer.Option(help="Heights, as `1-19` or `1,2,5`.")] = "1-19",
    stiffness: Annotated[
        list[str] | None,
        typer.Option(help="Normal stiffnesses [N/m], commas or repeated.  [default: 1e5,1e6,1e7]"),
    ] = None,
    speed: Annotated[
        list[str] | None,
        typer.Option(help="Speeds of the grain [m/s], commas or repeated.  [default: 2,4]"),
    ] = None,
    law: Annotated[
        Laws, typer.Option(help="Contact law: what DEM codes do, the source's, or both.")
    ] = Laws.both,
    window: Annotated[
        Windows,
        typer.Option(
            help="Impulse until: `turnaround`, twice the time of closest approach (the source's); "
            "`structure`, the grain's chain swings from all contacts to one; `first-contact`, the "
            "grain first detaches."
        ),
    ] = Windows.turnaround,
    solver: Annotated[Solver, typer.Option(help="What runs the towers.")] = Solver.rk4,
    gravity: Annotated[float, typer.Option(help="Gravity along the motion [m/s2].")] = 9.81,
    mass: Annotated[float, typer.Option(help="Mass of each particle [kg].")] = 1.0,
    reading: Annotated[
        Reading,
        typer.Option(
            help="Critical angle from alpha: `lost` rescales the velocity lost in the shock, "
            "sqrt(shock) = 1 - alpha/2, and falls with height; `kept` the velocity kept, alpha/2, "
            "and rises. The source prints both."
        ),
    ] = Reading.LOST,
    reference: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Measured angles for the figure: CSV with the columns h_over_d and theta_deg.",
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Draw critical angle against height: .svg, .png or .pdf."
        ),
    ] = None,
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write the table to this file.")
    ] = None,
    lmp: Lmp = None,
    mpirun: Mpirun = None,
    cache: Cache = None,
    fresh: Fresh = False,
    json: Json = False,
) -> None:
    """Impulse on the grain and critical angle against the height of the tower.

    alpha(n) = J(n) / J(1): the impulse on a grain dropped on a tower of height n,
    over that on a rigid base. It rescales the shock in the well of the incline,
    hence the critical angle. Without options: the source's six runs, both laws.
    """
    from harness.cases.tower.impulse_angles import impulse_angles
    from harness.cases.tower.impulse_table import SPEEDS, STIFFNESSES
    from harness.cli.files import FORMATS, check_target, read_reference, save_figure, write_all
    from harness.cli.history_records import impulse_quantities
    from harness.cli.lists import heights as height_list
    from harness.cli.lists import numbers
    from harness.cli.recording import recorded
    from harness.errors import RequestError
    from harness.observables.windows import WINDOWS
    from harness.parameters.tower import LAWS, Tower

    check_target(figure, "--figure", FORMATS)
    check_target(csv, "--csv")
    if figure is not None and csv is not None and figure.resolve() == csv.resolve():
        raise RequestError(f"--figure and --csv {csv}: must be two files")
    points = read_reference(reference) if reference is not None else None
    with recorded("impulse") as told, engine_of(solver, lmp, mpirun, cache, fresh) as engine:
        found = impulse_angles(
            heights=height_list(heights),
            stiffnesses=numbers(stiffness, "--stiffness") if stiffness else STIFFNESSES,
            speeds=numbers(speed, "--speed") if speed else SPEEDS,
            laws=LAWS if law is Laws.both else (cast("Law", law.value),),
            windows=WINDOWS if window is Windows.all else (cast("Window", window.value),),
            solver=solver.value,
            case=Tower(mass=mass, gravity=gravity),
            reading=reading.value,
            engine=engine,
        )
        told.engine = engine.identify().record() if engine else own_solver(solver)
        told.quantities = impulse_quantities(
            found.to_dict(orient="records"),
            solver.value,
            {"mass_kg": mass, "gravity_m_per_s2": gravity},
        )
    files: dict[tuple[str, Path], Any] = {}
    if csv is not None:
        files["--csv", csv] = lambda path: found.to_csv(path, index=False)
    if figure is not None:
        files["--figure", figure] = save_figure(
            lambda: _draw(found, points, reading.value, solver.value), figure.suffix
        )
    write_all(files)
    _print(found, points, reading.value, solver.value, json)


def _draw(found: pd.DataFrame, points: ReferencePoints | None, reading: str, solver: str) -> Figure:
    from harness.cases.tower.figures.impulse import critical_angle_against_height
    from harness.observables.reference import PEYNEAU_ROUX

    return critical_angle_against_height(
        found, readings=(reading,), solver=solver, published=PEYNEAU_ROUX, reference=points
    )


def _print(
    found: pd.DataFrame, points: ReferencePoints | None, reading: str, solver: str, json: bool
) -> None:
    from harness.cli.output import print_json

    if not json:
        _print_tables(found, reading, solver)
        return
    record: dict[str, Any] = {
        "solver": solver,
        "reading": reading,
        "rows": found.to_dict(orient="records"),
    }
    if points is not None:
        pairs = zip(points.heights, points.angles_deg, strict=True)
        record["reference"] = [{"h_over_d": h, "theta_deg": angle} for h, angle in pairs]
    print_json(record)


def _print_tables(found: pd.DataFrame, reading: str, solver: str) -> None:
    """Print a table for each law and window: heights down, runs across."""
    from rich.console import Console
    from rich.table import Table

    console = Console(width=None if Console().is_terminal else 120)
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
