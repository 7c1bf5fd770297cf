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

import harness
from harness.engines.output import release_of
from harness.errors import RequestError
from harness.files import text_writer, write_files
from harness.results.defects import KnownDefect
from harness.results.rows import COLUMNS, ENGINE_FAILURES, KEY, Verdict, table
from harness.store.runs import ROWS, Run
from harness.store.tables import read_rows, rows_text

ACCEPTED = "accepted"
DEFECTS = "known-defects.toml"
SCRIPTS = "reports/defects/"


def _place(in_checkout: str, in_package: str) -> tuple[Path, bool]:
    """Return where a committed file or folder lies, and whether that is a checkout."""
    package = Path(harness.__file__).parent
    if (package.parent / "pyproject.toml").is_file():
        return package.parent / in_checkout, True
    return package / "store" / "committed" / in_package, False


def accepted_folder() -> Path:
    """Return the folder of the accepted runs: of the checkout, else of the installed package."""
    return _place(f"reports/{ACCEPTED}", ACCEPTED)[0]


def writable_folder() -> Path:
    """Return the accepted runs of the checkout; raise RequestError in an installed package."""
    folder, is_checkout = _place(f"reports/{ACCEPTED}", ACCEPTED)
    if not is_checkout:
        raise RequestError(
            f"accept: {folder} belongs to the installed package and is not written; name a folder"
        )
    return folder


def accepted_rows(folder: Path, engines: Mapping[str, str]) -> pd.DataFrame:
    """Return the accepted rows of engines: of their version each, else of the newest.

    ``engines`` maps names to versions. An engine without an accepted run has no rows. Raise
    RequestError for a damaged file.
    """
    tables = []
    for engine, version in engines.items():
        files = sorted((folder / engine).glob(f"*/{ROWS}"), key=_release)
        same = folder / engine / folder_name(version) / ROWS
        if files:
            tables.append(read_rows(same if same in files else files[-1]))
    tables = [rows for rows in tables if not rows.empty]
    return pd.concat(tables, ignore_index=True) if tables else table(())


def accept(run: Run, folder: Path) -> list[Path]:
    """Merge the rows of a run into the accepted runs; return the files that changed.

    An accepted row in the scope of the run that it lacks is dropped; a row that the run has and
    did not test stays as it was. Raise RequestError for a run in which an engine died, and where
    a file cannot be written.
    """
    died = run.rows["failure"].isin(ENGINE_FAILURES) & (run.rows["verdict"] == Verdict.FAIL)
    if died.any():
        raise RequestError(f"nothing is accepted: an engine failed in {int(died.sum())} rows")
    texts = {}
    for (engine, version), rows in run.rows.groupby(["engine", "version"], sort=True):
        file = folder / str(engine) / folder_name(str(version)) / ROWS
        text = rows_text(_merged(read_rows(file) if file.is_file() else table(()), rows, run))
        if not file.is_file() or text != file.read_bytes().decode("utf-8"):
            texts[file] = text
    write_files({("accept", file): text_writer(text) for file, text in texts.items()})
    return list(texts)


def folder_name(version: str) -> str:
    """Return the name of a version's folder: its plain characters, with hyphens between words."""
    return re.sub(r"[^\w.+]+", "-", version).strip("-.") or "unknown"


def _release(file: Path) -> tuple[int, ...]:
    return release_of(file.parent.name.replace("-", " "))


def _merged(before: pd.DataFrame, rows: pd.DataFrame, run: Run) -> pd.DataFrame:
    keys = list(KEY)
    present = pd.MultiIndex.from_frame(before[keys]).isin(pd.MultiIndex.from_frame(rows[keys]))
    remaining = before[present | ~run.meta.covers(before)]
    tested = rows[rows["verdict"] != Verdict.NOT_TESTED]
    tested = tested.assign(reason="", note="", log="")  # texts lie with the run and its checks
    merged = pd.concat([remaining, tested]) if len(remaining) else tested
    return merged.drop_duplicates(keys, keep="last")[list(COLUMNS)]


# ---- known defects


def known_defects(other: Path | None = None) -> tuple[KnownDefect, ...]:
    """Return the committed defects, and those of another file.

    Raise RequestError, naming file and defect, for a damaged file, and for a name in both files.
    """
    defects = read_defects(_place(f"inputs/{DEFECTS}", DEFECTS)[0])
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
    label = f"known defects {file}"
    try:
        record: dict[str, Any] = tomllib.loads(file.read_bytes().decode("utf-8"))
    except (OSError, ValueError) as error:
        raise RequestError(f"{label}: cannot be read: {error}") from None
    tables = record.pop("defect", {})
    entries = tables.values() if isinstance(tables, dict) else [tables]
    if record or not all(isinstance(entry, dict) for entry in entries):
        raise RequestError(f"{label}: holds tables [defect.NAME] and nothing else")
    defects = []
    for name, entry in tables.items():
        try:
            defects.append(KnownDefect(**{"name": name, **entry}))
        except RequestError as error:
            raise RequestError(f"{label}: defect.{name}: {error}") from None
    return tuple(defects)


def defect_script(defect: KnownDefect) -> str:
    """Return the script that shows a defect with the engine alone; empty without one."""
    file, _ = _place(defect.script, f"defects/{defect.script.removeprefix(SCRIPTS)}")
    return file.read_text(encoding="utf-8") if defect.script and file.is_file() else ""
