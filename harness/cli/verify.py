"""``dem-harness verify``."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from harness.cli.options import EngineName, Json, Lmp, Mpirun, Tolerances


def verify(
    quick: Annotated[
        bool, typer.Option("--quick", help="A shorter ladder: under 20 s on two cores.")
    ] = False,
    full: Annotated[
        bool,
        typer.Option(
            "--full", help="Up to 100 times the stiffness, every height: some two minutes."
        ),
    ] = False,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            metavar="DIR",
            help="Folder for the report; must not hold anything yet.  "
            "[default: reports/runs/ and the date]",
        ),
    ] = None,
    baseline: Annotated[
        Path | None,
        typer.Option(
            "--baseline",
            metavar="DIR",
            help="Baseline to compare with.  [default: the committed one, reports/baseline]",
        ),
    ] = None,
    no_baseline: Annotated[
        bool, typer.Option("--no-baseline", help="Leave the comparison with a baseline out.")
    ] = False,
    tolerances: Tolerances = None,
    engine: EngineName = "lammps",
    lmp: Lmp = None,
    mpirun: Mpirun = None,
    json: Json = False,
) -> None:
    """Do the main job: hold LAMMPS against theory and the baseline, and write a report.

    Prints the verdicts and leaves a folder with report.html, report.md,
    results.json, results.csv, the figures and the exact scripts that ran.
    """
    from harness.cli.output import print_json
    from harness.cli.progress import progress_bars
    from harness.cli.tables import print_verification
    from harness.engines.registry import open_engine
    from harness.errors import RequestError
    from harness.report.folder import check_folder, write
    from harness.verbs.verification import verify as verify_with
    from harness.verbs.verification.run import chosen_baseline

    if quick and full:
        raise RequestError("--quick and --full: give one of them only")
    folder = output or Path("reports") / "runs" / datetime.now().strftime("%Y-%m-%d-%H%M%S")
    if baseline is not None and no_baseline:
        raise RequestError("--baseline and --no-baseline: give one of them only")
    known = None if no_baseline else chosen_baseline(baseline, tolerances)
    check_folder(folder)
    level = "quick" if quick else "full" if full else "default"
    with progress_bars() as progress, open_engine(engine, lmp=lmp, launcher=mpirun) as opened:
        found = verify_with(
            level, engine=opened, progress=progress, baseline=known, compare=not no_baseline
        )
        progress("figures and report", 0, 1)
        write(found, folder)
        progress("figures and report", 1, 1)
    if json:
        print_json({**found.record(), "folder": str(folder)})
    else:
        print_verification(found, folder)
    raise typer.Exit(found.status)
