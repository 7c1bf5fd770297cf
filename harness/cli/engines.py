"""``dem-harness engines``."""

from __future__ import annotations

from dataclasses import dataclass

from harness.cli.engine_options import Lmp, Mpirun, Programs
from harness.cli.lists import named_values
from harness.cli.options import Json


@dataclass(frozen=True)
class WhereOptions:
    """Where engines are looked for."""

    lmp: Lmp = None
    mpirun: Mpirun = None
    program: Programs = None


def engines(where: WhereOptions, json: Json = False) -> None:
    """Which engines are here, in which version, how they are run, and why one is missing."""
    from harness.cli.output import print_json
    from harness.report.plain import one_line
    from harness.workflows import engines as ask

    programs = named_values(where.program or (), "--program")
    found = ask(lmp=where.lmp, launcher=where.mpirun, programs=programs)
    if json:
        print_json({"engines": [status.record() for status in found]})
        return
    for status in found:
        who = status.provenance
        said = f"missing: {status.reason}"
        if who is not None:
            said = f"{who.engine_version:24} {who.executable}"
        print(f"{status.engine:9} {status.how:12} {one_line(said) if who is None else said}")
