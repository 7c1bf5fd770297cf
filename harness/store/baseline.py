"""Read the baseline: of each engine a table of its records, and one of their series.

``<engine>.csv`` has a line for each quantity of each record, sorted; ``<engine>.series.csv`` a line
for each sample. The committed ones lie in ``reports/baseline`` of the project; a wheel carries
them in ``harness/store/committed``. A checkout's own come first.
"""

from __future__ import annotations

from pathlib import Path

import harness
from harness.comparison.baseline_record import BaselineRecord
from harness.comparison.regression import Baseline
from harness.errors import RequestError
from harness.store.baseline_reader import read_tables
from harness.store.baseline_tables import SERIES, TABLE
from harness.store.keys import digest_of_files
from harness.store.overrides import read_overrides


def committed() -> Path | None:
    """Return the folder of the baseline that came with this harness, None if there is none.

    Raise RequestError for a checkout whose baseline is missing: nothing would be compared.
    """
    checkout = checkout_baseline()
    if checkout is None:
        wheel = Path(harness.__file__).parent / "store" / "committed" / "baseline"
        return wheel if tables_in(wheel) else None
    if not tables_in(checkout):
        raise RequestError(
            f"baseline {checkout}: is missing in this checkout; restore it (git checkout), or "
            "compare with none (--no-baseline)"
        )
    return checkout


def checkout_baseline() -> Path | None:
    """Return the folder of the baseline of a checkout, also where it is missing; else None."""
    root = Path(harness.__file__).parent.parent
    return root / "reports" / "baseline" if (root / "pyproject.toml").is_file() else None


def tables_in(folder: Path) -> list[Path]:
    """Return the tables of a baseline's folder, one an engine, without those of series."""
    return [p for p in sorted(folder.glob(f"*{TABLE}")) if not p.name.endswith(SERIES)]


def in_checkout(folder: Path) -> bool:
    """Return whether a folder may be written: the wheel's own may not."""
    return Path(harness.__file__).parent.resolve() not in folder.resolve().parents


def committed_tolerances() -> Path | None:
    """Return the file of overrides that came with this harness, None if there is none."""
    return committed_file("tolerances.toml")


KNOWN_DEFECTS = "known-defects.toml"
"""File of ``inputs``, read by :mod:`harness.store.known_defects`."""


def committed_file(name: str) -> Path | None:
    """Return a file of ``inputs`` that came with this harness, None if there is none."""
    package = Path(harness.__file__).parent
    files = (package.parent / "inputs" / name, package / "store" / "committed" / name)
    return next((file for file in files if file.is_file()), None)


def digest_of(folder: Path) -> str:
    """Return the digest of a baseline's files; that of no file where there is none."""
    return digest_of_files(sorted(folder.glob(f"*{TABLE}")), folder)


def digest(folder: Path | None, tolerances: Path | None) -> dict[str, str | None]:
    """Return the digests of a baseline, of its overrides and of the known defects.

    The committed ones unless given, None where there is none. They stand for all that a
    comparison depends on besides the runs. Raise RequestError for a file that cannot be read.
    """
    where, overrides = folder or committed(), tolerances or committed_tolerances()
    if overrides:
        read_overrides(overrides)
    defects = committed_file(KNOWN_DEFECTS)
    return {
        "folder": digest_of(where) if where else None,
        "tolerances": digest_of_files([overrides], overrides.parent) if overrides else None,
        "known_defects": digest_of_files([defects], defects.parent) if defects else None,
    }


def read_baseline(folder: Path, tolerances: Path | None = None) -> Baseline:
    """Return the baseline of a folder, with the overrides of a file (the committed one's).

    Raise RequestError, naming file and line, for a folder that is not there and a
    file that is damaged.
    """
    if not folder.is_dir():
        raise RequestError(f"--baseline {folder}: no such folder")
    chosen = tolerances or committed_tolerances()
    overrides = read_overrides(chosen) if chosen else ()
    records: dict[str, BaselineRecord] = {}
    for table in tables_in(folder):
        records |= {record.name: record for record in read_tables(table)}
    return Baseline(records, str(folder), overrides, digest_of(folder))
