"""``dem-harness verify``."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from harness.cli.engine_options import EngineOptions
from harness.cli.files import check_source, output_folder
from harness.cli.options import Json
from harness.cli.output import closed_pipe_allowed, print_json
from harness.errors import RequestError

if TYPE_CHECKING:
    from harness.store.entries import Entries
    from harness.workflows.progress import Progress


@dataclass(frozen=True)
class VerifyOptions:
    """What is to be verified: how much, against which baseline, and where the report goes."""

    quick: bool = False
    full: bool = False
    cases: str | None = None
    engines: str | None = None
    output: Path | None = None
    baseline: Path | None = None
    no_baseline: bool = False
    tolerances: Path | None = None
    strict: bool = False
    verbose: bool = False

    @property
    def level(self) -> str:
        """Return the level by its name."""
        return "quick" if self.quick else "full" if self.full else "default"

    def check(self) -> None:
        """Raise RequestError for options that contradict one another or name no such file."""
        if self.quick and self.full:
            raise RequestError("--quick and --full: give one of them only")
        if self.baseline is not None and self.no_baseline:
            raise RequestError("--baseline and --no-baseline: give one of them only")
        check_source(self.tolerances, "--tolerances")
        check_source(self.baseline, "--baseline", folder=True)


def verify(asked: VerifyOptions, engine: EngineOptions, json: Json = False) -> None:
    """Do the main job: hold an engine against theory and the baseline, and write a report.

    Prints what failed, the verdicts counted by kind, and the headline, and leaves a folder with
    report.html, report.md, results.json, results.csv, the figures and the exact scripts that ran.

    What was verified before, with the same engine, code and platform, is not run
    again: the report kept of it is handed out, and said to be so. An interrupted
    verify goes on where it stopped.
    """
    from harness.cli.recording import recorded, verdicts
    from harness.cli.verdicts import print_verification

    asked.check()
    beside = engines_of(asked.engines)
    engine.check_names((engine.engine, *beside), "--engines")
    with output_folder(asked.output) as folder, recorded("verify", quiet=json) as told:
        record = _record(asked, engine, folder, told.progress)
        told.cached = record["cached"]
        told.status, told.folder = record["status"], folder
        told.engine, told.quantities = record["engine"] or {}, verdicts(record["checks"])
    with closed_pipe_allowed():
        if json:
            print_json({**record, "folder": str(folder)})
        else:
            print_verification(record, folder, verbose=asked.verbose)
    for error in record["engine_errors"] if record["status"] == 3 else ():
        print(f"dem-harness: {error}", file=sys.stderr)
    raise typer.Exit(record["status"])


def engines_of(wanted: str | None) -> tuple[str, ...]:
    """Return the engines that are asked for; raise RequestError for one that is not known."""
    if wanted is None:
        return ()
    from harness.workflows.engine_selection import asked_engines

    return asked_engines(wanted).engines


def _record(
    asked: VerifyOptions, engine: EngineOptions, folder: Path, progress: Progress
) -> dict[str, Any]:
    """Return the record of a kept verification or of a new one, its report in the folder."""
    from harness.store.verifications import pack

    entries = engine.entries()
    key = _key(asked, engine) if entries else None
    record = None if engine.fresh else _kept(entries, key, folder)
    if record is None:
        record = _measured(asked, engine, folder, progress)
        if entries is not None and key is not None and not record["engine_errors"]:
            entries.put(key, pack(folder, record))
    return record


def _key(asked: VerifyOptions, engine: EngineOptions) -> str | None:
    """Return the key of a verification; None with other engines, not all of which have a digest."""
    from harness.store.baseline import digest
    from harness.store.verifications import verification_key
    from harness.workflows.request import chosen_cases

    if asked.engines is not None:
        return None
    against = {} if asked.no_baseline else digest(asked.baseline, asked.tolerances)
    return verification_key(
        asked.level,
        cases=[case.name for case in chosen_cases(asked.cases)],
        engine=engine.engine,
        beside={"baseline": against, "strict": asked.strict},
        **engine.opening(engine.engine, engine.integrator),
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


def _measured(
    asked: VerifyOptions, engine: EngineOptions, folder: Path, progress: Progress
) -> dict[str, Any]:
    """Verify, write the report and return the record."""
    from harness.cli.engine_options import runs_made
    from harness.report.folder import write
    from harness.workflows import sections
    from harness.workflows import verify as verify_with
    from harness.workflows.request import chosen_baseline

    known = not asked.no_baseline and chosen_baseline(asked.baseline, asked.tolerances)
    with engine.open(engine.engine, engine.integrator) as opened:
        if engine.lmp or engine.mpirun or engine.program:
            opened.identify()  # a program that was named and is another ends the command at once
        found = verify_with(
            asked.level,
            cases=asked.cases,
            engine=opened,
            engines=asked.engines or (),
            open_one=engine.without_launcher().open,
            baseline=known,
            progress=progress,
            strict=asked.strict,
        )
        progress("figures and report", 0, 1)
        record = found.record()
        write(found, folder, sections(found))
        progress("figures and report", 1, 1)
        return {**record, "cached": False, **runs_made(opened)}
