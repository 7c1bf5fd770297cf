"""``dem-harness study``."""

from __future__ import annotations

import contextlib
import math
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.command import File, Folder, Json, panel
from harness.cli.command import options as grouped
from harness.cli.engine_options import CostOptions, ProgramOptions, with_restarts
from harness.cli.files import (
    output_folder,
    print_frame,
    print_json,
    print_wrapped,
    read_reference,
)
from harness.errors import RequestError
from harness.workflows.slurm_queue import ExecutorOptions

Executors = Annotated[ExecutorOptions, Parameter(name="*", group=panel("Where it runs"))]

if TYPE_CHECKING:
    from harness.cases.contract import LevelName
    from harness.workflows.study_run import StudyResult
    from harness.workflows.sweep_run import Executor

FAILED = 3
"""Exit status where a run died, or has no angle."""

MOST_SECONDS = 6 * 3600.0
"""On one core, without --force: the default level is expected to take 5.9 hours of it; its
runs took 14.6, on machines that did other work as well (reports/layers)."""


@grouped()
class StudyOptions(CostOptions, ProgramOptions):
    """Which study, how much of it, and where its report goes."""

    case: Annotated[str, Parameter(parse=False)] = ""
    quick: bool = False
    """Minutes on two cores: fewer seeds, smaller boxes."""
    full: bool = False
    """More of all; days of a core, for a cluster (`--executor slurm`)."""
    cost: bool = False
    """Run nothing of it: measure this machine for a minute, and tell what it would cost."""
    force: bool = False
    """Run also what is expected to take more than six hours of one core here."""
    reference: File = None
    """Measured angles for the figure: CSV with the columns h_over_d and theta_deg."""
    runs: File = None
    """The `runs.csv` of an earlier study, of this machine or another: what is done in it is not
    run again. The page names the file, and every version of an engine."""
    output: Folder = None
    """Folder of the report. [default: reports/runs/DATE-study]"""

    @property
    def level(self) -> LevelName:
        """Return how much is run; raise RequestError for both options."""
        if self.quick and self.full:
            raise RequestError("--quick and --full: give one of them only")
        if self.runs is not None and self.fresh:
            raise RequestError("--runs and --fresh: give one of them only")
        return "quick" if self.quick else "full" if self.full else "default"


def study(
    case: str,
    /,
    choice: StudyOptions = StudyOptions(),
    where: Executors = ExecutorOptions(),
    *,
    json: Json = False,
) -> int:
    """Answer a question with many runs of one case: rows, figures, a verdict in words.

    Runs that were made before are not made again, and a study that was killed goes on. The verdict
    follows from the numbers by a test that the report states.

    For example:

        dem-harness study layers --quick
        dem-harness study layers --reference measured.csv --output mine
        dem-harness study layers --runs reports/layers/runs.csv --output again

    Parameters
    ----------
    case
        A case that has a study: `layers`.
    """
    from harness.workflows import progress_bars
    from harness.workflows import study as run_study
    from harness.workflows.case_runs import usual_engine
    from harness.workflows.study_run import planned, study_of

    options = replace(choice, case=case)
    found_case, question = study_of(case)
    engine, level = usual_engine(found_case), options.level
    if options.cost:
        _print_cost(engine, options, where, json)
        return 0
    points = read_reference(options.reference) if options.reference else None
    executor_of = _executors(engine, options, where)
    runs, seconds = planned(case, level)
    work = f"the {runs} runs of study {case} (level {level}, what is kept counted as well)"
    most = MOST_SECONDS if where.executor == "local" else math.inf  # a cluster has its own limits
    options.agree(seconds, work, most, "--quick, --executor slurm")
    with (
        output_folder(options.output, "-study") as folder,
        _held(options, where),
        progress_bars("study", quiet=json) as progress,
    ):
        result = run_study(
            case,
            level,
            points=points,
            executor_of=executor_of,
            progress=progress,
            earlier=options.runs,
            least_ranks=where.ranks,
        )
        _write(result, folder, options.runs)
    record = {**result.to_json(), "output": str(folder)}
    if json:
        print_json(record)
    else:
        _print(record, question.columns)
    return FAILED if _without_result(result) else 0


def _held(options: StudyOptions, where: ExecutorOptions) -> contextlib.AbstractContextManager[None]:
    """Return what holds the folder of SLURM's jobs: another study in it would take them for its."""
    from harness.workflows.sweep_plan import SweepRequest
    from harness.workflows.sweep_run import held_sweep

    if where.executor == "local" or options.output is None:
        return contextlib.nullcontext()
    return held_sweep(
        _jobs(options.output), SweepRequest(options.case, {}, {"study": options.level})
    )


