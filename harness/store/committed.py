"""Committed files that runs are compared to: accepted runs and known defects.

    reports/accepted/<engine>/<version>/rows.csv
    inputs/known-defects.toml

They lie in the checkout; an installed package has copies. ``accept`` merges the rows of a run into
the accepted ones; ``git diff`` is the review.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from harness.engines.output import release_of
from harness.errors import RequestError
from harness.files import committed, is_checkout, text_writer, write_files
from harness.results.defects import KnownDefect
from harness.results.rows import COLUMNS, KEY, Verdict, table
from harness.store.runs import ROWS, Run, read_rows, rows_text

ACCEPTED, DEFECTS, SCRIPTS = "reports/accepted", "inputs/known-defects.toml", "reports/defects"


def accepted_rows(engines: Mapping[str, str], folder: Path | None = None) -> pd.DataFrame:
    """Return the accepted rows of engines: of their version each, else of the newest.

    ``engines`` maps names to versions, ``folder`` has the accepted runs, the committed ones unless
    given. An engine without an accepted run has no rows. Raise RequestError for a damaged file.
    """
    folder, tables = folder or committed(ACCEPTED), []
    for engine, version in engines.items():
        place = folder / folder_name(engine)
        files = sorted(place.glob(f"*/{ROWS}"), key=_release)
        same = place / folder_name(version) / ROWS
        if files:
            tables.append(read_rows(same if same in files else files[-1]))
    tables = [rows for rows in tables if not rows.empty]
    return pd.concat(tables, ignore_index=True) if tables else table(())


def accept(run: Run, folder: Path | None = None) -> list[Path]:
    """Merge the rows of a run into the accepted runs; return the files that changed.

    An accepted row in the scope of the run that it lacks is dropped; a row, or a case as a whole,
    that the run did not test stays as it was. Raise RequestError for a run in which an engine died,
    where a file cannot be written, and for the accepted runs of an installed package.
    """
    if folder is None and not is_checkout():
        place = f"{committed(ACCEPTED)} belongs to the installed package"
        raise RequestError(f"accept: {place} and is not written; name a folder")
    folder = folder or committed(ACCEPTED)
    if run.died:
        raise RequestError(f"nothing is accepted: an engine failed in {run.died} rows")
    texts = {}
    for (engine, version), rows in run.rows.groupby(["engine", "version"], sort=True):
        file = folder / folder_name(str(engine)) / folder_name(str(version)) / ROWS
        before = read_rows(file) if file.is_file() else table(())
        text = rows_text(_merged(before, rows, run))
        if text != rows_text(before):
            texts[file] = text
    write_files({("accept", file): text_writer(text) for file, text in texts.items()})
    return list(texts)


def folder_name(name: str) -> str:
    """Return the folder of an engine or a version: its plain characters, hyphens between words."""
    return re.sub(r"[^\w.+]+", "-", name).strip("-.") or "unknown"


def _release(file: Path) -> tuple[int, ...]:
    return release_of(file.parent.name.replace("-", " "))


def _merged(before: pd.DataFrame, rows: pd.DataFrame, run: Run) -> pd.DataFrame:
    keys = list(KEY)
    present = pd.MultiIndex.from_frame(before[keys]).isin(pd.MultiIndex.from_frame(rows[keys]))
    is_whole = rows["setup"] == ""  # of a case whose checks were not run
    untested = before["case"].isin(rows[is_whole]["case"])
    remaining = before[present | untested | ~run.meta.of_engines_that_ran().covers(before)]
    tested = rows[~is_whole & (rows["verdict"] != Verdict.NOT_TESTED)]
    tested = tested.assign(reason="", note="", log="")  # texts lie with the run and its checks
    merged = pd.concat([remaining, tested]) if len(remaining) else tested
    return merged.drop_duplicates(keys, keep="last")[list(COLUMNS)]


# ---- known defects


def known_defects(other: Path | None = None) -> tuple[KnownDefect, ...]:
    """Return the committed defects, and those of another file.

    Raise RequestError, naming file and defect, for a damaged file, and for a name in both files.
    """
    defects = read_defects(committed(DEFECTS))
    names = {defect.name for defect in defects}
    for defect in () if other is None else read_defects(other):
        if defect.name in names:
            raise RequestError(
                f"known defects {other}: {defect.name!r} is the name of a committed one"
            )
        defects = (*defects, defect)
    return defects


def read_defects(file: Path) -> tuple[KnownDefect, ...]:
    """Return the defects of a TOML file with tables ``[defect.NAME]``.

    Raise RequestError, naming file and defect, for anything else.
    """
    label, defects = f"known defects {file}", []
    try:
        record: dict[str, Any] = tomllib.loads(file.read_bytes().decode("utf-8"))
    except (OSError, ValueError) as error:
        raise RequestError(f"{label}: cannot be read: {error}") from None
    tables = record.pop("defect", {})
    entries = tables.values() if isinstance(tables, dict) else [tables]
    if record or not all(isinstance(entry, dict) for entry in entries):
        raise RequestError(f"{label}: holds tables [defect.NAME] and nothing else")
    for name, entry in tables.items():
        try:
            defects.append(KnownDefect(**{"name": name, **entry}))
        except RequestError as error:
            raise RequestError(f"{label}: defect.{name}: {error}") from None
    return tuple(defects)


def defect_script(defect: KnownDefect) -> str:
    """Return the script that shows a defect with the engine alone; empty without one."""
    file = committed(SCRIPTS) / defect.script.removeprefix(f"{SCRIPTS}/")
    return file.read_text(encoding="utf-8") if defect.script and file.is_file() else ""
