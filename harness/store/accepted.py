"""Accepted runs: the rows that a run is held against, one file for each engine and version.

    reports/accepted/<engine>/<version>/rows.csv

``accept`` merges the rows of a run into them; ``git diff`` is the review.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

import harness
from harness.engines.provenance import release_of
from harness.errors import RequestError
from harness.files import text_writer, write_files
from harness.results.rows import COLUMNS, ENGINE_FAILURES, KEY, Verdict, table
from harness.store.rows_csv import read_rows, rows_text
from harness.store.runs import ROWS, Run

NAME = "accepted"


def accepted_folder() -> Path:
    """Return the folder of the accepted runs: of the checkout, else of the installed package."""
    package = Path(harness.__file__).parent
    if _is_checkout(package.parent):
        return package.parent / "reports" / NAME
    return package / "store" / "committed" / NAME


def writable_folder() -> Path:
    """Return the accepted runs of the checkout; raise RequestError in an installed package."""
    folder = accepted_folder()
    if not _is_checkout(Path(harness.__file__).parent.parent):
        raise RequestError(
            f"accept: {folder} belongs to the installed package and is not written; name a folder"
        )
    return folder


def accepted_rows(folder: Path, engines: Mapping[str, str]) -> pd.DataFrame:
    """Return the accepted rows of engines: of their version each, else of the newest.

    ``engines`` maps names to versions. An engine without an accepted run has no rows. Raise
    RequestError for a file that is damaged.
    """
    found = [_newest_or_same(folder / engine, version) for engine, version in engines.items()]
    tables = [rows for rows in found if not rows.empty]
    return pd.concat(tables, ignore_index=True) if tables else table(())


def accept(run: Run, folder: Path) -> list[Path]:
    """Merge the rows of a run into the accepted runs; return the files that changed.

    An accepted row that the run was asked for and lacks is dropped; a row that the run has and
    did not test stays as it was. Raise RequestError for a run in which an engine died, which
    would drop what it did not reach, and where a file cannot be written.
    """
    died = run.rows["failure"].isin(ENGINE_FAILURES) & (run.rows["verdict"] == Verdict.FAIL)
    if died.any():
        raise RequestError(f"nothing is accepted: an engine failed in {int(died.sum())} rows")
    texts = {}
    for (engine, version), rows in run.rows.groupby(["engine", "version"], sort=True):
        file = folder / str(engine) / folder_name(str(version)) / ROWS
        before = read_rows(file) if file.is_file() else table(())
        text = rows_text(_merged(before, rows, run))
        if not file.is_file() or text != file.read_bytes().decode("utf-8"):
            texts[file] = text
    write_files({("accept", file): text_writer(text) for file, text in texts.items()})
    return list(texts)


def folder_name(version: str) -> str:
    """Return the name of a version's folder: its plain characters, with hyphens between words."""
    return re.sub(r"[^\w.+]+", "-", version).strip("-.") or "unknown"


def _is_checkout(folder: Path) -> bool:
    return (folder / "pyproject.toml").is_file()


def _newest_or_same(folder: Path, version: str) -> pd.DataFrame:
    same = folder / folder_name(version) / ROWS
    files = sorted(folder.glob(f"*/{ROWS}"), key=_release)
    if same.is_file():
        return read_rows(same)
    return read_rows(files[-1]) if files else table(())


def _release(file: Path) -> tuple[int, ...]:
    return release_of(file.parent.name.replace("-", " "))


def _merged(before: pd.DataFrame, rows: pd.DataFrame, run: Run) -> pd.DataFrame:
    keys = list(KEY)
    untested = rows["verdict"] == Verdict.NOT_TESTED
    present = pd.MultiIndex.from_frame(before[keys]).isin(pd.MultiIndex.from_frame(rows[keys]))
    kept = before[present | ~run.meta.scope.covers(before)]
    taken = rows[~untested].assign(log="")  # logs lie in the run's own folder
    merged = pd.concat([kept, taken]) if len(kept) else taken
    return merged.drop_duplicates(keys, keep="last")[list(COLUMNS)]
