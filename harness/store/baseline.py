"""The committed baseline: a table of records and one of series for each engine, and known defects.

``<engine>.csv`` has a line for each quantity of each record, sorted and exact to the last bit;
``<engine>.series.csv`` a line for each sample. Parameters are one line of text, ``contact.tail =
attractive; height = 17; step_s = 1e-06``: names of nested parameters joined by dots, sorted; a
value as JSON, a text without its quotes where nothing else could be meant.

The committed tables lie in ``reports/baseline`` of the project, known defects in ``inputs``; a
wheel carries them in ``harness/store/committed``. A checkout's own come first.
"""

from __future__ import annotations

import csv
import errno
import io
import json
import math
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import harness
from harness.comparison.known_defects import KnownDefect
from harness.comparison.regression import Baseline, BaselineRecord
from harness.comparison.series import Series
from harness.errors import RequestError
from harness.observables.row import Row
from harness.parameters.base import nested
from harness.store.entries import digest_of_files

LONGEST = 2**27
"""Bytes: the results of the longest verification are a hundredth of it."""


def bounded_text(path: Path, longest: int = LONGEST) -> str:
    """Return a file's text; raise OSError for one that is too long, UnicodeDecodeError."""
    with path.open("rb") as file:
        data = file.read(longest + 1)
    if len(data) > longest:
        raise OSError(errno.EFBIG, f"is longer than {longest} bytes")
    return data.decode("utf-8")


SEPARATOR, EQUALS = "; ", " = "

_NAME = re.compile(r"[^\s.=;]+")
_PLAIN = re.compile(r"[^\W\d_][\w ,.+/()-]*(?<! )")
_WORDS = frozenset({"true", "false", "null", "NaN", "Infinity"})


def parameter_text(parameters: Mapping[str, Any]) -> str:
    """Return parameters as text; raise ValueError for a name or value that it cannot state."""
    return SEPARATOR.join(f"{name}{EQUALS}{value}" for name, value in _flat(parameters, ""))


def parameters_of(text: str) -> dict[str, Any]:
    """Return the parameters of a text; raise ValueError where it is damaged."""
    return nested(map(_parameter, text.split(SEPARATOR) if text else []))


def _parameter(part: str) -> tuple[str, Any]:
    name, equals, value = part.partition(EQUALS)
    if not equals:
        raise ValueError(f"{part!r} is no parameter")
    return name, value if _is_plain(value) else json.loads(value)


def _flat(parameters: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, str]]:
    for name, value in sorted(parameters.items()):
        if not _NAME.fullmatch(name):
            raise ValueError(f"{name!r} is no name of a parameter")
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, _text(value)


def _text(value: Any) -> str:
    if isinstance(value, str) and _is_plain(value):
        return value
    text = json.dumps(value, ensure_ascii=False, sort_keys=True, allow_nan=False)
    # inside a JSON text, a semicolon stands in a string
    return text.replace(";", "\\u003b")


def _is_plain(text: str) -> bool:
    return bool(_PLAIN.fullmatch(text)) and text not in _WORDS


TABLE, SERIES = ".csv", ".series.csv"

DIGITS = 12
"""Of a series: ten times finer than the narrowest band."""

OF_QUANTITY = ("quantity", "unit", "value", "uncertainty")
OF_RUN = ("engine_version", "how", "platform", "script", "script_sha256")
HEAD = (
    *("case", "record", "label", "parameters", "levels"),
    *OF_QUANTITY,
    *("family", "samples", *OF_RUN),
)
SERIES_HEAD = ("record", "column", "time_s", "value")
BETWEEN = "|"
"""Between the parts of a family."""

_ENGINE = re.compile(r"(?!.*\.series$)[A-Za-z0-9][\w.+-]*")


def table_texts(records: Iterable[BaselineRecord], engine: str) -> dict[str, str]:
    """Return the files of an engine's records as texts, by their names; none for no records.

    Raise RequestError for an engine whose name is none of a file, and for what a table
    cannot hold.
    """
    if not _ENGINE.fullmatch(engine):
        raise RequestError(f"baseline: engine {engine!r}: the name cannot be that of a file")
    chosen = sorted(records, key=lambda record: (record.case, record.name))
    if not chosen:
        return {}
    texts = {engine + TABLE: _csv_text(HEAD, (row for record in chosen for row in _rows(record)))}
    with_series = [record for record in chosen if record.series is not None]
    if with_series:
        rows = (row for record in with_series for row in _samples(record))
        texts[engine + SERIES] = _csv_text(SERIES_HEAD, rows)
    return texts


