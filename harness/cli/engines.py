"""``dem-harness engines``."""

from __future__ import annotations

from harness.cli.options import (
    Esys,
    Json,
    Kratos,
    Liggghts,
    Lmp,
    Mfix,
    Mpirun,
    Yade,
    programs_of,
)


def engines(
    lmp: Lmp = None,
    mpirun: Mpirun = None,
    liggghts: Liggghts = None,
    yade: Yade = None,
    kratos: Kratos = None,
    esys: Esys = None,
    mfix: Mfix = None,
    json: Json = False,
) -> None:
    """Which engines are here, in which version, how they are run, and why one is missing."""
    from harness.cli.output import print_json
    from harness.workflows.status import engines as ask

    programs = programs_of(
        None, liggghts=liggghts, yade=yade, kratos=kratos, esys=esys, mfix=mfix, must_be_here=False
    )
    found = ask(lmp=lmp, launcher=mpirun, programs=programs)
    if json:
        print_json({"engines": [status.record() for status in found]})
        return
    for status in found:
        who = status.provenance
        if who is None:
            print(f"{status.engine:9} {status.how:12} missing: {status.reason}")
        else:
            print(f"{status.engine:9} {status.how:12} {who.engine_version:24} {who.executable}")
