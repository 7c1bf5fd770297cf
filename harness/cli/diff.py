"""``dem-harness diff``."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

from harness.cli.command import Folder, Json
from harness.cli.files import print_json
from harness.report.plain import one_line

if TYPE_CHECKING:
    from harness.comparison.run_diff import RowDiff, RunDiff

SHOWN = 20
"""Rows that a terminal shows of those that moved without a change of verdict."""


def diff(before: Path, after: Path, /, *, output: Folder = None, json: Json = False) -> int:
    """Hold two verification runs side by side: what moved, and by how much.

    A move is told in the row's unit, in tolerances, and in uncertainties of both
    runs together. Engine, release, platform and scripts that differ are named.

    Exit status: 0 no verdict changed for the worse; 1 one did (a check that held
    fails or is not tested, a new one fails, or one is gone); what only one of two
    levels, plans or ways to run an engine has is not comparable, and worsens nothing;
    2 a folder is not a run.

    For example:

        dem-harness diff reports/runs/monday reports/runs/tuesday
        dem-harness diff before after --output page

    Parameters
    ----------
    before
        A report's folder, or its results.json.
    after
        The run to hold against it.
    output
        Folder for a page with both runs side by side; must not hold anything yet.
    """
    from harness.workflows import diff as hold

    if output is not None:
        from harness.files import check_folder

        check_folder(output)
    difference = hold(before, after)
    if output is not None:
        from harness.report.folder import write_diff

        write_diff(difference, before, after, output)
    if json:
        print_json(difference.to_json() | ({"folder": str(output)} if output else {}))
    else:
        _print(difference)
        if output is not None:
            print(f"page: {output / 'diff.html'}")
    return difference.status


def _print(difference: RunDiff) -> None:
    from rich.table import Table
    from rich.text import Text

    from harness.cli.verify import Printer
    from harness.comparison.run_diff import RowChange

    printer = Printer()
    for other in difference.metadata:
        digits = 12 if other.name.endswith("sha256") else None
        printer.line(f"{other.name}: {other.before[:digits]} -> {other.after[:digits]}")
    moved = [row for row in difference.rows if row.change is not RowChange.SAME]
    listed = [r for r in moved if r.worsens or r.change in (RowChange.WORSE, RowChange.BETTER)]
    listed += [row for row in moved if row not in listed][:SHOWN]
    table = Table("check", width=printer.width, show_lines=True)
    for name in ("before, after", "moved by"):
        table.add_column(name, justify="right", no_wrap=True)
    for row in listed:
        style = "bold red" if row.worsens else ""
        table.add_row(Text(_verdict_text(row), style, overflow="fold"), _ends(row), _moved(row))
    if listed:
        printer.table(table)
    if len(moved) > len(listed):
        printer.line(f"and {len(moved) - len(listed)} more; --json has all")
    printer.line(", ".join(f"{difference.count(change)} {change}" for change in RowChange))


def _verdict_text(row: RowDiff) -> str:
    """Return what became of a row, its name and kind, and its verdicts."""
    ends = (str(end.verdict) if end else "none" for end in (row.before, row.after))
    verdict = " -> ".join(dict.fromkeys(ends))
    return one_line(f"{row.change}: {row.row.name} ({row.row.kind}): {verdict}")


def _ends(row: RowDiff) -> str:
    """Return the values, a line each, the unit after the second."""
    before, after = (f"{end.value:.8g}" if end else "-" for end in (row.before, row.after))
    return f"{before}\n{after} {row.row.unit}".rstrip()


def _moved(row: RowDiff) -> str:
    lines = [f"{row.moved_by:+.2g}"]
    if math.isinf(row.in_tolerances):
        lines.append("none is allowed")
    else:
        lines.append(f"{row.in_tolerances:.2g} tolerances")
    lines.append(f"{row.in_uncertainties:.2g} uncertainties")
    return "\n".join(line for line in lines if "nan" not in line)
