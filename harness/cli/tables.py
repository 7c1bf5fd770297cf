"""Tables for the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from harness.comparison.verdicts import Check
    from harness.comparison.verification import Verification

COLOURS = {"pass": "green", "fail": "bold red", "not tested": "yellow", "finding": "cyan"}


def print_verification(found: Verification, folder: Path) -> None:
    """Print the checks as one table a kind, the headline, and where the report is."""
    from rich.console import Console
    from rich.table import Table

    from harness.comparison.verdicts import Kind

    console = Console(width=None if Console().is_terminal else 120)
    for kind in Kind:
        rows = [check for check in found.checks if check.kind is kind]
        if not rows:
            continue
        if kind is Kind.REGRESSION:
            print_regression(rows, found.baseline, console)
            continue
        table = Table(title=str(kind), title_justify="left", title_style="bold")
        table.add_column("check", overflow="fold")
        for name in ("value", "expected", "difference", "tolerance"):
            table.add_column(name, justify="right", no_wrap=True)
        table.add_column("", no_wrap=True)
        table.add_column("verdict", no_wrap=True)
        for check in rows:
            colour = COLOURS[check.verdict]
            table.add_row(*_cells(check), f"[{colour}]{check.verdict}[/]")
            for said in filter(None, (check.triage, check.note)):
                if check.verdict in ("fail", "not tested"):
                    table.add_row(f"  {said}", *[""] * 6)
        console.print(table)
    console.print(*headline(found), sep="\n")
    console.print(f"report: {folder / 'report.html'}", soft_wrap=True)


def print_regression(rows: Sequence[Check], where: str, console: Console | None = None) -> None:
    """Print how many rows hold against the baseline, and those that do not, with their class."""
    from rich.console import Console
    from rich.table import Table

    from harness.comparison.verdicts import Verdict

    console = console or Console(width=None if Console().is_terminal else 120)
    held = sum(check.verdict is Verdict.PASS for check in rows)
    console.print(f"regression: {held} of {len(rows)} rows hold against {where}", soft_wrap=True)
    failed = [check for check in rows if check.verdict is Verdict.FAIL]
    untested = [check for check in rows if check.verdict is Verdict.NOT_TESTED]
    if failed:
        table = Table("row", "value", "difference", "tolerance", "", "class of failure")
        for check in failed:
            name, value, _, *others = _cells(check)
            triage = f"{check.triage}\n{check.note}" if check.note else check.triage
            table.add_row(name.removeprefix("baseline: "), value, *others, triage)
        console.print(table)
    for check in untested:
        console.print(f"not tested: {check.name}: {check.note}", soft_wrap=True)


def headline(found: Verification) -> list[str]:
    """Return the two lines that matter: theory and LAMMPS, with its uncertainty."""
    lines = [f"theory   {found.incline.closed_form_deg:.6f} deg (closed form)"]
    if found.incline.extrapolated:
        angle = found.incline.extrapolated
        lines.append(
            f"LAMMPS   {angle.value_deg:.6f} +- {angle.uncertainty_deg:.6f} deg "
            "(plastic contact, step to zero, stiffness to infinity)"
        )
    return lines


def _cells(check: Check) -> list[str]:
    numbers = [f"{check.value:.7g}", f"{check.expected:.7g}", f"{check.difference:.2g}"]
    width = "" if math.isnan(check.tolerance) else f"{check.tolerance:.2g}"
    return [check.name, *numbers, width, check.unit]
