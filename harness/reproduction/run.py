"""Recompute the source: its statements as a run of rows, and the report of them."""

from __future__ import annotations

import platform
import time
from collections import Counter
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd

from harness import __version__
from harness.cases.bench import OWN, Bench
from harness.report.content import Badge, Section, Table
from harness.report.page import report_files
from harness.reproduction import appendix, background, methods, results
from harness.reproduction.figures import drawings
from harness.reproduction.statements import CASE, CORRECTED, REGISTRY
from harness.results.rows import Verdict, table
from harness.store.cache import EngineChoice, opened
from harness.store.runs import Meta, Run, write_run

TITLE = "Harper, Dufek and Breard (arXiv:2409.13633), recomputed"
REPRODUCED, WITH_CORRECTION = "reproduced", "reproduced with a correction"
NOT_REPRODUCED, UNTESTED = "not reproduced", "not tested"
COLOURS = {  # verdicts whose colours the statuses have on a page
    REPRODUCED: "pass", WITH_CORRECTION: "not tested", NOT_REPRODUCED: "fail", UNTESTED: "recorded",
}  # fmt: skip
INTRODUCTION = """\
Each statement of the source that can be recomputed is a row: the printed value is expected, the
value comes by an independent route. A statement that does not hold is a finding; where a correction
makes it hold, a second row shows that. Nothing here is typed in."""

# each module registers its statements; in the order of the source
PARTS = [part.__name__ for part in (background, methods, results, appendix)]
STATEMENTS = dict(
    sorted(REGISTRY.items(), key=lambda item: PARTS.index(item[1].measure.__module__))
)

Progress = Callable[[str, int, int], None]


def reproduce(
    *, engine: EngineChoice = None, fresh: bool = False, progress: Progress = lambda *_: None
) -> Run:
    """Recompute all statements of the source and return their rows.

    ``engine`` runs the incline: an open one, or a name, LAMMPS unless given, whose runs are kept;
    ``fresh`` runs again what was kept. Raise EngineError for an engine that cannot be opened.
    """
    with opened(engine, fresh=fresh) as running:
        return recomputed(Bench(running), progress)


def recomputed(bench: Bench | None, progress: Progress = lambda *_: None) -> Run:
    """Return the rows of all statements; the bench is that of the engine of some."""
    started, clock = datetime.now(UTC).isoformat(timespec="seconds"), time.monotonic()
    rows = []
    for done, statement in enumerate(STATEMENTS.values(), 1):
        rows += statement.rows(bench)
        progress("statements of the source", done, len(STATEMENTS))
    engines = {row.engine: row.version for row in rows if row.engine != OWN}
    meta = Meta(level="default", cases=(CASE,), engines=engines | {OWN: __version__},
                started=started, seconds=time.monotonic() - clock,
                platform=f"{platform.system()} {platform.machine()}",
                harness_version=__version__)  # fmt: skip
    return Run(table(rows), meta)


def write_reproduction(run: Run, folder: Path) -> None:
    """Write rows, pages and figures into a new folder. Raise RequestError as ``write_run`` does."""
    write_run(run, folder, report_files(run, sections(run), title=TITLE, headline=headline(run)))


def statuses(run: Run) -> dict[str, str]:
    """Return the status of each statement by its key."""
    return dict(zip(STATEMENTS, _ledger(run)["status"], strict=True))


def headline(run: Run) -> str:
    """Return how many statements have each status."""
    numbers = Counter(statuses(run).values())
    return ", ".join(f"{numbers[status]} {status}" for status in COLOURS if numbers[status])


def sections(run: Run) -> list[Section]:
    """Return the ledger of statements, the errata with their evidence, and the figures."""
    ledger = _ledger(run)
    numbers = Counter(ledger["status"])
    counts = pd.DataFrame([{status: numbers[status] for status in COLOURS}])
    errata = ledger[(ledger["correction"] != "") & (ledger["status"] != REPRODUCED)]
    errata = errata.reset_index(drop=True)
    evidence = [
        f"{value:.7g} recomputed, {printed:.7g} as printed"
        for value, printed in zip(errata["recomputed"], errata["printed"], strict=True)
    ]
    columns = ["where", "the source states", "correction", "evidence", "status"]
    badges = pd.Series([Badge(status, COLOURS[status]) for status in ledger["status"]])
    return [
        Section("Statements", INTRODUCTION, (
            Table("Status of the statements", counts),
            Table("Ledger", ledger.drop(columns="correction").assign(status=badges)),
        )),
        Section("Errata", "What has to be changed for a statement to hold.", (
            Table("Corrections", errata.assign(evidence=evidence)[columns]),
        )),
        Section("Figures", drawings=drawings()),
    ]  # fmt: skip


def _ledger(run: Run) -> pd.DataFrame:
    """Return texts, status and values of the statements, in order."""
    rows = run.rows.set_index(["check", "quantity"])
    printed, verdicts = rows.loc[""], rows["verdict"].to_dict()
    return pd.DataFrame(
        {
            "where": statement.where, "the source states": statement.text,
            "status": _status(verdicts["", key], verdicts.get((CORRECTED, key))),
            "recomputed": printed.loc[key, "value"], "printed": printed.loc[key, "expected"],
            "unit": "" if statement.unit == "1" else statement.unit,
            "note": printed.loc[key, "note"], "correction": statement.correction,
        }
        for key, statement in STATEMENTS.items()
    )  # fmt: skip


def _status(printed: str, corrected: str | None) -> str:
    if printed == Verdict.PASS:
        return REPRODUCED
    if printed in (Verdict.NOT_TESTED, Verdict.FAIL):
        return UNTESTED
    return WITH_CORRECTION if corrected == Verdict.PASS else NOT_REPRODUCED
