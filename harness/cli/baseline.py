"""``dem-harness baseline``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import App, Parameter

from harness.cli.command import File, Folder, Json, Level, options
from harness.cli.engine_options import EngineOptions
from harness.cli.files import check_source, print_json, print_line

if TYPE_CHECKING:
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

    def run(
        self, engine: EngineOptions, tolerances: Path | None, quiet: bool
    ) -> BaselineComparison:
        """Run the cases and compare; the run is recorded."""
        from harness.cli.recording import recorded
        from harness.workflows.baseline import compare_with_baseline

        with recorded("baseline", quiet=quiet) as recording, engine.run() as opened:
            compared = compare_with_baseline(
                self.level,
                cases=self.cases,
                baseline=self.baseline,
                tolerances=tolerances,
                engine=opened,
                progress=recording.progress,
            )
            recording.status = compared.status
            recording.engine = (
                compared.verification.provenance.to_json()
                if compared.verification.provenance
                else {}
            )
            recording.quantities = compared.checks
        return compared


@options()
class CompareOptions(BaselineOptions):
    """As those of both commands, and how far a quantity may move."""

    tolerances: File = None
    """Named overrides of the regression tolerances beside those of inputs/tolerances.toml, TOML."""


@options()
class AcceptOptions(BaselineOptions):
    """As those of both commands, and the consent."""

    yes: bool = False
    """Write without asking."""


def compare(
    choice: CompareOptions = CompareOptions(),
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
    from harness.cli.verify import print_regression

    check_source(choice.baseline, "--baseline", folder=True)
    check_source(choice.tolerances, "--tolerances")
    compared = choice.run(engine, choice.tolerances, json)
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
    compared = choice.run(engine, None, json)
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
