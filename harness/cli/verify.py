"""``dem-harness verify``."""

from __future__ import annotations

from contextlib import AbstractContextManager
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from harness.cli.cached_engines import Cache, Chosen, Fresh
from harness.cli.options import (
    EngineName,
    Esys,
    Json,
    Kratos,
    Liggghts,
    Lmp,
    Mfix,
    Mpirun,
    Tolerances,
    Yade,
    programs_of,
)

if TYPE_CHECKING:
    from harness.engines.contract import Engine
    from harness.store.entries import Entries


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
    engines: Annotated[
        str | None,
        typer.Option(
            "--engines",
            metavar="all|NAME[,NAME...]",
            help="Hold other engines against theory and one another as well: `liggghts`, `yade`, "
            "`kratos`, `esys`, `mfix`, or `all`, of which those that are missing are not tested. "
            "One that is named must be here.",
            rich_help_panel="Other engines",
        ),
    ] = None,
    engine: EngineName = "lammps",
    lmp: Lmp = None,
    mpirun: Mpirun = None,
    liggghts: Liggghts = None,
    yade: Yade = None,
    kratos: Kratos = None,
    esys: Esys = None,
    mfix: Mfix = None,
    cache: Cache = None,
    fresh: Fresh = False,
    json: Json = False,
) -> None:
    """Do the main job: hold LAMMPS against theory and the baseline, and write a report.

    Prints the verdicts and leaves a folder with report.html, report.md,
    results.json, results.csv, the figures and the exact scripts that ran.

    What was verified before, with the same LAMMPS, code and platform, is not run
    again: the report kept of it is handed out, and said to be so. An interrupted
    verify goes on where it stopped.
    """
    from harness.cli.cached_engines import open_entries
    from harness.cli.output import print_json
    from harness.cli.recording import recorded, verdicts
    from harness.cli.tables import print_verification
    from harness.errors import RequestError
    from harness.report.target import check_folder

    if quick and full:
        raise RequestError("--quick and --full: give one of them only")
    if baseline is not None and no_baseline:
        raise RequestError("--baseline and --no-baseline: give one of them only")
    folder = output or Path("reports") / "runs" / datetime.now().strftime("%Y-%m-%d-%H%M%S")
    check_folder(folder)
    level = "quick" if quick else "full" if full else "default"
    compared = engines_of(engines)
    programs = programs_of(
        (engine, *compared),
        liggghts=liggghts,
        yade=yade,
        kratos=kratos,
        esys=esys,
        mfix=mfix,
        option="--engines",
    )
    chosen = Chosen(engine, lmp, mpirun, programs=programs)
    asked = _Asked(level, chosen, baseline, tolerances, not no_baseline, engines)
    entries = open_entries(cache)
    with recorded("verify") as told:
        key = _key(asked) if entries else None
        record = None if fresh else _kept(entries, key, folder)
        told.cached = record is not None
        record = record or _measured(asked, entries, key, folder, fresh)
        told.status, told.folder = record["status"], folder
        told.engine, told.quantities = record["engine"] or {}, verdicts(record["checks"])
    if json:
        print_json({**record, "folder": str(folder)})
    else:
        print_verification(record, folder)
    raise typer.Exit(record["status"])


class _Asked(NamedTuple):
    """What is to be verified: how much, in which engine, and against which baseline."""

    level: str
    chosen: Chosen
    baseline: Path | None
    tolerances: Path | None
    compare: bool
    engines: str | None = None


def engines_of(wanted: str | None) -> tuple[str, ...]:
    """Return the engines that are asked for; raise RequestError for one that is not known."""
    if wanted is None:
        return ()
    from harness.workflows.verification.other_engines import asked_engines

    return asked_engines(wanted).engines


def _key(asked: _Asked) -> str | None:
    """Return the key of a verification; None with other engines, not all of which have a digest."""
    from harness.store.baseline import digest
    from harness.store.verifications import verification_key

    if asked.engines is not None:
        return None
    against = digest(asked.baseline, asked.tolerances) if asked.compare else {}
    engine, lmp, mpirun, *_ = asked.chosen
    return verification_key(
        asked.level, engine=engine, lmp=lmp, launcher=mpirun, beside={"baseline": against}
    )


def _kept(entries: Entries | None, key: str | None, folder: Path) -> dict[str, Any] | None:
    """Write the report that is kept under a key and return its record, or None."""
    from harness.atomic_write import whole_folder
    from harness.store.verifications import DECODE_ERRORS, unpack

    payload = entries.get(key) if entries and key else None
    if entries is None or key is None or payload is None:
        return None
    try:
        with whole_folder(folder) as aside:
            record = unpack(payload, aside)
    except DECODE_ERRORS as error:
        entries.drop(key, f"not a verification: {error}")
        return None
    return {**record, "cached": True, "engine_runs": 0, "engine_runs_from_cache": 0}


def _open_other(
    chosen: Chosen, entries: Entries | None, fresh: bool, name: str
) -> AbstractContextManager[Engine]:
    """Return another engine by its name, with the program that was given for it."""
    from harness.cli.cached_engines import open_cached_engine

    return open_cached_engine(Chosen(name, programs=chosen.programs), entries, fresh)


def _measured(
    asked: _Asked, entries: Entries | None, key: str | None, folder: Path, fresh: bool
) -> dict[str, Any]:
    """Verify, write the report and return the record; keep both unless the engine died."""
    from harness.cli.cached_engines import open_cached_engine, runs_made
    from harness.cli.progress import progress_bars
    from harness.report.folder import write
    from harness.store.verifications import pack
    from harness.workflows.verification import verify as verify_with
    from harness.workflows.verification.run import chosen_baseline

    known = chosen_baseline(asked.baseline, asked.tolerances) if asked.compare else None
    with progress_bars() as progress, open_cached_engine(asked.chosen, entries, fresh) as opened:
        found = verify_with(
            asked.level,
            engine=opened,
            progress=progress,
            baseline=known,
            compare=asked.compare,
            engines=asked.engines or (),
            open_one=partial(_open_other, asked.chosen, entries, fresh),
        )
        progress("figures and report", 0, 1)
        record = found.record()
        write(found, folder)
        if entries is not None and key is not None and not found.engine_errors:
            entries.put(key, pack(folder, record))
        progress("figures and report", 1, 1)
        return {**record, "cached": False, **runs_made(opened)}
