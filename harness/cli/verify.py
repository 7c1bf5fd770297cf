"""``dem-harness verify``: its options, the kept or new verification, its verdicts in a terminal.

What failed stands first, findings and counts next, the headlines last.
"""

from __future__ import annotations

import math
import sys
import textwrap
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from harness.cli.command import File, Folder, Json, options
from harness.cli.engine_options import EngineOptions, LongRunOptions, runs_made
from harness.cli.files import (
    check_source,
    closed_pipe_allowed,
    output_folder,
    print_json,
)
from harness.errors import RequestError
from harness.report.plain import one_line

if TYPE_CHECKING:
    from rich.table import Table

    from harness.store.entries import Entries
    from harness.workflows.progress import Progress


MOST_FAILED, MOST_UNTESTED, MOST_FINDINGS = 40, 8, 5
"""Rows of each sort that are printed without --verbose."""

INSTEAD = "--quick or fewer cases"
"""What may be requested in place of a verification that takes too long."""

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
        for line in lines:
            self._console.print(line, style=style, soft_wrap=True)

    def table(self, table: Table) -> None:
        """Print a table, which has a width of its own."""
        self._console.print(table)

    def rows(self, checks: Sequence[Record], most: int, folder: Path | None = None) -> None:
        """Print checks, each with what happened; those beyond ``most`` are counted."""
        for check in checks[:most]:
            verdict = check["verdict"]
            kind = "" if check["kind"] == verdict else f" ({check['kind']})"
            self.line(f"{verdict}: {check['name']}{kind}", COLOURS[verdict])
            for text in details(check, folder):
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

    def headlines(self, headlines: Sequence[Record]) -> None:
        """Print what was expected and measured, as report.md has it."""
        from harness.observables.row import Row
        from harness.report.text import headline_lines

        for text in headline_lines([Row(**headline) for headline in headlines]):
            self.line(text, "bold")

    def outcome(self, record: Record) -> None:
        """Print in words whether the verdicts hold; a run that failed ends with this.

        In a strict run what was not tested fails as well. Green is only a run in which each row
        was judged and holds.
        """
        from harness.report.text import all_hold, nothing_tested

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


def details(check: Record, folder: Path | None) -> Iterator[str]:
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
    try:
        with path.open(encoding="utf-8", errors="replace") as file:
            first = file.readline(1000).strip()
    except OSError:
        return
    if first.startswith("# "):
        yield f"run it again: {first.removeprefix('# ')}"


@options()
class VerifyOptions(LongRunOptions):
    """What is to be verified: how much, against which baseline, and where the report goes."""

    quick: bool = False
    """A shorter ladder: some 20 s of CPU time, as many for the contacts."""
    full: bool = False
    """Up to 100 times the stiffness, every height: some two minutes for incline and tower."""
    cases: Annotated[str | None, Parameter(metavar="NAME[,NAME...]")] = None
    """Cases or groups that `dem-harness cases` lists, or `all`. [default: incline and tower]"""
    engines: Annotated[str | None, Parameter(metavar="all|NAME[,NAME...]")] = None
    """Hold other engines against theory and one another as well, or `all`, of which those that
    are missing are not tested. One that is named must be here."""
    only: Annotated[str, Parameter(metavar="PATTERN")] = ""
    """Run what matches, in all cases unless --cases names some: a shell-style pattern of a case, a
    submodel, a system, `case/submodel`, `case/submodel/system`, or a check, as `hertz*` or
    `*rim_speed_ratio`."""
    output: Folder = None
    """Folder for the report; must not hold anything yet. [default: reports/runs/ and the date]"""
    baseline: Folder = None
    """Baseline to compare with. [default: the committed one, reports/baseline]"""
    no_baseline: bool = False
    """Leave the comparison with a baseline out."""
    known_defects: File = None
    """Known defects beside the committed ones, TOML as in inputs/known-defects.toml."""
    strict: bool = False
    """Exit status 1 also where a check was not tested."""
    png: bool = False
    """Write every figure as PNG too, beside SVG."""
    verbose: bool = False
    """Print every check, not only those that failed."""

    @property
    def level(self) -> str:
        """Return the level by its name."""
        return "quick" if self.quick else "full" if self.full else "default"

    def check(self) -> None:
        """Raise RequestError for options that contradict one another or name no such file."""
        if self.quick and self.full:
            raise RequestError("--quick and --full: give one of them only")
        if self.baseline is not None and self.no_baseline:
            raise RequestError("--baseline and --no-baseline: give one of them only")
        check_source(self.known_defects, "--known-defects")
        check_source(self.baseline, "--baseline", folder=True)

    def check_level(self) -> None:
        """State the expected time of a long run; raise RequestError above the limit.

        Nothing is known of the part that a pattern selects.
        """
        from harness.workflows.engine_status import selected_engines
        from harness.workflows.estimate import verification_seconds
        from harness.workflows.verification import Selection, checked_level

        if self.only:
            return
        level = checked_level(self.level)
        names = Selection(self.cases).names(level)
        engines = 1 + len(selected_engines(self.engines or ()).named)
        seconds = verification_seconds(names, level, engines)
        self.check_duration(seconds, f"level {level} of {len(names)} cases", INSTEAD)


