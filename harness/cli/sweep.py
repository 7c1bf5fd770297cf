"""``dem-harness sweep``: a table and a figure over parameters and engines."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from harness.cli.app import ENGINE, Folder, Force, Json, Settings
from harness.cli.engines import ClusterOptions, Opener, duration_check
from harness.cli.output import output_folder, print_frame, print_json, tell, write_all, write_csv
from harness.errors import HarnessError, RequestError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from harness.files import Writer
    from harness.workflows.points import Points
    from harness.workflows.progress import Progress
    from harness.workflows.sweep_plan import SweepPlan, SweepRequest
    from harness.workflows.sweeps import Row, Sweep

ROWS = "rows.csv"  # the table, also while the sweep runs
UNDATED = {"svg": {"Date": None}, "png": {"Software": None}, "pdf": {"CreationDate": None}}


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class SweepOptions:
    """What is swept, and in which engines."""

    over: Annotated[list[str] | None, Parameter(metavar="NAME=VALUES")] = None
    """A parameter and its values, in SI units and degrees: a list `1,2,5`, a range
    `FIRST:LAST:COUNT` of evenly spaced numbers, a range `FIRST:LAST:logCOUNT` evenly spaced in the
    logarithm, or several with commas between. Repeat it for all combinations."""
    settings: Settings = None
    """A parameter that is the same in every run; repeat it for several."""
    engines: Annotated[str, Parameter(metavar="NAMES", group=ENGINE)] = ""
    """Engines that `dem-harness engines` lists and solvers of the case, with commas between, or
    `all`. [default: as of `run`]"""
    quantity: Annotated[str, Parameter(metavar="NAMES")] = ""
    """Quantities to measure, with commas between, the first in the figure. Of one such as
    critical_angle_deg a value takes several runs. [default: all that a run measures]"""
    output: Folder = None
    """Where table and figure are written; the same sweep goes on there. [default:
    reports/runs/DATE-sweep]"""
    reference: Annotated[Path | None, Parameter(metavar="FILE.csv")] = None
    """Your measured points for the figure: a CSV table with the columns of rows.csv, the first
    parameter of --over and the first quantity; its uncertainty gives error bars."""
    force: Force = False


def sweep(
    target: str,
    /,
    choice: SweepOptions = SweepOptions(),
    engines: ClusterOptions = ClusterOptions(),
    *,
    json: Json = False,
) -> int:
    """Run a case over values of its parameters and over engines: one tidy row a run.

    Runs that were made before are not made again, and a sweep that was killed goes on. A run that
    fails is a row with the reason, and so are values that the case refuses together.

    For example:

        dem-harness sweep tower --over height=1,2,5:20:4 --engines exact,lammps --output mine

        dem-harness sweep oblique --set preset=kharaz --over angle=5:85:9 --reference measured.csv

        dem-harness sweep inputs/sweeps/step-and-stiffness.toml --dask tcp://head:8786

    Parameters
    ----------
    target
        A case that `dem-harness cases` lists, or a file, FILE.toml, that describes a sweep.
    """
    from harness.workflows.points import read_points
    from harness.workflows.progress import progress_bars

    chosen = _planned(target, choice)
    points = None
    if choice.reference is not None:
        name, column = next(iter(chosen.columns().items()))
        across, uncertainty = chosen.request.over[0], chosen.uncertainty_column(name)
        points = read_points(choice.reference, across, column, uncertainty)
    engines.check(chosen.engines, "--engines")
    opener = Opener(engines)
    runs = len(chosen.points) * len(chosen.engines)
    work = f"{runs} runs of case {chosen.case.name!r}"
    duration_check(choice.force, work)(chosen.seconds())
    with (
        progress_bars("sweep", quiet=json) as progress,
        engines.executor() as opener.executor,
        _folder(choice, chosen.request) as folder,
    ):
        result, unqualified = _run(chosen, opener, progress, PartialTable(folder / ROWS))
        notes = _write(folder, result, points)
    notes += [f"engine {name!r} did not qualify: {why}" for name, why in unqualified.items()]
    if json:
        more = {"output": str(folder), "notes": notes}
        print_json({**result.to_json(), **opener.runs(), **more})
    else:
        _print(result, notes)
    ended = result.count("done") + result.count("undecided")
    failed = result.count("failed") or not ended or unqualified
    return HarnessError.exit_status if failed else 0


@dataclass
class PartialTable:
    """Writes the table of a sweep that runs, whole each time, in a twentieth of the time."""

    file: Path
    share: float = 0.05
    pause: float = 1.0  # [s]
    due: float = 0.0

    def __call__(self, rows: Callable[[], Sequence[Row]]) -> None:
        """Write the rows so far, if the last time is long enough ago."""
        from harness.files import write_files
        from harness.workflows.sweeps import as_frame

        started = time.monotonic()
        if started < self.due:
            return
        write_files({("table", self.file): partial(write_csv, as_frame(rows()))})
        now, is_first = time.monotonic(), not self.due
        # the first table takes the time of imports
        self.due = now + max(self.pause, 0.0 if is_first else (now - started) / self.share)


def figure_writer(draw: Callable[[], Figure], suffix: str) -> Writer:
    """Return a function that writes a figure; the same figure is the same file."""

    def write(path: Path) -> None:
        from harness.report.style import house_style

        kind = suffix.lower().removeprefix(".")
        with house_style():
            draw().savefig(path, format=kind, metadata=UNDATED[kind])

    return write


def _planned(target: str, choice: SweepOptions) -> SweepPlan:
    """Return the plan; an error of a sweep's file names the file."""
    from harness.engines.registry import named_values
    from harness.workflows.sweep_plan import SweepRequest, plan, request_in

    is_file = target.endswith(".toml")
    base = request_in(Path(target)) if is_file else SweepRequest(target, (), {})
    over = named_values(choice.over or (), "--over")
    fixed = named_values(choice.settings or (), "--set")
    try:
        return plan(base.with_options(over, fixed, choice.engines, choice.quantity))
    except RequestError as error:
        if not is_file:
            raise
        text = str(error)
        for table, given in (("over", over), ("set", fixed)):
            text = text if given else text.replace(f"--{table} ", f"[{table}] ", 1)
        raise RequestError(f"{target}: {text}") from None


