"""``dem-harness reproduce``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli.engine_options import EngineOptions
from harness.cli.options import Json

if TYPE_CHECKING:
    import pandas as pd

    from harness.reproduction.claims import Ledger
    from harness.reproduction.run import Reproduction

COMMITTED = Path("reports") / "reproduction"


def reproduce(
    engine: EngineOptions,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="DIR",
            help="Folder for the report, replaced where it holds an older reproduction.  "
            "[default: reports/runs/<date>-reproduction; with --check reports/reproduction]",
        ),
    ] = None,
    check: Annotated[
        bool,
        typer.Option(
            "--check",
            help="Write nothing: hold the ledger in the folder against what is computed now. "
            "Exit status 1 if a status, or a number beyond round-off, has changed.",
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Recompute the source: every equation, number and figure, and whether it holds.

    Writes a folder with report.html, report.md, ledger.csv, the figures of the
    source from our own runs, movies, and dump files for OVITO. A statement that
    does not hold is a finding, not a failure: exit status 0.
    """
    from harness.cli.files import output_folder
    from harness.cli.output import print_json
    from harness.reproduction.ledger_differences import ledger_differences

    if check:
        folder = output or COMMITTED
        committed = _committed(folder)
        found = _reproduced(engine, None)
        differences = ledger_differences(committed, found.ledger.frame())
    elif output is not None:
        folder, differences = output, []
        found = _reproduced(engine, folder)
    else:
        with output_folder(None, "-reproduction") as folder:
            found, differences = _reproduced(engine, folder), []
    record = {**_counts(found.ledger), "folder": str(folder)}
    if check:
        record["differences"] = differences
    if json:
        print_json(record)
    else:
        _print(record)
    raise typer.Exit(1 if differences else 0)


def _reproduced(engine: EngineOptions, folder: Path | None) -> Reproduction:
    """Recompute the source and write the report, where a folder is given for it."""
    from harness.cli.progress import progress_bars
    from harness.cli.recording import recorded
    from harness.reproduction.pages.folder import check_folder, write
    from harness.reproduction.run import reproduce as reproduce_with

    if folder is not None:
        check_folder(folder)
    with recorded("reproduce") as told, progress_bars() as progress, engine.run() as opened:
        found = reproduce_with(engine=opened, progress=progress)
        told.engine, told.folder = found.provenance.record(), folder
        if folder is not None:
            progress("figures, movies and report", 0, 1)
            write(found, folder)
            progress("figures, movies and report", 1, 1)
    return found


def _committed(folder: Path) -> pd.DataFrame:
    """Return the ledger of a folder; raise RequestError if there is none that can be read."""
    import pandas as pd

    from harness.errors import RequestError

    path = folder / "ledger.csv"
    try:
        frame = pd.read_csv(path)
        frame[["key", "status", "printed", "found", "corrected", "tolerance"]]
    except OSError as error:
        raise RequestError(f"--output {folder}: no ledger.csv in it ({error.strerror})") from None
    except (ValueError, KeyError):
        raise RequestError(f"{path}: is not a ledger as dem-harness reproduce writes it") from None
    return frame


def _counts(ledger: Ledger) -> dict[str, Any]:
    from harness.reproduction.claims import ClaimStatus

    counts = {status.name.lower(): ledger.count(status) for status in ClaimStatus}
    return {"statements": len(ledger.statements), **counts}


def _print(record: dict[str, Any]) -> None:
    from harness.cli.output import print_record

    differences = record.pop("differences", None)
    print_record(record)
    for line in differences or []:
        typer.echo(line)
    if differences == []:
        typer.echo("the ledger is what is computed now")
