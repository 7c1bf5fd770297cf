"""``dem-harness inputs``."""

from __future__ import annotations

from pathlib import Path

from harness.cli.command import Json
from harness.cli.files import print_json


def inputs(*, folder: Path = Path("inputs"), check: bool = False, json: Json = False) -> int:
    """Write the generated LAMMPS scripts, or check that the written ones are up to date.

    For example:

        dem-harness inputs --check
        dem-harness inputs --folder mine

    Parameters
    ----------
    folder
        Where the scripts are.
    check
        Write nothing; fail (status 1) when a script differs or is missing.
    """
    from harness.workflows import engine_status as verb
    from harness.workflows import progress_bars

    with progress_bars("inputs", quiet=json):
        written = [] if check else [str(path) for path in verb.inputs(folder)]
        outdated = verb.outdated_inputs(folder) if check else {}
    if json:
        print_json({"up_to_date": not outdated, "outdated": outdated} if check
                   else {"written": written})  # fmt: skip
    elif not check:
        print("\n".join(written))
    else:
        print("\n".join(f"{folder / name}: {difference}" for name, difference in outdated.items())
              or f"{folder}: every script is what would be written")  # fmt: skip
    return 1 if outdated else 0
