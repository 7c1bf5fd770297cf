"""Read the tables of one engine's baseline; the error for a damaged line names it."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import TypeVar

import numpy as np

from harness.comparison.baseline_record import BaselineRecord, Quantity
from harness.comparison.divergence import Series
from harness.errors import RequestError
from harness.store.baseline_tables import (
    BETWEEN,
    HEAD,
    OF_QUANTITY,
    OF_RUN,
    SERIES,
    SERIES_HEAD,
    TABLE,
    count_of,
)
from harness.store.bounded_text import bounded_text
from harness.store.parameter_text import parameters_of

T = TypeVar("T")


def read_tables(table: Path) -> list[BaselineRecord]:
    """Return the records of an engine's table, with the series of the file beside it.

    Raise RequestError, naming file and line, where one is damaged or they do not go together.
    """
    engine, beside = table.name.removesuffix(TABLE), table.with_name(table.stem + SERIES)
    records, samples = _read(table, HEAD, lambda lines: _records(lines, engine))
    series: Mapping[str, Series] = {}
    if beside.exists() or any(samples.values()):
        series = _read(beside, SERIES_HEAD, _series)
    found = {name: count_of(one) for name, one in series.items()}
    for name in sorted({*found, *(name for name, count in samples.items() if count)}):
        if found.get(name, 0) != samples.get(name, 0):
            why = f"{found.get(name, 0)} samples of {name}, the table has {samples.get(name, 0)}"
            raise _damaged(beside, why)
    return [replace(record, series=series.get(record.name)) for record in records]


@dataclass(frozen=True)
class _Line:
    """A line of a table: its number in the file, and its cells by the head."""

    number: int
    cells: Mapping[str, str]


class _DamagedError(ValueError):
    """What is wrong with a line."""

    def __init__(self, line: _Line, why: object) -> None:
        super().__init__(f"line {line.number}: {why}")


def _read(path: Path, head: Sequence[str], read: Callable[[list[_Line]], T]) -> T:
    try:
        text = bounded_text(path)
        return read(_lines(text, head))
    except OSError as error:
        raise _damaged(path, error.strerror or error) from None
    except (ValueError, csv.Error) as error:
        raise _damaged(path, error) from None


def _damaged(path: Path, why: object) -> RequestError:
    return RequestError(
        f"baseline file {path} is damaged: {why}; restore it, or remove it and accept a new one"
    )


def _lines(text: str, head: Sequence[str]) -> list[_Line]:
    if not text.endswith("\n"):
        raise ValueError(f"line {text.count(chr(10)) + 1}: it ends in the middle")
    reader = csv.reader(io.StringIO(text), strict=True)
    if next(reader, None) != list(head):
        raise ValueError(f"line 1: the head is not {','.join(head)}")
    found = []
    for cells in reader:
        if len(cells) != len(head):
            raise ValueError(f"line {reader.line_num}: {len(cells)} cells for {len(head)} columns")
        found.append(_Line(reader.line_num, dict(zip(head, cells, strict=True))))
    return found


def _records(lines: list[_Line], engine: str) -> tuple[list[BaselineRecord], dict[str, int]]:
    """Return the records of a table, and how many samples the series of each has."""
    found: dict[str, BaselineRecord] = {}
    samples: dict[str, int] = {}
    for name, group in groupby(lines, lambda line: line.cells["record"]):
        first, *others = group
        if name in found:
            raise _DamagedError(first, f"record {name} comes twice")
        shared = [cell for cell in HEAD if cell not in OF_QUANTITY]
        for line in others:
            if any(line.cells[cell] != first.cells[cell] for cell in shared):
                raise _DamagedError(line, f"it is not of the record {name} above it")
        found[name] = _record(first, [first, *others], engine)
        samples[name] = int(_number(first, "samples"))
    return list(found.values()), samples


def _record(first: _Line, lines: list[_Line], engine: str) -> BaselineRecord:
    cells = first.cells
    if not cells["record"].startswith(f"{engine}/"):
        raise _DamagedError(first, f"record {cells['record']!r} is not of engine {engine}")
    try:
        parameters = parameters_of(cells["parameters"])
    except ValueError as error:
        raise _DamagedError(first, f"parameters: {error}") from None
    quantities: dict[str, Quantity] = {}
    for line in lines:
        name = line.cells["quantity"]
        if not name or name in quantities:
            raise _DamagedError(line, f"quantity {name!r} comes twice, or has no name")
        quantities[name] = Quantity(
            _number(line, "value"), _number(line, "uncertainty"), line.cells["unit"]
        )
    return BaselineRecord(
        name=cells["record"],
        parameters=parameters,
        quantities=quantities,
        engine=engine,
        levels=tuple(cells["levels"].split()),
        case=cells["case"],
        label=cells["label"],
        family=tuple(cells["family"].split(BETWEEN)) if cells["family"] else (),
        **{key: cells[key] for key in OF_RUN},  # type: ignore[arg-type]
    )


def _number(line: _Line, name: str) -> float:
    try:
        value = float(line.cells[name])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise _DamagedError(line, f"{name} = {line.cells[name]!r} is not a finite number")
    return value


def _series(lines: list[_Line]) -> dict[str, Series]:
    """Return the series of each record; all columns of one are over the same times."""
    columns: dict[str, dict[str, list[_Line]]] = {}
    for line in lines:
        of_record = columns.setdefault(line.cells["record"], {})
        of_record.setdefault(line.cells["column"], []).append(line)
    return {name: _one_series(of_record) for name, of_record in columns.items()}


def _one_series(columns: Mapping[str, list[_Line]]) -> Series:
    times = [np.array([_number(line, "time_s") for line in c]) for c in columns.values()]
    for lines, time in zip(columns.values(), times, strict=True):
        if time.size < 2 or np.any(np.diff(time) <= 0.0):
            raise _DamagedError(lines[0], "fewer than two samples, or out of order")
        if not np.array_equal(time, times[0]):
            raise _DamagedError(lines[0], "a column is not over the times of the others")
    values = {n: np.array([_number(line, "value") for line in c]) for n, c in columns.items()}
    return Series(times[0], values)
