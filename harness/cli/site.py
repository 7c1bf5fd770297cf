"""``dem-harness site``."""

from __future__ import annotations

from pathlib import Path

from harness.cli.command import Json
from harness.cli.files import print_json, print_record

DEFAULT = Path("reports/runs/site")


def site(*runs: Path, output: Path = DEFAULT, history: bool = False, json: Json = False) -> int:
    """Build a static site of the committed reports and of runs.

    It starts with the state of every code, case and release; then come verification, contacts,
    known defects (a page each), releases, layers, reproduction, LAMMPS's own tests, and what moved
    over time. It works offline and from any static host, below any address.

    For example:

        dem-harness site
        dem-harness site reports/runs/monday reports/runs/tuesday --output public

    Parameters
    ----------
    runs
        Folders that `verify --output` wrote; their pages join the site.
    output
        Folder of the site; an older site in it is replaced.
    history
        Look through the recorded runs of this machine for what moved.
    """
    from harness.workflows import site as build

    built = build(output, runs, history=history)
    if json:
        print_json(built.to_json())
    else:
        print_record(built.summary())
    return 0
