"""Runs of an earlier study, of this machine or another, from its runs.csv: not made again."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from harness.cases.contract import Case, Measured
from harness.errors import RequestError
from harness.observables.provenance import Provenance
from harness.parameters.base import Parameters
from harness.workflows.sweep_local import Executor, Ran, Work
from harness.workflows.sweep_run import DONE, parameter_columns, quantity_key

OF_A_RUN = ("engine", "engine_version", "ranks", "status", "wall_time_s")
"""Columns beside parameters and quantities that a run is known by."""

Key = tuple[str, ...]


@dataclass(frozen=True)
class EarlierRuns:
    """The runs of a file that were done, by engine, ranks and parameters."""

    rows: Mapping[Key, Measured]

    def beside(self, executor: Executor, ranks: int) -> Executor:
        """Return what takes runs from the file where they are there, and else runs them."""

        def run(work: Work) -> Iterator[tuple[int, Ran]]:
            missing = []
            for place, one in enumerate(work.parameters):
                found = self.rows.get(_key(work.engine, ranks, one))
                if found is None:
                    missing.append(place)
                else:
                    yield place, found
            if missing:
                left = replace(work, parameters=[work.parameters[place] for place in missing])
                for place, ran in executor(left):
                    yield missing[place], ran

        return run


def read_runs(path: Path, case: Case[Any], one: Parameters) -> EarlierRuns:
    """Return the runs of a case in a file; ``one`` is an example of its parameters.

    Raise RequestError in a line for a file that cannot be read, has no such columns, or a value
    that is no number.
    """
    where = f"--runs {path}"
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise RequestError(f"{where}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise RequestError(f"{where}: is no UTF-8 text") from None
    reader = csv.DictReader(io.StringIO(text))
    parameters = tuple(parameter_columns(one))
    quantities = {quantity.name: quantity_key(quantity) for quantity in case.quantities}
    wanted = (*OF_A_RUN, *parameters, *quantities.values())
    missing = [name for name in wanted if name not in (reader.fieldnames or ())]
    if missing:
        raise RequestError(
            f"{where}: no column {' and '.join(missing[:3])}; must be the runs.csv of a study of "
            f"{case.name}"
        )
    found: dict[Key, Measured] = {}
    for number, row in enumerate(reader, start=2):
        if row["status"] != DONE:
            continue
        told = f"{where}, row {number}"
        if None in row or None in row.values():
            raise RequestError(f"{told}: has not as many values as there are columns")
        values = {name: _number(row, column, told) for name, column in quantities.items()}
        key = tuple(_plain(row[name]) for name in ("engine", "ranks", *parameters))
        who = Provenance(row["engine"], row["engine_version"])
        kept = {name: value for name, value in values.items() if value is not None}
        found[key] = Measured(kept, who, _number(row, "wall_time_s", told) or 0.0)
    return EarlierRuns(found)


def _number(row: Mapping[str, str], column: str, told: str) -> float | None:
    text = row[column]
    if not text:
        return None
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RequestError(f"{told}: {column} = {text[:40]!r} must be a finite number")
    return value


def _key(engine: str, ranks: int, one: Parameters) -> Key:
    return tuple(_plain(value) for value in (engine, ranks, *parameter_columns(one).values()))


def _plain(value: Any) -> str:
    """Return a value as it is compared: 8 and 8.0 are one, None is an empty cell."""
    text = "" if value is None else str(value)
    try:
        return repr(float(text))
    except ValueError:
        return text
