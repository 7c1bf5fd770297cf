"""``dem-harness engines``."""

from __future__ import annotations

from harness.cli.command import Json
from harness.cli.engine_options import WhereOptions
from harness.cli.files import print_columns, print_json


def engines(where: WhereOptions = WhereOptions(), *, json: Json = False) -> int:
    """Which engines are here, in which version, how they are run, and why one is missing.

    For example:

        dem-harness engines
        dem-harness engines --program yade=/opt/yade/bin/yade
    """
    from harness.engines.registry import refused_plugins
    from harness.store.entries import tell_stderr
    from harness.workflows import engines as ask
    from harness.workflows import progress_bars

    with progress_bars("engines", quiet=json) as progress:
        statuses = ask(
            lmp=where.lmp, launcher=where.mpirun, programs=where.programs, progress=progress
        )
    for fault in refused_plugins():
        tell_stderr(fault)
    if json:
        print_json({"engines": [status.to_json() for status in statuses]})
        return 0
    lines = []
    for status in statuses:
        provenance = status.provenance
        cells = (
            ("missing", status.reason)
            if provenance is None
            else (provenance.engine_version, provenance.executable)
        )
        lines.append((status.engine, status.how, *cells))
    print_columns(lines)
    return 0
