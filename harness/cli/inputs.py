"""``dem-harness inputs``."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import typer

from harness.cli.command import Json
from harness.cli.files import print_json


@dataclass(frozen=True)
class InputsOptions:
    """Where the scripts are, and whether they are written."""

    folder: Path = Path("inputs")
    check: bool = False


def inputs(asked: InputsOptions, json: Json = False) -> None:
    """Write the generated LAMMPS scripts, or check that the written ones are up to date."""
    from harness.workflows import engine_status as verb
    from harness.workflows import progress_bars

    with progress_bars("inputs", quiet=json):
        written = [] if asked.check else [str(path) for path in verb.inputs(asked.folder)]
        outdated = verb.outdated_inputs(asked.folder) if asked.check else {}
    if not asked.check:
        if json:
            print_json({"written": written})
        else:
            print("\n".join(written))
        return
    if json:
        print_json({"up_to_date": not outdated, "outdated": outdated})
    elif outdated:
        print("\n".join(f"{asked.folder / name}: {what}" for name, what in outdated.items()))
    else:
        print(f"{asked.folder}: every script is what would be written")
    raise typer.Exit(1 if outdated else 0)
