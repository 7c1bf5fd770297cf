"""``dem-harness diff``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from harness.cli.options import Json

if TYPE_CHECKING:
    from harness.comparison.run_diff import RunDiff

SHOWN = 20
"""Rows that a terminal shows of those that moved without a change of verdict."""


def diff(
    before: Annotated[
        Path, typer.Argument(metavar="RUN", help="A report's folder, or its results.json.")
    ],
    after: Annotated[Path, typer.Argument(metavar="RUN", help="The run to hold against it.")],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="DIR",
            help="Folder for a page with both runs side by side; must not hold anything yet.",
        ),
    ] = None,
    json: Json = False,
) -> None:
    """Hold two verification runs side by side: what moved, and by how much.

    A move is told in the row's unit, in tolerances, and in uncertainties of both
    runs together. Engine, release, platform and scripts that differ are named.

    Exit status: 0 no verdict changed for the worse; 1 one did (a check that held
    fails or is not tested, a new one fails, or one is gone at the same level);
    2 a folder is not a run.
    """
    from harness.cli.output import print_json
    from harness.workflows import diff as hold

    if output is not None:
        from harness.report.target import check_folder

        check_folder(output)
    found = hold(before, after)
    if output is not None:
        from harness.report.diff_folder import write_diff

        write_diff(found, before, after, output)
    if json:
        print_json(found.record() | ({"folder": str(output)} if output else {}))
    else:
        _print(found)
        if output is not None:
            print(f"page: {output / 'diff.html'}")
    raise typer.Exit(found.status)


def _print(found: RunDiff) -> None:
    """Print what is not the same beside the checks, the rows that moved, and the counts."""
    import math

    from rich.console import Console
    from rich.table import Table

    from harness.comparison.run_diff import Change

    console = Console(width=None if Console().is_terminal else 140)
    for other in found.metadata:
        console.print(f"{other.name}: {other.before} -> {other.after}", markup=False)
    moved = [row for row in found.rows if row.change is not Change.SAME]
    shown = [r for r in moved if r.worsens or r.change in (Change.WORSE, Change.BETTER)]
    shown += [row for row in moved if row not in shown][:SHOWN]
    if shown:
        table = Table("change", "check", "kind", "verdict")
        for name in ("before", "after", "moved by", "in tolerances", "in uncertainties"):
            table.add_column(name, justify="right", no_wrap=True)
        for row in shown:
            ends = (row.before, row.after)
            verdict = " -> ".join(
                dict.fromkeys(str(end.verdict) if end else "none" for end in ends)
            )
            numbers = [f"{end.value:.8g}" if end else "" for end in ends]
            moves = (row.moved_by, row.in_tolerances, row.in_uncertainties)
            colour = "[bold red]" if row.worsens else ""
            table.add_row(
                f"{colour}{row.change}",
                row.row.name,
                str(row.row.kind),
                verdict,
                *numbers,
                *("" if math.isnan(move) else f"{move:.2g}" for move in moves),
            )
        console.print(table)
    if len(moved) > len(shown):
        console.print(f"and {len(moved) - len(shown)} more; --json has all")
    console.print(", ".join(f"{found.count(change)} {change}" for change in Change))