def _run(
    chosen: SweepPlan, opener: Opener, progress: Progress, table: PartialTable
) -> tuple[Sweep, dict[str, str]]:
    """Return the sweep, and why engines did not qualify, by name."""
    from harness.workflows.sweeps import Runner, run_plan

    unqualified: dict[str, str] = {}

    @contextlib.contextmanager
    def open_engine(name: str) -> Iterator:  # type: ignore[type-arg]
        with opener.qualified(name, progress=progress) as engine:
            yield engine
        if reason := opener.qualification.get("qualification_failures"):
            unqualified[name] = reason

    runner = Runner(open_engine, opener.executor)
    return run_plan(chosen, runner, progress=progress, partial_table=table), unqualified


@contextlib.contextmanager
def _folder(choice: SweepOptions, request: SweepRequest) -> Iterator[Path]:
    from harness.workflows.sweeps import held_sweep

    named = contextlib.nullcontext(choice.output) if choice.output else None
    with named or output_folder(None, "-sweep") as folder, held_sweep(folder, request):
        yield folder


def _write(folder: Path, result: Sweep, points: Points | None) -> list[str]:
    """Write table and figure, all whole; return notes on what is not written, and why."""
    from importlib.util import find_spec

    frame, figure, notes = result.to_frame(), result.figure(points), []
    files: dict[tuple[str, Path | None], Writer] = {}
    files["table", folder / ROWS] = partial(write_csv, frame)
    if find_spec("pyarrow") is not None:
        files["table", folder / "rows.parquet"] = partial(frame.to_parquet, index=False)
    else:
        install = "pip install 'dem-harness[parquet]'"
        notes.append(f"rows.parquet is not written: pyarrow is not installed: {install}")
    if figure is None:
        notes.append("no figure: its quantity was measured in no run")
    else:
        for suffix in (".svg", ".png"):
            path = folder / f"figure{suffix}"
            files["figure", path] = figure_writer(lambda: figure, suffix)
    write_all(files)
    return notes


def _print(result: Sweep, notes: Sequence[str]) -> None:
    frame = result.to_frame()
    columns = [c for c in result.plan.columns().values() if frame[c].notna().any()]
    shown = frame[
        ["engine", *(n for n in result.plan.request.over if n in frame), *columns, "status"]
    ]
    print_frame(shown, rest=f"{ROWS} has all")
    for reason, count in frame.loc[frame["reason"] != "", "reason"].value_counts().items():
        tell(f"{count} of {len(frame)} runs: {reason}")
    for engine, why in result.missing.items():
        tell(f"engine {engine!r} is left out: {why}")
    for note in notes:
        tell(note)
