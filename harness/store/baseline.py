"""The baseline as files: one JSON a case, its series beside it as CSV, named after the case.

The committed one lies in ``reports/baseline`` of the project; a wheel carries it
in ``harness/store/committed``. A checkout's own comes first.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

import harness
from harness.comparison.baseline_record import BaselineRecord, Quantity
from harness.comparison.divergence import Series
from harness.comparison.regression import Baseline
from harness.errors import RequestError
from harness.store.keys import digest_of_files, digest_of_tree
from harness.store.overrides import read_overrides

DIGITS = 12
"""Of a series: ten times finer than the narrowest band."""

_FIELDS = ("engine", "engine_version", "how", "platform", "script", "script_sha256")


def committed() -> Path | None:
    """Return the folder of the baseline that came with this harness, None if there is none."""
    package = Path(harness.__file__).parent
    checkout = package.parent / "reports" / "baseline"
    wheel = package / "store" / "committed" / "baseline"
    return next((folder for folder in (checkout, wheel) if folder.is_dir()), None)


def in_checkout(folder: Path) -> bool:
    """Return whether a folder may be written: the wheel's own may not."""
    return Path(harness.__file__).parent.resolve() not in folder.resolve().parents


def committed_tolerances() -> Path | None:
    """Return the file of overrides that came with this harness, None if there is none."""
    package = Path(harness.__file__).parent
    files = (
        package.parent / "inputs" / "tolerances.toml",
        package / "store" / "committed" / "tolerances.toml",
    )
    return next((file for file in files if file.is_file()), None)


def digest(folder: Path | None, tolerances: Path | None) -> dict[str, str | None]:
    """Return the digests of a baseline and of its overrides, the committed ones unless given.

    None where there is none. They stand for all that a comparison depends on
    besides the runs.
    """
    where, overrides = folder or committed(), tolerances or committed_tolerances()
    return {
        "folder": digest_of_tree(where) if where else None,
        "tolerances": digest_of_files([overrides], overrides.parent) if overrides else None,
    }


def read_baseline(folder: Path, tolerances: Path | None = None) -> Baseline:
    """Return the baseline of a folder, with the overrides of a file (the committed one's).

    Raise RequestError, naming the file, for a folder that is not there and a
    file that is damaged.
    """
    if not folder.is_dir():
        raise RequestError(f"--baseline {folder}: no such folder")
    chosen = tolerances or committed_tolerances()
    overrides = read_overrides(chosen) if chosen else ()
    cases = [read_case(path, folder) for path in sorted(folder.rglob("*.json"))]
    return Baseline({case.name: case for case in cases}, str(folder), overrides)


def read_case(path: Path, folder: Path) -> BaselineRecord:
    """Return the case of a file below a baseline's folder; raise RequestError if damaged."""
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        name = path.relative_to(folder).with_suffix("").as_posix()
        if record["case"] != name:
            raise ValueError(f"it says it is case {record['case']!r}")
        return BaselineRecord(
            name=name,
            parameters=dict(record["parameters"]),
            quantities={key: _quantity(key, q) for key, q in record["quantities"].items()},
            levels=tuple(record["levels"]),
            series=_read_series(path.with_suffix(".csv")) if record["series"] else None,
            **{key: str(record[key]) for key in _FIELDS},
        )
    except OSError as error:
        damaged = f"{error.strerror} ({Path(error.filename).name})" if error.filename else error
        raise _damaged(path, damaged) from None
    except KeyError as error:
        raise _damaged(path, f"{error} is missing") from None
    except (ValueError, TypeError, AttributeError) as error:
        raise _damaged(path, error) from None


def _damaged(path: Path, why: object) -> RequestError:
    return RequestError(
        f"baseline file {path} is damaged: {why}; restore it, or remove it and accept a new one"
    )


def _quantity(name: str, record: Mapping[str, Any]) -> Quantity:
    value, uncertainty = record["value"], record["uncertainty"]
    for number in (value, uncertainty):
        if not isinstance(number, (int, float)) or not np.isfinite(number):
            raise ValueError(f"{name} = {number!r} is not a finite number")
    return Quantity(float(value), float(uncertainty), str(record["unit"]))


def _read_series(path: Path) -> Series:
    text = path.read_text(encoding="utf-8")
    head = text.partition("\n")[0].split(",")
    if len(text.splitlines()) < 3:
        raise ValueError(f"{path.name} holds fewer than two samples")
    rows = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1, ndmin=2)
    if head[0] != "time_s" or rows.shape[1] != len(head):
        raise ValueError(f"{path.name} is not a series over time_s")
    if not np.isfinite(rows).all():
        raise ValueError(f"{path.name} holds values that are not numbers")
    return Series(rows[:, 0], dict(zip(head[1:], rows[:, 1:].T, strict=True)))


def case_text(case: BaselineRecord) -> str:
    """Return a case as indented JSON with sorted keys: text whose differences are readable."""
    record = {
        "case": case.name,
        "levels": sorted(case.levels),
        "parameters": dict(case.parameters),
        "quantities": {name: vars(quantity) for name, quantity in case.quantities.items()},
        "series": case.series is not None,
        **{key: getattr(case, key) for key in _FIELDS},
    }
    return json.dumps(record, indent=2, sort_keys=True, ensure_ascii=False) + "\n"


def series_text(series: Series) -> str:
    """Return a thinned series as CSV."""
    thin = series.thinned()
    rows = np.column_stack([thin.time, *thin.columns.values()])
    head = ",".join(["time_s", *thin.columns])
    return "\n".join([head, *(_row(row) for row in rows)]) + "\n"


def _row(values: np.ndarray[Any, np.dtype[np.float64]]) -> str:
    return ",".join(f"{value + 0.0:.{DIGITS}g}" for value in values)
