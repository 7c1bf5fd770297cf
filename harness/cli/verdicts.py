"""Tell a verification in a terminal: what failed, findings, counts, and the headlines last."""

from __future__ import annotations

import math
import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from harness.report.plain import one_line

if TYPE_CHECKING:
    from rich.table import Table

MOST_FAILED, MOST_UNTESTED, MOST_FINDINGS = 40, 8, 5
"""Rows of each sort that are printed without --verbose."""

WIDEST = 120
COLOURS = {
    "pass": "green",
    "finding": "cyan",
    "not tested": "yellow",
    "fixed": "bold green",
    "known defect": "magenta",
    "fail": "bold red",
}
"""Of each verdict, in the order in which --verbose prints them."""

Record = Mapping[str, Any]


def print_verification(record: Record, folder: Path, *, verbose: bool = False) -> None:
    """Print the record of a verification; ``folder`` is where its report is."""
    printer = Printer()
    checks = record["checks"]
    if verbose:
        for verdict in COLOURS:
            printer.rows([c for c in checks if c["verdict"] == verdict], len(checks))
    else:
        printer.brief(checks, folder)
    printer.counts(checks)
    printer.headlines(record["headlines"])
    if record["cached"]:
        printer.line(
            f"from the cache: measured {record['started']}, {record['seconds']:.1f} s; --fresh "
            "runs it again"
        )
    printer.line(f"report: {folder / 'report.html'}", wrap=False)
    printer.outcome(record)


def print_regression(rows: Sequence[Record], where: str) -> None:
    """Print how many rows hold against the baseline, and those that do not, with their class."""
    printer = Printer()
    held = sum(check["verdict"] == "pass" for check in rows)
    printer.rows([c for c in rows if c["verdict"] == "fail"], MOST_FAILED)
    printer.rows([c for c in rows if c["verdict"] == "not tested"], MOST_UNTESTED)
    printer.line(f"regression: {held} of {len(rows)} rows hold against {where}")


class Printer:
    """Prints at the width of the terminal; colours where it has them."""

    def __init__(self, width: int | None = None) -> None:
        from rich.console import Console

        self._console = Console(highlight=False, markup=False, emoji=False, width=width)
        self.width = min(self._console.width, WIDEST)

    def line(self, text: str, style: str = "", *, indent: int = 0, wrap: bool = True) -> None:
        """Print text on lines that fit, those after the first two characters further in."""
        text = one_line(text).replace("±", "+-")
        lines = textwrap.wrap(
            text,
            self.width if wrap else len(text) + indent + 1,
            initial_indent=" " * indent,
            subsequent_indent=" " * (indent + 2),
            break_long_words=wrap,
            break_on_hyphens=False,
        )
        for one in lines:
            self._console.print(one, style=style, soft_wrap=True)

    def table(self, table: Table) -> None:
        """Print a table, which has a width of its own."""
        self._console.print(table)

    def rows(self, checks: Sequence[Record], most: int, folder: Path | None = None) -> None:
        """Print checks, each with what happened; those beyond ``most`` are counted."""
        for check in checks[:most]:
            verdict = check["verdict"]
            kind = "" if check["kind"] == verdict else f" ({check['kind']})"
            self.line(f"{verdict}: {check['name']}{kind}", COLOURS[verdict])
            for text in _said(check, folder):
                self.line(text, indent=4)
        if len(checks) > most:
            self.line(f"and {len(checks) - most} more: --verbose prints all")

    def brief(self, checks: Sequence[Record], folder: Path) -> None:
        """Print what failed, what was not tested, and the findings, some of each."""
        for verdict, most in (
            ("fail", MOST_FAILED),
            ("known defect", MOST_UNTESTED),
            ("fixed", MOST_UNTESTED),
            ("not tested", MOST_UNTESTED),
            ("finding", MOST_FINDINGS),
        ):
            self.rows([c for c in checks if c["verdict"] == verdict], most, folder)

    def counts(self, checks: Sequence[Record]) -> None:
        """Print a line for each kind: how many hold, how many were not tested."""
        for kind in dict.fromkeys(check["kind"] for check in checks):
            verdicts = [check["verdict"] for check in checks if check["kind"] == kind]
            held, failed = (verdicts.count(v) for v in ("pass", "fail"))
            text = f"{held} of {held + failed} hold" if held + failed else ""
            reported = verdicts.count("finding")
            apart = ("known defect", "fixed", "not tested")
            parts = [text, *(f"{verdicts.count(v)} {v}" for v in apart if v in verdicts)]
            parts.append(f"{reported} reported" if reported else "")
            self.line(f"{kind}: {', '.join(filter(None, parts))}")

    def headlines(self, told: Sequence[Record]) -> None:
        """Print what was expected and measured, as summary.md has it."""
        from harness.comparison.findings import Headline
        from harness.report.text import headline_lines

        for text in headline_lines([Headline(**one) for one in told]):
            self.line(text, "bold")

    def outcome(self, record: Record) -> None:
        """Print in words whether the verdicts hold; a run that failed ends with this.

        In a strict run what was not tested fails as well. Green is only a run in which each row
        was judged and holds.
        """
        from harness.report.verdict_summary import all_hold, nothing_tested

        verdicts = [check["verdict"] for check in record["checks"]]
        defects, untested = verdicts.count("known defect"), verdicts.count("not tested")
        failed = Counter(c["kind"] for c in record["checks"] if c["verdict"] == "fail")
        if record.get("strict") and untested:
            failed["not tested"] = untested
        why = [", ".join(f"{number} {kind}" for kind, number in failed.items())]
        if record["engine_errors"]:
            why.append("an engine could not be run or died")
        if record.get("untested_cases"):
            why.append(nothing_tested(record["untested_cases"]).lower())
        if any(why):
            self.line(f"FAILED: {'; '.join(filter(None, why))}", "bold red")
        elif "pass" in verdicts:
            self.line(all_hold(defects, untested), "yellow" if defects or untested else "green")
        else:
            self.line("Nothing was judged", "yellow")


def _said(check: Record, folder: Path | None) -> Iterator[str]:
    """Yield what is known of a check, a line each: the numbers, the class, the note, the log."""
    value, expected, unit = check["value"], check["expected"], check["unit"]
    if not math.isnan(value):
        text = f"{value:.8g} against {expected:.8g} {unit}".rstrip()
        allowed = check["tolerance"]
        limit = "" if math.isnan(allowed) else f", {allowed:.2g} allowed"
        yield f"{text}, {check['difference']:.2g} apart{limit}"
    if check["verdict"] != "pass":
        triage = "" if check["triage"] == check["verdict"] else check["triage"]
        yield from filter(None, (triage, check["note"]))
    if check["log"] and folder is not None:
        path = folder / "logs" / check["log"]
        yield from _command_of(path)
        yield f"log: {path}"


def _command_of(path: Path) -> Iterator[str]:
    """Yield the command that repeats a run, which the head of its log names."""
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            first = file.readline(1000).strip()
    except OSError:
        return
    if first.startswith("# "):
        yield f"run it again: {first.removeprefix('# ')}"
