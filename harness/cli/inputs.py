"""``dem-harness inputs``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.options import Json


def inputs(
    folder: Annotated[Path, typer.Option("--folder", help="Where the scripts are.")] = Path(
        "inputs"
    ),
    check: Annotated[
        bool,
        typer.Option(
            "--check", help="Write nothing; fail (status 1) when a script differs or is missing."
        ),
    ] = False,
    json: Json = False,
) -> None:
    """Write the generated LAMMPS scripts, or check that the written ones are up to date."""
    from harness.cli.output import print_json
    from harness.workflows import scripts as verb

    if not check:
        written = [str(path) for path in verb.inputs(folder)]
        if json:
            print_json({"written": written})
        else:
            print("\n".join(written))
        return
    outdated = verb.outdated_inputs(folder)
    if json:
        print_json({"up_to_date": not outdated, "outdated": outdated})
    elif outdated:
        print("\n".join(f"{folder / name}: {what}" for name, what in outdated.items()))
    else:
        print(f"{folder}: every script is what would be written")
    raise typer.Exit(1 if outdated else 0)