def _jobs(output: Path) -> Path:
    return output.with_name(f"{output.name}-jobs")


def _print_cost(engine: str, options: StudyOptions, where: ExecutorOptions, json: bool) -> None:
    import pandas as pd

    from harness.workflows.study_run import cost_of

    local = replace(where, executor="local")
    cost = cost_of(
        options.case,
        options.level,
        lambda ranks: _with_ranks(engine, options, local, ranks).open(engine),
        options.runs,
    )
    tables = {"measured": cost.measured, "rows": cost.rows}
    if json:
        rows = {name: [dict(row) for row in table] for name, table in tables.items()}
        print_json({"level": options.level, **rows, "model": cost.model})
        return
    for table in tables.values():
        print_frame(pd.DataFrame(table), 3)
    print_wrapped(f"model: {cost.model}")


def _executors(
    engine: str, options: StudyOptions, where: ExecutorOptions
) -> Callable[[int], Executor]:
    """Return a function from the ranks of a run to what makes such runs."""
    from harness.files import cache_place
    from harness.workflows.slurm import Slurm
    from harness.workflows.sweep_run import Local

    settings = where.settings()
    if settings is not None and options.output is None:
        raise RequestError("--executor slurm: needs --output, in a folder that the nodes see")
    entries = options.entries()

    def executor(ranks: int) -> Executor:
        chosen = _with_ranks(engine, options, where, ranks)
        local = Local(chosen.open, entries, options.fresh)
        if settings is None or options.output is None:
            return local
        cache = cache_place(options.cache).path if entries is not None else None
        of_job = replace(settings, ranks=max(settings.ranks, ranks))
        return Slurm(_jobs(options.output), of_job, local, chosen.opening, cache)

    return executor


def _with_ranks(
    engine: str, options: StudyOptions, where: ExecutorOptions, ranks: int
) -> StudyOptions:
    """Return the options of engines whose runs take so many ranks, each with time enough."""
    from harness.engines.programs import launcher_of
    from harness.workflows.slurm_queue import launcher_of_engine
    from harness.workflows.study_run import RUN_SECONDS

    options = with_restarts(options, [engine], RUN_SECONDS)
    ranks = max(ranks, where.ranks)
    launcher = options.mpirun
    if ranks > 1 and launcher is None:
        program = options.lmp or options.programs.get(engine)
        if where.executor == "slurm":
            launcher = launcher_of_engine(engine, options.opening(engine), ranks)
        else:
            launcher = launcher_of(ranks, program)
    return replace(options, mpirun=launcher)


def _write(result: StudyResult, folder: Path, earlier: Path | None) -> None:
    from harness.report.folder import Page, write_study
    from harness.workflows.sweep_run import as_frame

    page = Page(result.title, result.question, result.conclusion.verdict, _facts(result, earlier))
    tables = {"rows.csv": result.to_frame(), "runs.csv": as_frame(result.runs)}
    write_study(page, result.conclusion.sections, result.to_json(), tables, folder)


def _without_result(result: StudyResult) -> int:
    return result.count("failed") + result.count("undecided")


def _facts(result: StudyResult, earlier: Path | None) -> Mapping[str, str]:
    from harness import __version__

    versions = dict.fromkeys(row["engine_version"] for row in result.runs if row["engine_version"])
    level = "" if result.level == "default" else f" --{result.level}"
    # its name alone: where it lay is of no use to a reader, and names a machine
    level += "" if earlier is None else f" --runs {shlex.quote(earlier.name)}"
    missing = "; ".join(f"{name}: {reason}" for name, reason in result.missing.items())
    return {
        **({"not run": missing} if missing else {}),
        "command": f"dem-harness study {result.case}{level}",
        "engine": f"{result.engine} {', '.join(versions)}",
        "runs": f"{len(result.runs)}, {_without_result(result)} without a result"
        + (f", {result.taken} of them taken from an earlier study" if earlier else ""),
        "harness": __version__,
    }


def _print(record: Mapping[str, Any], columns: Sequence[str]) -> None:
    import pandas as pd

    for sentence in record["verdict"]:
        print_wrapped(f"- {sentence}")
    print_frame(pd.DataFrame(record["rows"])[list(columns)], 5)
    for name, reason in record["missing"].items():
        print_wrapped(f"{name}: not run: {reason}")
    print(f"report: {record['output']}/report.html")
