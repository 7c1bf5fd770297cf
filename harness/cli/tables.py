"""Tables for the terminal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console

COLOURS = {"pass": "green", "fail": "bold red", "not tested": "yellow", "finding": "cyan"}


def print_verification(record: Mapping[str, Any], folder: Path) -> None:
    """Print the checks of a verification's record, the headline, and where the report is."""
    from rich.console import Console
    from rich.table import Table

    from harness.comparison.verdicts import Kind

    console = Console(width=None if Console().is_terminal else 120)
    for kind in Kind:
        rows = [check for check in record["checks"] if check["kind"] == kind]
        if not rows:
            continue
        if kind is Kind.REGRESSION:
            print_regression(rows, record["baseline"], console)
            continue
        table = Table(title=str(kind), title_justify="left", title_style="bold")
        table.add_column("check", overflow="fold")
        for name in ("value", "expected", "difference", "tolerance"):
            table.add_column(name, justify="right", no_wrap=True)
        table.add_column("", no_wrap=True)
        table.add_column("verdict", no_wrap=True)
        for check in rows:
            verdict = check["verdict"]
            table.add_row(*_cells(check), f"[{COLOURS[verdict]}]{verdict}[/]")
            for said in filter(None, (check["triage"], check["note"])):
                if verdict in ("fail", "not tested"):
                    table.add_row(f"  {said}", *[""] * 6)
        console.print(table)
    console.print(*headline(record), sep="\n")
    console.print(f"report: {folder / 'report.html'}", soft_wrap=True)
    if record["cached"]:
        started = f"{record['started']}, {record['seconds']:.1f} s"
        console.print(f"from the cache: measured {started}; --fresh runs it again", soft_wrap=True)


def print_regression(
    rows: Sequence[Mapping[str, Any]], where: str, console: Console | None = None
) -> None:
    """Print how many rows hold against the baseline, and those that do not, with their class."""
    from rich.console import Console
    from rich.table import Table

    console = console or Console(width=None if Console().is_terminal else 120)
    held = sum(check["verdict"] == "pass" for check in rows)
    console.print(f"regression: {held} of {len(rows)} rows hold against {where}", soft_wrap=True)
    failed = [check for check in rows if check["verdict"] == "fail"]
    untested = [check for check in rows if check["verdict"] == "not tested"]
    if failed:
        table = Table("row", "value", "difference", "tolerance", "", "class of failure")
        for check in failed:
            name, value, _, *others = _cells(check)
            triage = "\n".join(filter(None, (check["triage"], check["note"])))
            table.add_row(name.removeprefix("baseline: "), value, *others, triage)
        console.print(table)
    for check in untested:
        console.print(f"not tested: {check['name']}: {check['note']}", soft_wrap=True)


def headline(record: Mapping[str, Any]) -> list[str]:
    """Return the two lines that matter: theory and LAMMPS, with its uncertainty."""
    lines = [f"theory   {record['closed_form_deg']:.6f} deg (closed form)"]
    angle = record["extrapolated"]
    if angle:
        lines.append(
            f"LAMMPS   {angle['critical_angle_deg']:.6f} +- {angle['uncertainty_deg']:.6f} deg "
            "(plastic contact, step to zero, stiffness to infinity)"
        )
    return lines


def _cells(check: Mapping[str, Any]) -> list[str]:
    numbers = [f"{check[key]:.{n}g}" for key, n in _DIGITS.items()]
    width = "" if math.isnan(check["tolerance"]) else f"{check['tolerance']:.2g}"
    return [check["name"], *numbers, width, check["unit"]]


_DIGITS = {"value": 7, "expected": 7, "difference": 2}