def verify(
    choice: VerifyOptions = VerifyOptions(),
    engine: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Do the main job: hold an engine against theory and the baseline, and write a report.

    Prints what failed, the verdicts counted by kind, and the headline, and leaves a folder with
    report.html, report.md, results.json, results.csv, the figures and the exact scripts that ran.

    What was verified before, with the same engine, code and platform, is not run
    again: the report kept of it is handed out, and said to be so. An interrupted
    verify goes on where it stopped.

    For example:

        dem-harness verify --quick --output mine
        dem-harness verify --engines all --cases incline,tower
    """
    from harness.workflows import progress_bars

    check_request(choice, engine)
    with output_folder(choice.output) as folder, progress_bars("verify", quiet=json) as progress:
        record = verified(choice, engine, folder, progress)
    with closed_pipe_allowed():
        if json:
            print_json({**record, "folder": str(folder)})
        else:
            print_verification(record, folder, verbose=choice.verbose)
    for error in record["engine_errors"] if record["status"] == 3 else ():
        print(f"dem-harness: {error}", file=sys.stderr)
    return int(record["status"])


def check_request(choice: VerifyOptions, engine: EngineOptions) -> None:
    """Raise RequestError for options that contradict one another and for unknown names."""
    from harness.workflows.verification import Selection, checked_level

    choice.check()
    engine.check_names((engine.engine, *engines_of(choice.engines)), "--engines")
    Selection(choice.cases).names(checked_level(choice.level))


def engines_of(wanted: str | None) -> tuple[str, ...]:
    """Return the requested engines; raise RequestError for one that is not known."""
    if wanted is None:
        return ()
    from harness.workflows.engine_status import selected_engines

    return selected_engines(wanted).engines


def verified(
    choice: VerifyOptions,
    engine: EngineOptions,
    folder: Path,
    progress: Progress,
) -> dict[str, Any]:
    """Verify, or take what was verified before; write the report and return its record.

    Raise RequestError, before anything is run, for a request that cannot be met.
    """
    from harness.store.entries import pack_verification

    entries = engine.entries()
    key = _key(choice, engine) if entries else None
    record = None if engine.fresh else _kept(entries, key, folder)
    if record is None:
        choice.check_level()
        record = _measured(choice, engine, folder, progress)
        if entries is not None and key is not None and not record["engine_errors"]:
            entries.put(key, pack_verification(folder, record))
    return record


def _key(choice: VerifyOptions, engine: EngineOptions) -> str | None:
    """Return the key of a verification; None with other engines, not all of which have a digest."""
    from harness.store.baseline import digest, with_further
    from harness.store.entries import verification_key
    from harness.workflows.verification import Selection, checked_level

    if choice.engines is not None:
        return None
    further = choice.known_defects
    with_further(further)  # a bad file is refused, whatever is kept
    names = Selection(choice.cases, choice.only).names(checked_level(choice.level))
    against = {} if choice.no_baseline else digest(choice.baseline)
    return verification_key(
        choice.level,
        cases=names,
        engine=engine.engine,
        context={
            "baseline": against,
            "strict": choice.strict,
            "png": choice.png,
            "only": choice.only,
            "further_defects": further and _digest(further),
        },
        **engine.opening(engine.engine, engine.integrator),
    )


def _digest(path: Path) -> str:
    from harness.store.entries import digest_of_files

    return digest_of_files([path], path.parent)


def _kept(entries: Entries | None, key: str | None, folder: Path) -> dict[str, Any] | None:
    """Write the report that is kept under a key and return its record, or None."""
    from harness.files import whole_folder
    from harness.store.entries import VERIFICATION_ERRORS, unpack_verification

    payload = entries.get(key) if entries and key else None
    if entries is None or key is None or payload is None:
        return None
    try:
        with whole_folder(folder) as aside:
            record = unpack_verification(payload, aside)
    except VERIFICATION_ERRORS as error:
        entries.drop(key, f"not a verification: {error}")
        return None
    return {**record, "cached": True, "engine_runs": 0, "engine_runs_from_cache": 0}


def _measured(
    choice: VerifyOptions,
    engine: EngineOptions,
    folder: Path,
    progress: Progress,
) -> dict[str, Any]:
    from harness.report.folder import write
    from harness.workflows import sections
    from harness.workflows import verify as verify_with
    from harness.workflows.verification import Selection, chosen_baseline

    accepted = not choice.no_baseline and chosen_baseline(choice.baseline)
    with engine.open(engine.engine, engine.integrator) as opened:
        if engine.lmp or engine.mpirun or engine.program:
            opened.identify()  # a program that was named and is another ends the command at once
        verification = verify_with(
            choice.level,
            cases=Selection(choice.cases, choice.only, defects=choice.known_defects),
            engine=opened,
            engines=choice.engines or (),
            open_one=engine.without_launcher().open,
            baseline=accepted,
            progress=progress,
            strict=choice.strict,
        )
        progress("figures and report", 0, 1)
        record = verification.to_json()
        write(verification, folder, sections(verification), png=choice.png)
        progress("figures and report", 1, 1)
        return {**record, "cached": False, **runs_made(opened)}
