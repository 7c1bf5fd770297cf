"""``dem-harness baseline`` and ``diff``: a run against accepted values, or against another run."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from harness.cli.command import Folder, Json, Level, options
from harness.cli.engine_options import EngineOptions
from harness.cli.files import check_source, print_json, print_line
from harness.cli.verify import Printer, print_regression
from harness.report.plain import one_line

if TYPE_CHECKING:
    from harness.comparison.run_diff import RowDiff, RunDiff
    from harness.workflows.baseline import BaselineComparison

baseline = App(name="baseline", help="Compare with the baseline, or accept a new one.")


@options()
class BaselineOptions:
    """Which cases are run, and which baseline they are held against."""

    level: Level = "default"
    """How much of each case: that of `verify`."""
    cases: Annotated[str | None, Parameter(metavar="NAME[,NAME...]")] = None
    """Cases or groups that `dem-harness cases` lists, or `all`. [default: incline and tower]"""
    baseline: Folder = None
    """Folder of the baseline. [default: reports/baseline of this project, or the installed
    package's own]"""

    def run(self, engine: EngineOptions, quiet: bool) -> BaselineComparison:
        """Run the cases and compare."""
        from harness.workflows import compare_with_baseline, progress_bars

        with progress_bars("baseline", quiet=quiet) as progress, engine.run() as opened:
            return compare_with_baseline(
                self.level,
                cases=self.cases,
                baseline=self.baseline,
                engine=opened,
                progress=progress,
            )


@options()
class AcceptOptions(BaselineOptions):
    """As those of both commands, and the consent."""

    yes: bool = False
    """Write without asking."""


def compare(
    choice: BaselineOptions = BaselineOptions(),
    engine: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Run the cases and hold each quantity against the baseline.

    A failed row says of what class it is: diverged from the first step, diverged
    late (and when), wrong input, engine error, NaN, out of time, out of memory.

    For example:

        dem-harness baseline compare --level quick
        dem-harness baseline compare --baseline mine --json
    """
    check_source(choice.baseline, "--baseline", folder=True)
    compared = choice.run(engine, json)
    if json:
        print_json(compared.to_json())
    else:
        rows = [check.to_json() for check in compared.checks]
        print_regression(rows, compared.verification.baseline)
    return compared.status


def accept(
    choice: AcceptOptions = AcceptOptions(),
    engine: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Run the cases, show what would change in the baseline, and write it if told to.

    Asks on a terminal; without one, and without --yes, nothing is written.

    For example:

        dem-harness baseline accept --baseline mine
        dem-harness baseline accept --cases contacts --level full --yes
    """
    from harness.workflows.baseline import accept_baseline, where_to_accept

    target = where_to_accept(choice.baseline)
    compared = choice.run(engine, json)
    if not json:
        _print_changes(compared)
    written = bool(compared.changes) and (choice.yes or (not json and _agreed(compared, target)))
    if written:
        accept_baseline(compared, target)
    if json:
        print_json({**compared.to_json(), "written": written, "folder": str(target)})
    elif written:
        print(f"{target}: {len(compared.changes)} records written")
    elif compared.changes:
        print(f"{target}: nothing written; --yes writes it")
    return 0


baseline.command(compare)
baseline.command(accept)


def _agreed(compared: BaselineComparison, target: Path) -> bool:
    """Ask on a terminal; no where there is nobody to ask."""
    import sys

    if sys.stdin is None or not sys.stdin.isatty():
        return False
    question = f"Write {len(compared.changes)} records into {target}? [y/N]: "
    return input(question).strip().lower() in ("y", "yes")


def _print_changes(compared: BaselineComparison) -> None:
    if not compared.changes:
        print("the baseline is what would be written")
    for change in compared.changes:
        print_line(f"{change.kind}: {change.measured.name}")
        for line in change.lines:
            print_line(line, indent=4)


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
