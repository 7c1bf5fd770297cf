"""``dem-harness sweep``."""

from __future__ import annotations

import contextlib
import re
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from harness.cli.command import Folder, Json, Settings, panel
from harness.cli.command import options as grouped
from harness.cli.engine_options import (
    IntegratorOptions,
    LongRunOptions,
    qualification,
    runs_made,
)
from harness.cli.files import (
    Writer,
    output_folder,
    print_frame,
    print_json,
    read_points,
    save_figure,
    write_all,
)
from harness.errors import RequestError, cannot_write
from harness.report.plain import one_line, write_csv

if TYPE_CHECKING:
    from harness.engines.contract import Engine
    from harness.observables.reference import Points
    from harness.workflows.progress import Progress
    from harness.workflows.sweep_plan import SweepPlan, SweepRequest
    from harness.workflows.sweep_run import Row, Sweep

FAILED = 3
"""Exit status where an engine died in a run or does not qualify, or where no run could be made."""

ROWS = "rows.csv"
"""The table, also while the sweep runs."""

MOST_SHOWN = 40
"""Rows on a terminal; the files hold all."""


@grouped()
class SweepOptions(IntegratorOptions):
    """What is swept, and in which engines."""

    target: Annotated[str, Parameter(parse=False)] = ""
    over: Annotated[list[str] | None, Parameter(metavar="NAME=VALUES")] = None
    """A parameter and its values, in SI units and degrees: a list `1,2,5`, a range
    `FIRST:LAST:COUNT` of evenly spaced numbers, both ends among them, a range
    `FIRST:LAST:logCOUNT` evenly spaced in the logarithm, or several with commas between. Repeat
    it for every combination with another parameter."""
    settings: Settings = None
    """A parameter that is the same in every run; repeat it for several."""
    engines: Annotated[str, Parameter(metavar="NAMES", group=panel("Engine"))] = ""
    """Engines that `dem-harness engines` lists and solvers that `dem-harness cases` names, with
    commas between, or `all`. [default: as of `run`]"""
    quantity: Annotated[str, Parameter(metavar="NAMES")] = ""
    """What is measured and shown: quantities of the case with commas between, the first in the
    figure. Of one such as `critical_angle_deg` a value takes several runs. [default: all that a
    run measures, the first in the figure]"""
    output: Folder = None
    """Where table and figure are written; the same sweep goes on there. [default:
    reports/runs/DATE-sweep]"""
    reference: Annotated[Path | None, Parameter(metavar="FILE.csv")] = None
    """Your measured points for the figure: a CSV table with columns named as in rows.csv, the
    first parameter of --over and the first --quantity (`measured_NAME` where a parameter has its
    name); `uncertainty_UNIT` gives error bars."""

    def request(self) -> SweepRequest:
        """Return what is to be run: of a case, or of a file with these options on top."""
        from harness.engines.registry import named_values
        from harness.workflows.sweep_plan import SweepRequest, request_in, with_options

        target = self.target
        of_file = target.endswith(".toml")
        base = request_in(Path(target)) if of_file else SweepRequest(target, (), {})
        over = named_values(self.over or (), "--over")
        fixed = named_values(self.settings or (), "--set")
        return with_options(base, over, fixed, self.engines, self.quantity)

    def points(self, chosen: SweepPlan) -> Points | None:
        """Return the measured points, if there are any; raise RequestError for a bad file."""
        from harness.workflows.sweep_plan import drawn_columns

        if self.reference is None:
            return None
        if not chosen.request.quantity:
            raise RequestError(
                f"--reference {self.reference}: --quantity must say what was measured there"
            )
        return read_points(self.reference, *drawn_columns(chosen))

    def named(self, error: str) -> str:
        """Return an error with the file that it is of, and the file's words for its tables."""
        if not self.target.endswith(".toml") or error.startswith(self.target):
            return error
        for table, option in (("set", self.settings), ("over", self.over)):
            if not option:
                error = re.sub(rf"^--{table}:? ", f"[{table}] ", error)
        return f"{self.target}: {error}"


def sweep(
    target: str,
    /,
    options: SweepOptions = SweepOptions(),
    limit: LongRunOptions = LongRunOptions(),
    *,
    json: Json = False,
) -> int:
    """Run a case over values of its parameters and over engines: one tidy row a run.

    Runs that were made before are not made again, and one that was killed goes on: every run is
    kept as soon as it is over, and rows.csv holds it, what has not ended as pending. A run that
    fails is a row with the reason, and so are values that the case refuses together.

    For example:

        dem-harness sweep tower --over height=1,2,5:20:4 --engines exact,lammps --output mine
        dem-harness sweep oblique --set preset=kharaz --over angle=5:85:9 \
            --quantity rim_speed_ratio --reference measured.csv
        dem-harness sweep inputs/sweeps/step-and-stiffness.toml --output mine

    Parameters
    ----------
    target
        A case that `dem-harness cases` lists, or a file, FILE.toml, that says what is swept.
    """
    from harness.workflows import progress_bars

    options = replace(options, target=target)
    chosen = _planned(options)
    points = options.points(chosen)
    limit.check_duration(chosen.seconds(), f"{chosen.runs} runs of case {chosen.case.name!r}")
    options.check_names(chosen.engines, "--engines")
    counts: dict[str, int] = {}
    with progress_bars("sweep", quiet=json) as progress, _folder(options, chosen.request) as folder:
        table = PartialTable(folder / ROWS)
        result, unqualified = _run(options, chosen, counts, progress, table)
        ended = result.count("done") + result.count("undecided")
        failed = result.count("failed") or not ended or unqualified
        notes = _written(folder, result, points)
    notes += [f"engine {n!r} did not qualify: {reason}" for n, reason in unqualified.items()]
    if json:
        print_json({**result.to_json(), **counts, "output": str(folder), "notes": notes})
    else:
        _print(result, notes)
    return FAILED if failed else 0


