"""Runs of an earlier study, of this machine or another, from its runs.csv: not made again."""

from __future__ import annotations

import csv
import hashlib
import io
import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from harness.cases.contract import Case, Measured
from harness.engines.registry import engine_class
from harness.errors import EngineMissingError, EngineUndecidedError, HarnessError, RequestError
from harness.observables.provenance import Provenance
from harness.parameters.base import Parameters
from harness.workflows.sweep_local import Executor, Ran, Work
from harness.workflows.sweep_run import DONE, UNDECIDED, parameter_columns, quantity_key

OF_A_RUN = ("engine", "engine_version", "ranks", "script", "status", "wall_time_s")
"""Columns beside parameters and quantities that a run is known by."""

RESTARTS = re.compile(r"^#> restarts\n.*?^#< restarts\n", re.MULTILINE | re.DOTALL)
"""Marks in a script, and the lines between them: how a run that was cut goes on."""

FURTHER = {"arm", "reason"}
LARGEST = 2**28
"""[bytes] of a file."""

Key = tuple[str, ...]


@dataclass(frozen=True)
class EarlierRuns:
    """The runs of a file that were done or are undecided, by engine, ranks and parameters."""

    rows: Mapping[Key, Measured | EngineUndecidedError]

    def count(self, engine: str, ranks: int, runs: Iterable[Parameters]) -> int:
        """Return how many of some runs are there."""
        return sum(_key(engine, ranks, one) in self.rows for one in runs)

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
                for place, ran in _made(executor, work, missing):
                    yield place, ran

        return run


def _made(executor: Executor, work: Work, places: Sequence[int]) -> Iterator[tuple[int, Ran]]:
    """Yield runs that are made; where some were known, an engine that is not here fails the rest.

    Where none was, it is raised.
    """
    left = replace(work, parameters=[work.parameters[place] for place in places])
    told: set[int] = set()
    try:
        for place, ran in executor(left):
            told.add(places[place])
            yield places[place], ran
    except (EngineMissingError, RequestError) as error:
        if len(places) == len(work.parameters):
            raise
        failed: HarnessError = error
        yield from ((place, failed) for place in places if place not in told)


def script_digest(case: Case[Any], engine: str) -> str:
    """Return a digest of the script that an engine runs for a case: another one is another run.

    Without what a script has between :data:`RESTARTS`, which does nothing in a run that writes no
    restart file.
    """
    inputs = engine_class(engine).inputs([case.template])
    texts = {name: RESTARTS.sub("", text) for name, text in inputs.items()}
    return hashlib.sha256(repr(sorted(texts.items())).encode()).hexdigest()[:12]


def read_runs(path: Path, case: Case[Any], one: Parameters) -> EarlierRuns:
    """Return the runs of a case in a file; ``one`` is an example of its parameters.

    Raise RequestError in a line for a file that cannot be read, has no such columns, or a value
    that is no number.
    """
    where = f"--runs {path}"
    rows = csv.DictReader(io.StringIO(_text(path, where)))
    try:
        parameters = tuple(parameter_columns(one))
        quantities = {quantity.name: quantity_key(quantity) for quantity in case.quantities}
        _check_columns(rows.fieldnames or (), (*OF_A_RUN, *parameters, *quantities.values()), where)
        scripts: dict[str, str] = {}
        found: dict[Key, Measured | EngineUndecidedError] = {}
        results: dict[Key, tuple[str, Measured]] = {}
        for number, row in enumerate(rows, start=2):
            told = f"{where}, row {number}"
            if None in row or None in row.values():
                raise RequestError(f"{told}: has not as many values as there are columns")
            if row["status"] not in (DONE, UNDECIDED):
                continue
            _check_script(row, case, scripts, told)
            key = tuple(_plain(row[name]) for name in ("engine", "ranks", *parameters))
            values = {name: _number(row, column, told) for name, column in quantities.items()}
            kept = {name: value for name, value in values.items() if value is not None}
            who = Provenance(row["engine"], row["engine_version"])
            ranks = int(_number(row, "ranks", told) or 1)
            ran = Measured(kept, who, _number(row, "wall_time_s", told) or 0.0, ranks)
            result = row["status"], ran
            if results.setdefault(key, result) != result:
                raise RequestError(f"{told}: the run of another row with another result")
            found[key] = ran if row["status"] == DONE else _undecided(ran, row)
    except csv.Error as error:
        raise RequestError(f"{where}: is no table ({error})") from None
    return EarlierRuns(found)


def _undecided(ran: Measured, row: Mapping[str, str]) -> EngineUndecidedError:
    error = EngineUndecidedError(row.get("reason") or "undecided", ran.values)
    error.provenance, error.seconds, error.ranks = ran.provenance, ran.seconds, ran.ranks
    return error


def _text(path: Path, where: str) -> str:
    try:
        if path.stat().st_size > LARGEST:
            raise RequestError(f"{where}: is longer than {LARGEST} bytes")
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise RequestError(f"{where}: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise RequestError(f"{where}: is no UTF-8 text") from None


def _check_columns(names: Sequence[str], wanted: Sequence[str], where: str) -> None:
    """Raise RequestError for a column that is missing, or that might tell runs apart."""
    missing = [name for name in wanted if name not in names]
    further = [name for name in names if name not in {*wanted, *FURTHER}]
    if missing or further:
        what = f"no column {missing[0]}" if missing else f"an unknown column {further[0]}"
        raise RequestError(f"{where}: {what}; must be the runs.csv of a study by this version")


def _check_script(
    row: Mapping[str, str], case: Case[Any], scripts: dict[str, str], told: str
) -> None:
    """Raise RequestError for a run by another script than the engine's own now."""
    engine = row["engine"]
    if engine not in scripts:
        scripts[engine] = script_digest(case, engine)
    if row["script"] != scripts[engine]:
        raise RequestError(
            f"{told}: script = {row['script'][:20]!r}: was made by another script of {case.name}; "
            f"this version's is {scripts[engine]!r}"
        )


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