def same_text(first: BaselineRecord, second: BaselineRecord) -> bool:
    """Return whether two records of an engine would be written alike."""
    return list(_rows(first)) == list(_rows(second)) and same_series(first, second)


def same_series(first: BaselineRecord, second: BaselineRecord) -> bool:
    """Return whether the series of two records would be written alike."""
    return list(_samples(first)) == list(_samples(second))


def _csv_text(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return stream.getvalue()


def _rows(record: BaselineRecord) -> Iterator[list[str]]:
    if any(BETWEEN in part for part in record.family):
        raise RequestError(f"baseline: {record.name}: {BETWEEN!r} in its family")
    cells = {
        "case": record.case,
        "record": record.name,
        "label": record.label,
        "parameters": parameter_text(record.parameters),
        "levels": " ".join(sorted(record.levels)),
        "family": BETWEEN.join(record.family),
        "samples": str(count_of(record.series.thinned()) if record.series else 0),
        **{key: getattr(record, key) for key in OF_RUN},
    }
    for name, quantity in sorted(record.quantities.items()):
        of_quantity = {
            "quantity": name,
            "unit": quantity.unit,
            "value": repr(float(quantity.value)),
            "uncertainty": repr(float(quantity.uncertainty)),
        }
        yield [({**cells, **of_quantity})[key] for key in HEAD]


def count_of(series: Series) -> int:
    """Return how many lines the samples of a series take."""
    return series.time.size * len(series.columns)


def _samples(record: BaselineRecord) -> Iterator[list[str]]:
    if record.series is None:
        return
    thin = record.series.thinned()
    for name, column in thin.columns.items():
        for time, value in zip(thin.time, column, strict=True):
            yield [record.name, name, _short(time), _short(value)]


def _short(value: float) -> str:
    return f"{value + 0.0:.{DIGITS}g}"


T = TypeVar("T")


def read_tables(table: Path) -> list[BaselineRecord]:
    """Return the records of an engine's table, with their series from the second file.

    Raise RequestError, naming file and line, where one is damaged or they do not go together.
    """
    engine, series_file = table.name.removesuffix(TABLE), table.with_name(table.stem + SERIES)
    records, samples = _read(table, HEAD, lambda lines: _records(lines, engine))
    series: Mapping[str, Series] = {}
    if series_file.exists() or any(samples.values()):
        series = _read(series_file, SERIES_HEAD, _series)
    counts = {name: count_of(of_record) for name, of_record in series.items()}
    for name in sorted({*counts, *(name for name, count in samples.items() if count)}):
        if counts.get(name, 0) != samples.get(name, 0):
            why = f"{counts.get(name, 0)} samples of {name}, the table has {samples.get(name, 0)}"
            raise _damaged(series_file, why)
    return [replace(record, series=series.get(record.name)) for record in records]


@dataclass(frozen=True)
class _Line:
    number: int
    cells: Mapping[str, str]


class _DamagedError(ValueError):
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
    lines = []
    for cells in reader:
        if len(cells) != len(head):
            raise ValueError(f"line {reader.line_num}: {len(cells)} cells for {len(head)} columns")
        lines.append(_Line(reader.line_num, dict(zip(head, cells, strict=True))))
    return lines


def _records(lines: list[_Line], engine: str) -> tuple[list[BaselineRecord], dict[str, int]]:
    records: dict[str, BaselineRecord] = {}
    samples: dict[str, int] = {}
    for name, group in groupby(lines, lambda line: line.cells["record"]):
        first, *others = group
        if name in records:
            raise _DamagedError(first, f"record {name} comes twice")
        shared = [cell for cell in HEAD if cell not in OF_QUANTITY]
        for line in others:
            if any(line.cells[cell] != first.cells[cell] for cell in shared):
                raise _DamagedError(line, f"it is not of the record {name} above it")
        records[name] = _record(first, [first, *others], engine)
        samples[name] = int(_number(first, "samples"))
    return list(records.values()), samples


def _record(first: _Line, lines: list[_Line], engine: str) -> BaselineRecord:
    cells = first.cells
    if not cells["record"].startswith(f"{engine}/"):
        raise _DamagedError(first, f"record {cells['record']!r} is not of engine {engine}")
    try:
        parameters = parameters_of(cells["parameters"])
    except ValueError as error:
        raise _DamagedError(first, f"parameters: {error}") from None
    quantities: dict[str, Row] = {}
    for line in lines:
        name = line.cells["quantity"]
        if not name or name in quantities:
            raise _DamagedError(line, f"quantity {name!r} comes twice, or has no name")
        quantities[name] = Row(
            name, _number(line, "value"), _number(line, "uncertainty"), line.cells["unit"]
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


KNOWN_DEFECTS = "known-defects.toml"
"""File of ``inputs``."""


def committed_file(name: str) -> Path | None:
    """Return a file of ``inputs`` that came with this harness, None if there is none."""
    package = Path(harness.__file__).parent
    files = (package.parent / "inputs" / name, package / "store" / "committed" / name)
    return next((file for file in files if file.is_file()), None)


def digest_of(folder: Path) -> str:
    """Return the digest of a baseline's files; that of no file where there is none."""
    return digest_of_files(sorted(folder.glob(f"*{TABLE}")), folder)


def digest(folder: Path | None) -> dict[str, str | None]:
    """Return the digests of a baseline and of the known defects, None where there is none.

    The committed baseline unless given. They stand for all that a comparison depends on besides
    the runs.
    """
    where = folder or committed()
    defects = committed_file(KNOWN_DEFECTS)
    return {
        "folder": digest_of(where) if where else None,
        "known_defects": digest_of_files([defects], defects.parent) if defects else None,
    }


def read_baseline(folder: Path) -> Baseline:
    """Return the baseline of a folder.

    Raise RequestError, naming file and line, for a folder that is not there and a
    file that is damaged.
    """
    if not folder.is_dir():
        raise RequestError(f"--baseline {folder}: no such folder")
    records: dict[str, BaselineRecord] = {}
    for table in tables_in(folder):
        records |= {record.name: record for record in read_tables(table)}
    return Baseline(records, str(folder), digest_of(folder))


# ---- known defects

DEFECTS = "reports/defects/"
"""Where the scripts lie in a checkout."""


def script_of(defect: KnownDefect) -> str:
    """Return the script that shows a defect, of the project or of the wheel; empty without one."""
    package = Path(harness.__file__).parent
    files = [package.parent / defect.script]
    if defect.script.startswith(DEFECTS):
        below = defect.script.removeprefix(DEFECTS)
        files.append(package / "store" / "committed" / "defects" / below)
    return next((file.read_text(encoding="utf-8") for file in files if file.is_file()), "")


def known_defects(path: Path | None = None) -> tuple[KnownDefect, ...]:
    """Return the defects of a file, the committed one unless given; none where there is no file.

    Each is a table ``[defect.NAME]`` with the fields of
    :class:`~harness.comparison.known_defects.KnownDefect`. Raise RequestError, naming file and
    defect, for anything else.
    """
    path = path or committed_file(KNOWN_DEFECTS)
    if path is None:
        return ()
    label = f"known defects {path}"
    try:
        record = tomllib.loads(bounded_text(path))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else error
        raise RequestError(f"{label}: cannot be read: {reason}") from None
    tables = record.pop("defect", {})
    named = isinstance(tables, dict) and all(isinstance(table, dict) for table in tables.values())
    if record or not named:
        raise RequestError(f"{label}: holds tables [defect.NAME] and nothing else")
    defects = []
    for name, table in tables.items():
        try:
            defects.append(KnownDefect(**{**table, "name": name}))
        except RequestError as error:
            raise RequestError(f"{label}, [defect.{name}]: {error}") from None
    return tuple(defects)


def with_further(path: Path | None) -> tuple[KnownDefect, ...]:
    """Return the committed defects and those of a file; RequestError for a name of both."""
    committed = known_defects()
    if path is None:
        return committed
    further, names = known_defects(path), {defect.name for defect in committed}
    for defect in further:
        if defect.name in names:
            raise RequestError(
                f"--known-defects {path}, [defect.{defect.name}]: is known already; "
                "take another name"
            )
    return (*committed, *further)
