"""``dem-harness inputs``, ``reproduce`` and ``site``: what a repository publishes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from harness.cli.command import Folder, Json, Name, options
from harness.cli.engine_options import EngineOptions
from harness.cli.files import (
    output_folder,
    print_json,
    print_line,
    print_record,
)
from harness.errors import RequestError

if TYPE_CHECKING:
    import pandas as pd

    from harness.reproduction.run import Reproduction

COMMITTED = Path("reports") / "reproduction"


@options()
class ReproduceOptions:
    """Where the report goes, or which one is checked."""

    output: Folder = None
    """Folder for the report, replaced where it holds an older reproduction. [default:
    reports/runs/DATE-reproduction; with --check reports/reproduction]"""
    check: bool = False
    """Write nothing: hold the ledger in the folder against what is computed now. Exit status 1 if
    a status, or a number beyond round-off, has changed."""


def reproduce(
    choice: ReproduceOptions = ReproduceOptions(),
    engine: EngineOptions = EngineOptions(),
    *,
    json: Json = False,
) -> int:
    """Recompute the source: every equation, number and figure, and whether it holds.

    Writes a folder with report.html, report.md, ledger.csv and the figures of the
    source from our own runs. A statement that does not hold is a finding, not a
    failure: exit status 0.

    For example:

        dem-harness reproduce --output mine
        dem-harness reproduce --check
    """
    from harness.reproduction.claims import ClaimStatus, ledger_differences

    differences: list[str] = []
    if choice.check:
        folder = choice.output or COMMITTED
        committed = _committed(folder)
        reproduction = _reproduced(engine, None, json)
        differences = ledger_differences(committed, reproduction.ledger.to_frame())
    elif choice.output is not None:
        folder = choice.output
        reproduction = _reproduced(engine, folder, json)
    else:
        with output_folder(None, "-reproduction") as folder:
            reproduction = _reproduced(engine, folder, json)
    ledger = reproduction.ledger
    counts = {status.name.lower(): ledger.count(status) for status in ClaimStatus}
    record = {"statements": len(ledger.statements), **counts, "folder": str(folder)}
    if json:
        print_json({**record, "differences": differences} if choice.check else record)
    else:
        print_record(record)
        for line in differences:
            print_line(line)
        if choice.check and not differences:
            print_line("the ledger is what is computed now")
    return 1 if differences else 0


def _reproduced(engine: EngineOptions, folder: Path | None, quiet: bool) -> Reproduction:
    from harness.reproduction.page import check_folder, write
    from harness.reproduction.run import reproduce as reproduce_with
    from harness.workflows import progress_bars

    if folder is not None:
        check_folder(folder)
    with progress_bars("reproduce", quiet=quiet) as progress, engine.run() as opened:
        reproduction = reproduce_with(engine=opened, progress=progress)
        if folder is not None:
            progress("figures and report", 0, 1)
            write(reproduction, folder)
            progress("figures and report", 1, 1)
    return reproduction


def _committed(folder: Path) -> pd.DataFrame:
    """Return the ledger of a folder; raise RequestError if there is none that can be read."""
    import pandas as pd

    path = folder / "ledger.csv"
    try:
        frame = pd.read_csv(path)
        frame[["key", "status", "printed", "found", "corrected", "tolerance"]]
    except OSError as error:
        raise RequestError(f"--output {folder}: no ledger.csv in it ({error.strerror})") from None
    except (ValueError, KeyError):
        raise RequestError(f"{path}: is not a ledger as dem-harness reproduce writes it") from None
    return frame


DEFAULT = Path("reports/runs/site")


def site(*runs: Path, output: Path = DEFAULT, json: Json = False) -> int:
    """Build a static site of the committed reports and of runs.

    It starts with the state of every code, case and release; then come verification, contacts,
    known defects (a page for each script), releases, bulk, layers, reproduction, LAMMPS's own
    tests, and what moved over time. It works offline and from any static host.

    For example:

        dem-harness site
        dem-harness site reports/runs/monday reports/runs/tuesday --output public

    Parameters
    ----------
    runs
        Folders that `verify --output` wrote; their pages join the site.
    output
        Folder of the site; an older site in it is replaced.
    """
    from harness.workflows import site as build

    built = build(output, runs)
    if json:
        print_json(built.to_json())
    else:
        print_record(built.summary())
    return 0


@options()
class InputsOptions:
    """Which scripts are written, and where."""

    folder: Annotated[Path | None, Parameter(metavar="DIR")] = None
    """Where the LAMMPS scripts are. [default: inputs]"""
    check: bool = False
    """Write nothing; fail (status 1) when a LAMMPS script differs or is missing."""
    engine: Name = None
    """Write the scripts of this engine instead, into the folder of --output."""
    output: Folder = None
    """Folder for the scripts of --engine; must not hold anything yet."""

    def check_together(self) -> None:
        """Raise RequestError for options that do not go together."""
        if self.engine is None and self.output is not None:
            raise RequestError(f"--output {self.output}: needs --engine NAME")
        if self.engine is not None and self.output is None:
            raise RequestError(f"--engine {self.engine}: needs --output DIR")
        if self.engine is not None and self.check:
            raise RequestError(f"--engine {self.engine}: does not go with --check")
        if self.engine is not None and self.folder is not None:
            raise RequestError(f"--folder {self.folder}: does not go with --engine")


def inputs(choice: InputsOptions = InputsOptions(), *, json: Json = False) -> int:
    """Write the generated LAMMPS scripts, or check that the written ones are up to date.

    With --engine and --output it writes the scripts of any engine into a new folder. They run
    with that engine alone.

    For example:

        dem-harness inputs --check
        dem-harness inputs --folder mine
        dem-harness inputs --engine yade --output scripts
    """
    from harness.workflows import engine_status as verb
    from harness.workflows import progress_bars

    choice.check_together()
    folder = choice.folder or Path("inputs")
    written: list[Path] = []
    outdated: dict[str, str] = {}
    with progress_bars("inputs", quiet=json):
        if choice.engine is not None and choice.output is not None:
            written = verb.inputs(choice.output, choice.engine)
        elif choice.check:
            outdated = verb.outdated_inputs(folder)
        else:
            written = verb.inputs(folder)
    if json:
        print_json({"up_to_date": not outdated, "outdated": outdated} if choice.check
                   else {"written": [str(path) for path in written]})  # fmt: skip
    elif not choice.check:
        print("\n".join(map(str, written)))
    else:
        print("\n".join(f"{folder / name}: {difference}" for name, difference in outdated.items())
              or f"{folder}: every script is what would be written")  # fmt: skip
    return 1 if outdated else 0