def _planned(options: SweepOptions) -> SweepPlan:
    """Return the requested plan; raise RequestError, which names the file where there is one."""
    from harness.workflows.sweep_plan import plan

    try:
        return plan(options.request())
    except RequestError as error:
        raise RequestError(options.named(str(error))) from None


def _run(
    options: SweepOptions,
    chosen: SweepPlan,
    counts: dict[str, int],
    progress: Progress,
    table: PartialTable,
) -> tuple[Sweep, dict[str, str]]:
    from harness.workflows.sweep_run import Runner, run_plan

    unqualified: dict[str, str] = {}

    @contextlib.contextmanager
    def open_one(name: str) -> Iterator[Engine]:
        with options.open(name, options.integrator) as engine:
            yield engine
            counted = runs_made(engine)
            for key, value in counted.items():
                counts[key] = counts.get(key, 0) + value
            if counted and not any(
                counted.values()
            ):  # it states none of them: nothing to qualify for
                return
            reason = qualification(engine, progress).get("qualification_failures")
            if reason:
                unqualified[name] = reason

    runner = Runner(open_one, options.entries(), options.fresh)
    return run_plan(chosen, runner, progress, table), unqualified


@dataclass
class PartialTable:
    """Writes the table of a sweep that still runs, whole each time; its runs to come are pending.

    A twentieth of the time goes into it at most, however many rows there are.
    """

    file: Path
    share: float = 0.05
    pause: float = 1.0
    due: float = 0.0

    def __call__(self, rows: Callable[[], Sequence[Row]]) -> None:
        """Write the rows so far, if the last time is long enough ago."""
        from harness.files import held_folder
        from harness.workflows.sweep_run import as_frame

        begun = time.monotonic()
        if begun < self.due:
            return
        try:
            with held_folder(self.file.parent) as aside:
                write_csv(as_frame(rows()), aside / self.file.name)
                (aside / self.file.name).replace(self.file)
        except OSError as error:
            raise cannot_write(f"table {self.file}", error) from None
        now = time.monotonic()
        self.due = now + max(self.pause, (now - begun) / self.share)


@contextlib.contextmanager
def _folder(options: SweepOptions, request: SweepRequest) -> Iterator[Path]:
    from harness.workflows.sweep_run import held_sweep

    place = (
        contextlib.nullcontext(options.output) if options.output else output_folder(None, "-sweep")
    )
    with place as folder, held_sweep(folder, request):
        yield folder


def _written(folder: Path, result: Sweep, points: Points | None) -> list[str]:
    """Write table and figure, all whole; return notes on what is not written, and why."""
    from functools import partial
    from importlib.util import find_spec

    frame = result.to_frame()
    notes: list[str] = []
    figure = result.figure(points=points)
    files: dict[tuple[str, Path], Writer] = {("table", folder / ROWS): partial(write_csv, frame)}
    if find_spec("pyarrow") is None:
        hint = "pyarrow is not installed: pip install 'dem-harness[parquet]'"
        notes.append(f"rows.parquet is not written: {hint}")
    else:
        files["table", folder / "rows.parquet"] = partial(frame.to_parquet, index=False)
    if figure is None:
        notes.append("no figure: what is to be drawn was measured in no run")
    else:
        for suffix in (".svg", ".png"):
            files["figure", folder / f"figure{suffix}"] = save_figure(lambda: figure, suffix)
            for name, draw in result.own_figures().items():
                files["figure", folder / f"{name}{suffix}"] = save_figure(draw, suffix)
    write_all(files)
    return notes


def _print(result: Sweep, notes: list[str]) -> None:
    from harness.store.entries import tell_stderr

    frame = result.to_frame()
    measured = [name for name in result.selected if name in frame and frame[name].notna().any()]
    columns = frame[["engine", *result.over, *measured, "status"]]
    print_frame(columns.head(MOST_SHOWN), 7)
    if len(columns) > MOST_SHOWN:
        print(f"... {len(columns) - MOST_SHOWN} more in rows.csv")
    reasons = frame.loc[frame["reason"] != "", "reason"].value_counts()
    for reason, count in reasons.items():
        tell_stderr(f"{count} of {len(frame)} runs: {one_line(str(reason))}")
    for engine, reason in result.missing.items():
        tell_stderr(f"engine {engine!r} is left out: {one_line(reason)}")
    for note in notes:
        tell_stderr(note)
