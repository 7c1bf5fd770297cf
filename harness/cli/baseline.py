"""``dem-harness baseline``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from harness.cli.cached_engines import Cache, Chosen, Fresh
from harness.cli.options import EngineName, Json, Lmp, Mpirun, Tolerances

if TYPE_CHECKING:
    from harness.workflows.baseline import BaselineComparison

baseline = typer.Typer(
    name="baseline",
    help="Compare with the baseline, or accept a new one.",
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
)


class LevelName(StrEnum):
    """The levels of ``verify``."""

    QUICK = "quick"
    DEFAULT = "default"
    FULL = "full"


Level = Annotated[LevelName, typer.Option("--level", help="Which cases: those of `verify`.")]

Folder = Annotated[
    Path | None,
    typer.Option(
        "--baseline",
        metavar="DIR",
        help="Folder of the baseline.  [default: reports/baseline of this project, or the "
        "installed package's own]",
    ),
]


@baseline.command()
def compare(
    level: Level = LevelName.DEFAULT,
    folder: Folder = None,
    tolerances: Tolerances = None,
    engine: EngineName = "lammps",
    lmp: Lmp = None,
    mpirun: Mpirun = None,
    cache: Cache = None,
    fresh: Fresh = False,
    json: Json = False,
) -> None:
    """Run the cases and hold each quantity against the baseline.

    A failed row says of what class it is: diverged from the first step, diverged
    late (and when), wrong input, engine error, NaN, out of time, out of memory.
    """
    from harness.cli.output import print_json
    from harness.errors import RequestError

    if folder is not None and not folder.is_dir():
        raise RequestError(f"--baseline {folder}: no such folder")
    how = _How(level, Chosen(engine, lmp, mpirun), cache, fresh)
    compared = _run(how, folder, tolerances)
    if json:
        print_json(compared.record())
    else:
        _print_rows(compared)
    raise typer.Exit(compared.status)


@baseline.command()
def accept(
    level: Level = LevelName.DEFAULT,
    folder: Folder = None,
    yes: Annotated[bool, typer.Option("--yes", help="Write without asking.")] = False,
    engine: EngineName = "lammps",
    lmp: Lmp = None,
    mpirun: Mpirun = None,
    cache: Cache = None,
    fresh: Fresh = False,
    json: Json = False,
) -> None:
    """Run the cases, show what would change in the baseline, and write it if told to.

    Asks on a terminal; without one, and without --yes, nothing is written.
    """
    import sys

    from harness.cli.output import print_json
    from harness.workflows.baseline import accept_baseline, where_to_accept

    target = where_to_accept(folder)
    compared = _run(_How(level, Chosen(engine, lmp, mpirun), cache, fresh), folder, None)
    if not json:
        _print_changes(compared)
    agreed = yes
    if compared.changes and not yes and not json and sys.stdin.isatty():
        agreed = typer.confirm(f"Write {len(compared.changes)} cases into {target}?")
    written = agreed and bool(compared.changes)
    if written:
        accept_baseline(compared, target)
    if json:
        print_json({**compared.record(), "written": written, "folder": str(target)})
    elif written:
        print(f"{target}: {len(compared.changes)} cases written")
    elif compared.changes:
        print(f"{target}: nothing written; --yes writes it")


class _How(NamedTuple):
    """What is run, in which engine, and what of it may be taken from the cache."""

    level: LevelName
    chosen: Chosen
    cache: Path | None
    fresh: bool


def _run(how: _How, folder: Path | None, tolerances: Path | None) -> BaselineComparison:
    from harness.cli.cached_engines import open_cached_engine, open_entries
    from harness.cli.progress import progress_bars
    from harness.cli.recording import recorded, verdicts
    from harness.workflows.baseline import compare_with_baseline

    remembered = open_cached_engine(how.chosen, open_entries(how.cache), how.fresh)
    with recorded("baseline") as told, progress_bars() as progress, remembered as opened:
        compared = compare_with_baseline(
            how.level.value,
            baseline=folder,
            tolerances=tolerances,
            engine=opened,
            progress=progress,
        )
        told.status = compared.status
        told.engine = compared.found.provenance.record() if compared.found.provenance else {}
        told.quantities = verdicts([check.record() for check in compared.checks])
    return compared


def _print_rows(compared: BaselineComparison) -> None:
    from harness.cli.tables import print_regression

    rows = [check.record() for check in compared.checks]
    print_regression(rows, compared.found.baseline)


def _print_changes(compared: BaselineComparison) -> None:
    if not compared.changes:
        print("the baseline is what would be written")
    for change in compared.changes:
        print(f"{change.kind}: {change.case.name}")
        for line in change.lines:
            print(f"    {line}")
